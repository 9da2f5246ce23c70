#!/usr/bin/env python3
"""Finds English that reads as translated, in comments, pages and texts that users see.  usage: english.py ROOT [PATH...]

With PATH: those files and folders; without: the whole tree. Three kinds of finding:

    start   a sentence that begins with What, Who, Those, Of, Where or Also, or a string of C that begins with what, who, where or
            also, or has one of these words behind "ID: ", as titles of tests: the subject is the name of a thing
    word    a word that the project has a better term for (WORDS)
    person  a pronoun for a person: a program, a master or a client is "it"

Checked are comments of C, CMake, shell and Python, docstrings, Markdown outside code, and strings of C that hold a sentence
(help texts, errors, test titles). An exception is a line of tests/check/english.txt: FILE: TEXT  # reason.
"""
import pathlib
import re
import subprocess
import sys
import tokenize

# Folders and files that stay clean: the whole tree, so that new files are covered. Files without a reader (READERS) have no prose.
CLEAN = ["."]

START = re.compile(r"(?:^|(?<=[.!?]\s)|(?<=[.!?]\s\s))(?:[-*] |\d+\. |> )?(What|Who|Those|Of|Where|Also)(?= \w+ \w)[^.!?]*")
WORDS = [
    (r"by lot\b|\blots?\b(?! (?:of|more|less)\b)", "at random"),
    (r"\b(?:go|goes|went|going) round\b", "loop, circulate, wrap"),
    (r"\banew\b", "again"),
    (r"\b(?:look|looks|looked|looking) at\b", "read, check, examine"),
    (r"\b(?:tell|tells|told|telling)\b", "report, notify, write, name"),
    (r"\b(?:is|are|was|were|be|been) asked\b", "is read, is called, is queried"),
    (r"\b(?:stand|stands|stood)\b(?! (?:for|in for|alone|still)\b)", "is, lies, holds"),
    (r"\b(?:say|says|said)\b", "report, state, define"),
    (r"\btime-outs?\b|\btime outs?\b", "timeout"),
    (r"\bways? around\b", "workaround"),
    (r"\bof ours\b", "ectwin's, this project's"),
    (r"\bput(?:s|ting)? (?:it |them )?back\b", "restore, reinsert"),
    (r"\btaken for\b", "regarded as"),
    (r"\bwhy not\b", "the reason of a refusal, of a failure"),
    (r"\bone behind (?:the other|another)\b", "successive, in succession"),
    (r"\bdo(?:es)? no harm\b", "has no effect"),
    (r"\bcomes? of it\b", "result"),
    (r"\ba (?:bit|line|byte|letter|step|comparison|row) an? (?!read\b|write\b|to z\b)[a-z]+\b", "one … for each …"),
    (r"\bnobody\b", "no file, no caller, nothing (name it)"),
    (r"\b(?:he|him|his|she|her|hers)\b", "it, its"),
]
WORD = re.compile("|".join(f"(?P<w{i}>{pattern})" for i, (pattern, _) in enumerate(WORDS)), re.I)

TITLE = re.compile(r"^(?:[A-Z][\w ,-]*: (?=of |those )|(?:[A-Z][\w ,-]*: )?(?=what |who |where |also ))([a-z])")
C_TOKEN = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)


def c_texts(text):
    """(line, prose) of each comment, and of each run of adjacent strings that is a sentence."""
    run, run_line, end = [], 0, 0
    for match in C_TOKEN.finditer(text):
        token, line = match[0], text.count("\n", 0, match.start()) + 1
        if token[0] == '"':
            if run and text[end:match.start()].strip() not in ("", "\\"):
                yield from sentence(run_line, "".join(run))
                run = []
            run_line = run_line if run else line
            run.append(token[1:-1].replace("\\n", "\n").replace('\\"', '"'))
            end = match.end()
        elif token[0] == "/":
            yield line, re.sub(r"^[ \t]*(?:/\*+<?|\*+/|\*|//)[ \t]?|\*/$", "", token, flags=re.M)
    if run:
        yield from sentence(run_line, "".join(run))


def sentence(line, string):
    """A string with a space between words is prose, and its first letter that of a sentence; a format or a name is not."""
    if re.search(r"[A-Za-z]{2,} [a-z]{2,} [a-z]{2,}", string):
        yield line, TITLE.sub(lambda match: match[1].upper(), string)


