#!/usr/bin/env python3
"""Writes the manual page of a program from its help text and a template.  usage: man.py TEMPLATE PROGRAM VERSION PAGE

The template is mdoc(7), with replaced lines:

    @SYNOPSIS@     the usage lines of PROGRAM --help
    @DESCRIPTION@  the text below them
    @OPTIONS@      the options, under the headings of their groups
    @EXIT@         the text that begins with "Exit codes:"
    @COMMANDS@     the same parts of each PROGRAM COMMAND --help; options of `run` are described only in `run`
    @DATE@, @VERSION@   in a line of macros; the date is that of $SOURCE_DATE_EPOCH, or today
"""
import datetime
import os
import re
import subprocess
import sys
import textwrap

OPTION = re.compile(r"^ {2}(?:-.| {4}--)")
COMMON = {"-?, --help", "--usage", "-V, --version"}


class Help:
    """The parts of the help text that argp(3) prints: usage, text, groups [(heading, [(option, text)])], after, exit."""

    def __init__(self, text):
        self.usage, self.text, self.groups, self.after, self.exit = [], [], [("", [])], [], ""
        lines = text.splitlines()
        while lines and (match := re.match(r"(?:Usage:|  or:) *(.*)", lines[0], re.I)):
            self.usage.append(match[1])
            lines.pop(0)
        blocks = [self.text]
        for line in lines:
            self._line(line, blocks)
        self.text, after = paragraphs(self.text), paragraphs(self.after)
        self.exit = "".join(p for p in after if p.startswith("Exit codes:"))
        self.after = [p for p in after if not p.startswith(("Exit codes:", "Mandatory or optional arguments"))]

    def _line(self, line, blocks):
        options = self.groups[-1][1]
        heading = re.match(r"^ (\S.*):$", line)
        if OPTION.match(line):
            match = re.match(r"^ +(-.*?)(?: {2,}(\S.*))?$", line)
            options.append([match[1], match[2] or ""])
            blocks[0] = self.after
        elif heading:
            self.groups.append((heading[1], []))
            blocks[0] = self.after
        elif options and line.startswith(" " * 20):
            options[-1][1] += " " + line.strip()
        else:
            blocks[0].append(line)


def paragraphs(lines):
    return [" ".join(p.split()) for p in re.split(r"\n\s*\n", "\n".join(lines)) if p.strip()]


def escaped(text):
    return text.replace("\\", "\\e").replace("--", "\\-\\-")


def prose(text):
    """Text lines of mdoc, one for each sentence."""
    sentences = re.split(r"(?<=[.!?:;]) +(?=[A-Z$-])", escaped(text))
    lines = [line for one in sentences for line in textwrap.wrap(one, 78, break_long_words=False, break_on_hyphens=False)]
    return [("\\&" + line if line[0] in ".'" else line) for line in lines]


def argument(text):
    return "Ar \\&" + escaped(text)


def option(text):
    """An option's line, as -s, --socket=PATH or --realtime[=PRIO]."""
    words = []
    for name in text.split(", "):
        match = re.match(r"-(-?[\w?-]+)(?:(\[?)=(.*?)\]?$)?$", name)
        words.append("Fl " + match[1].replace("?", "\\&?"))
        if match[3]:
            value = f"= Ns {argument(match[3] + (']' if match[3].count('[') > match[3].count(']') else ''))}"
            words[-1] += f" Ns Oo {value} Oc" if match[2] else f" Ns {value}"
    return ".It " + " , ".join(words)


def synopsis(usage):
    """One line of usage: words in capitals are arguments, other words are literal."""
    program, *words = usage.split()
    found = [".Nm " + program]
    for word in words:
        if re.fullmatch(r"\[[^][]*\]", word):
            found.append(".Op " + argument(word[1:-1]))
        elif word.startswith("-"):
            found.append(".Fl " + (word[1:] if word != "--" else "-"))
        elif re.match(r"[a-z]+$", word):
            found.append(".Cm " + word)
        else:
            found.append("." + argument(word))
    return found


def options(groups):
    lines = []
    for title, rows in groups:
        rows = [row for row in rows if row[0] not in COMMON]
        if not rows:
            continue
        lines += [".Ss " + title] if title else []
        lines.append(".Bl -tag -width Ds")
        for name, text in rows:
            lines += [option(name), *prose(text)]
        lines.append(".El")
    return lines


def said_by(program, *words):
    done = subprocess.run([program, *words, "--help"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, check=True, text=True)
    return Help(re.sub(re.escape(program) + r"\b", os.path.basename(program), done.stdout))


def separated(blocks):
    """Paragraphs with .Pp between them."""
    return [line for i, block in enumerate(blocks) for line in ([".Pp"] if i else []) + prose(block)]


def commands(program):
    names = []
    text = subprocess.run([program, "--help"], stdout=subprocess.PIPE, check=True, text=True).stdout
    for name in re.findall(r"\bectwin +([a-z-]+)", text):
        if name not in names and not name.startswith("-"):
            names.append(name)
    helps = {name: said_by(program, name) for name in names}
    twins = {tuple(row) for title, rows in helps["run"].groups if title for row in rows if row[0] not in COMMON}
    lines = []
    for name, said in helps.items():
        lines.append(".Ss ectwin " + name)
        lines += [line for i, usage in enumerate(said.usage) for line in ([".br"] if i else []) + synopsis(usage)]
        lines += [".Pp", *separated(said.text)]
        own = [row for _, rows in said.groups for row in rows if tuple(row) not in twins]
        groups = said.groups if name == "run" else [("", own)]
        if name != "run" and len(own) < sum(len(rows) for _, rows in said.groups):
            lines += [".Pp", "The options of", ".Cm ectwin run", "that shape the twins are accepted, too."]
        chosen = options([(f"Options of run: {title}" if title else "", rows) for title, rows in groups])
        lines += chosen
        lines += [line for block in said.after + ([said.exit] if said.exit else []) for line in [".Pp", *prose(block)]]
    return lines


def page(template, program, version):
    said = said_by(program)
    date = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH") or datetime.datetime.now().timestamp()),
                                           datetime.timezone.utc)
    codes = re.sub(r"^Exit codes: *", "", said.exit)
    parts = {
        "@SYNOPSIS@": lambda: [line for usage in said.usage for line in synopsis(usage)],
        "@DESCRIPTION@": lambda: separated(said.text),
        "@OPTIONS@": lambda: options(said.groups) + [line for block in said.after for line in [".Pp", *prose(block)]],
        "@EXIT@": lambda: prose(codes),
        "@COMMANDS@": lambda: commands(program),
    }
    for line in template.splitlines():
        if line in parts:
            yield from parts[line]()
        elif line.startswith("."):
            yield line.replace("@DATE@", f"{date:%B} {date.day}, {date.year}").replace("@VERSION@", version)
        else:
            yield from prose(line)


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        template = file.read()
    text = "\n".join(page(template, os.path.abspath(sys.argv[2]), sys.argv[3])) + "\n"
    with open(sys.argv[4], "w", encoding="utf-8") as file:
        file.write(text)


main()
