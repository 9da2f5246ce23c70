#!/usr/bin/env python3
"""Refuses long files, long functions and functions of many branches.  usage: functions.py ROOT
                                                                            functions.py --self

The cyclomatic complexity of a function is 1, and 1 more for each if, for, while, switch, ?, && and ||: a switch counts once, however
many cases it has (the modified complexity of pmccabe). The limits are those of CONTRIBUTING.md. --self checks a tree that keeps each
limit and one that exceeds each by one.
"""
import pathlib
import re
import sys
import tempfile

TREES = ["src", "programs", "firmware", "examples", "tools"]
MOST_BRANCHES, MOST_LINES, LONGEST_FILE = 15, 100, 1000
FEWEST = 5000  # functions in this tree; with fewer the check has missed the sources

HIDDEN = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
BRANCH = re.compile(r"\b(?:if|for|while|switch)\b|\?|&&|\|\|")
ATTRIBUTE = re.compile(r"__attribute__\(\((?:[^()]|\([^()]*\))*\)\)")
DIRECTIVE = re.compile(r"^[ \t]*#(?:.*\\\n)*.*$", re.M)
FUNCTION = re.compile(r"^[a-zA-Z_][^;={}]*?(\w+)\([^;{}]*\)\s*\n\{[ \t]*\n(.*?)^\}", re.M | re.S)


def functions(text):
    """(name, first line, lines, complexity) of each function. In the layout of clang-format the braces of a function have no indent."""
    for hide, by in ((HIDDEN, " "), (DIRECTIVE, " "), (ATTRIBUTE, "_")):
        text = hide.sub(lambda m, by=by: re.sub(r"[^\n]", by, m[0]), text)
    for match in FUNCTION.finditer(text):
        yield match[1], text.count("\n", 0, match.start()) + 1, match[0].count("\n") + 1, 1 + len(BRANCH.findall(match[2]))


def check(root):
    """A line for each excess, and the number of functions."""
    wrong, count = [], 0
    for path in (p for tree in TREES for p in sorted((root / tree).rglob("*.[ch]"))):
        name, text = path.relative_to(root), path.read_text()
        lines = text.count("\n")
        if lines > LONGEST_FILE:
            wrong.append(f"{name}: {lines} lines, {LONGEST_FILE} are allowed: move what belongs together into a file of its own")
        for function, line, length, complexity in functions(text):
            count += 1
            if length > MOST_LINES:
                wrong.append(f"{name}:{line}: {function} has {length} lines, {MOST_LINES} are allowed: divide it")
            if complexity > MOST_BRANCHES:
                wrong.append(f"{name}:{line}: {function} has the complexity {complexity}, {MOST_BRANCHES} are allowed: divide it")
    return wrong, count


BRANCHES = """
/* if (a && b) */
puts("it's ? || while (1) \\" if");
#if A && B || \\
    C
    letter = '"' ? '?' : '\\'';
#endif
if (a && b || c)
    switch (a) {
    case 1:
    case 2:
        for (;;)
            call();
    }
while (a)
    call();
"""  # 8 with the function's own 1


def check_self():
    """Finds nothing in a tree that is at each limit, and each excess by one in a tree that has it."""
    def tree(more):
        branching = "__attribute__((format(printf, 1, 2))) static int branching(int a,\n    int b)\n{" + BRANCHES + "if (a)\n    call();\n" * (7 + more) + "}\n"
        long = "int *long_one(void)\n{\n" + "call();\n" * (97 + more) + "}\n"
        text = "int x;\n" + branching + "\n" + long
        with tempfile.TemporaryDirectory() as folder:
            for name in TREES:
                file = pathlib.Path(folder) / name / "room/a.c"
                file.parent.mkdir(parents=True)
                file.write_text(text + "int y;\n" * (LONGEST_FILE + more - text.count("\n")))
            return check(pathlib.Path(folder))

    wrong, count = tree(0)
    over, _ = tree(1)
    if count != 2 * len(TREES):
        wrong.append(f"{count} functions were found, not {2 * len(TREES)}")
    for name in TREES:
        for what in ("a.c: 1001 lines", "branching has the complexity 16", "long_one has 101 lines"):
            if not any(line.startswith(f"{name}/room/") and what in line for line in over):
                wrong.append(f"not found: {what} in {name}")
    return wrong


def main():
    if sys.argv[1] == "--self":
        wrong = check_self()
    else:
        wrong, count = check(pathlib.Path(sys.argv[1]).resolve())
        if count < FEWEST:
            wrong.append(f"only {count} functions were found: the check misses the sources")
    print("\n".join(wrong))
    return 1 if wrong else 0


sys.exit(main())