def hash_texts(text):
    """Comments after #, a block of lines as one text."""
    block, start = [], 0
    for number, line in enumerate(text.splitlines() + [""], 1):
        match = re.match(r"^\s*#(?!!)\s?(.*)$", line) or re.search(r"\s#\s(.*)$", line)
        if match and (not block or line.lstrip().startswith("#")):
            start = start if block else number
            block.append(match[1])
        elif block:
            yield start, "\n".join(block)
            block = []


def python_texts(text):
    yield from hash_texts(text)
    for token in tokenize.generate_tokens(iter(text.splitlines(keepends=True)).__next__):
        if token.type == tokenize.STRING and token.string.lstrip("rbfRBF").startswith('"""'):
            yield token.start[0], token.string.strip('rbf"')


def markdown_texts(text):
    """Paragraphs, list items and table cells; code and links' targets are left out."""
    fence = False
    paragraph, start = [], 0
    for number, line in enumerate(text.splitlines() + [""], 1):
        if line.lstrip().startswith("```"):
            fence = not fence
            line = ""
        if fence or line.startswith("    ") and not paragraph:
            line = ""
        line = re.sub(r"`[^`]*`", "CODE", line)
        line = re.sub(r"\]\([^)]*\)", "]", line)
        if not line.strip() or line.startswith(("#", "|")) or re.match(r"\s*(?:[-*]|\d+\.) ", line):
            if paragraph:
                yield start, "\n".join(paragraph)
                paragraph = []
        if line.startswith("|"):
            for cell in line.strip("|").split("|"):
                yield number, cell.strip()
        elif line.startswith("#"):
            yield number, line.lstrip("# ")
        elif line.strip():
            start = start if paragraph else number
            paragraph.append(line.strip())


READERS = {".c": c_texts, ".h": c_texts, ".py": python_texts, ".sh": hash_texts, ".md": markdown_texts, ".cmake": hash_texts,
           "CMakeLists.txt": hash_texts, ".yml": hash_texts}


def reader(path):
    if path.name in READERS:
        return READERS[path.name]
    if path.suffix in READERS:
        return READERS[path.suffix]
    first = path.open("rb").readline(80) if path.suffix == "" else b""
    return hash_texts if first.startswith(b"#!") and b"sh" in first else None


def findings(line, prose):
    """(line, kind, text, hint) of one text."""
    flat = re.sub(r"\s*\n\s*(?=[^\s@\\])", " ", prose)
    for paragraph in re.split(r"\n\s*\n", prose):
        at = line + prose[:prose.find(paragraph)].count("\n")
        joined = re.sub(r"\s+", " ", paragraph).strip()
        joined = re.sub(r"@(?:return|param(?:\[\w+\])? \w+|retval \w+|brief)\s*", "", joined)
        for match in START.finditer(joined):
            yield at, "start", match[0][:60], "begin with the thing's name"
    for match in WORD.finditer(flat):
        index = int(match.lastgroup[1:])
        kind = "person" if index == len(WORDS) - 1 else "word"
        yield line + flat[:match.start()].count("\n"), kind, flat[max(0, match.start() - 25):match.end() + 25].strip(), WORDS[index][1]


def check(path, root, exceptions):
    count = 0
    read = reader(path)
    if read is None:
        return 0
    name = str(path.relative_to(root))
    for line, prose in read(path.read_text()):
        for at, kind, text, hint in findings(line, prose):
            if any(name == file and piece in text for file, piece in exceptions):
                continue
            count += 1
            print(f"{name}:{at}: {kind}: \"{text}\" ({hint})")
    return count


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    places = sys.argv[2:] or CLEAN
    listed = subprocess.run(["git", "-C", root, "ls-files", "--cached", "--others", "--exclude-standard", "--",
                             *(str((pathlib.Path(p) if sys.argv[2:] else root / p).resolve()) for p in places)],
                            capture_output=True, text=True, check=True).stdout.splitlines()
    exceptions = []
    for line in (root / "tests/check/english.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            file, _, rest = line.partition(": ")
            exceptions.append((file, rest.rsplit("  # ", 1)[0]))
    if not listed:
        print(f"english: no file of {', '.join(places)} is in the tree")
        return 1
    count = sum(check(root / name, root, exceptions) for name in listed if (root / name).is_file())
    if count:
        print(f"{count} findings; the rules are in CONTRIBUTING.md")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
