#!/usr/bin/env python3
"""Checks what one can hold in one's head: no file of include/udar and src above 600 lines, no class with more than 20
data members of its own. Functions are clang-tidy's affair (readability-function-*).

Members are counted in the text as clang-format leaves it: what ends with `;` right inside a class and is no function,
type, alias or static; `double a, b;` are two.

Usage: check_sizes.py SOURCE_DIR [--list]. Prints what is too large, with --list the largest, too; the exit code is
whether there is any.
"""

import re
import sys
from pathlib import Path

MOST_LINES = 600
MOST_MEMBERS = 20

# Comments, strings, characters and the preprocessor's lines.
NOISE = re.compile(
    r"//[^\n]*|/\*.*?\*/|\"(?:[^\"\\\n]|\\.)*\"|'(?:[^'\\\n]|\\.)*'|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*",
    re.DOTALL | re.MULTILINE,
)
ALIGNMENT = re.compile(r"\balignas\s*\([^)]*\)")
CLASS = re.compile(r"\b(?:class|struct|union)\s+(\w+)?[^;(){}=]*$")
NO_MEMBER = re.compile(
    r"^\s*(?:template\b.*>\s*)?(?:static|using|friend|typedef|enum|class|struct|union|static_assert)\b|\boperator\b",
    re.DOTALL,
)
BRACKETS = re.compile(r"<[^<>]*>|\{[^{}]*\}|\[[^\[\]]*\]")


def blank(match):
    """As many lines, and nothing on them."""
    return re.sub(r"[^\n]", " ", match.group())


def members_of(statement):
    """How many data members a statement right inside of a class declares."""
    text = re.sub(r"\b(?:public|private|protected)\s*:", "", statement)
    text = ALIGNMENT.sub("", re.sub(r"\[\[.*?\]\]", "", text)).strip()
    if not text or NO_MEMBER.search(text):
        return 0
    text = re.sub(r"->|<=|>=", "", text)
    while BRACKETS.search(text):
        text = BRACKETS.sub("", text)
    text = re.sub(r"=[^,;]*\([^()]*\)", "", text)
    return 0 if "(" in text.split("=")[0] else len(text.split(","))


def classes(text):
    """(name, line, data members) of each class of a file."""
    text = ALIGNMENT.sub(blank, NOISE.sub(blank, text))
    scopes = []  # of open braces: [name, line, members] of a class, "value" of an initialiser, None of anything else
    start = 0  # of the statement
    for at, char in enumerate(text):
        inside = scopes[-1] if scopes else None
        if char == "{":
            head = text[start:at]
            found = CLASS.search(head) if "(" not in head else None
            if found:
                scopes.append([found.group(1) or "(unnamed)", text.count("\n", 0, at) + 1, 0])
                start = at + 1
            elif inside == "value" or (inside and "(" not in head.split("=")[0] and not NO_MEMBER.search(head)):
                scopes.append("value")
            else:
                scopes.append(None)
                start = at + 1
        elif char == "}" and scopes:
            closed = scopes.pop()
            if isinstance(closed, list):
                yield tuple(closed)
            if closed != "value":
                start = at + 1
        elif char == ";" and inside != "value":
            if isinstance(inside, list):
                inside[2] += members_of(text[start:at])
            start = at + 1


def main():
    source_dir = Path(sys.argv[1])
    paths = sorted(path for top in ("include/udar", "src") for path in (source_dir / top).rglob("*.[ch]pp"))
    sizes = []  # (size, limit, place and unit)
    for path in paths:
        text = path.read_text(encoding="utf-8")
        name = path.relative_to(source_dir)
        sizes.append((text.count("\n"), MOST_LINES, f"{name}: lines"))
        sizes += [(size, MOST_MEMBERS, f"{name}:{line}: data members of {kind}") for kind, line, size in classes(text)]
    too_large = [entry for entry in sizes if entry[0] > entry[1]]
    for size, limit, what in too_large:
        print(f"{what}: {size}, at most {limit}")
    if "--list" in sys.argv:
        for limit in (MOST_LINES, MOST_MEMBERS):
            for size, _, what in sorted((entry for entry in sizes if entry[1] == limit), reverse=True)[:10]:
                print(f"{size:5} {what}")
    print(f"{len(paths)} files, {len(sizes) - len(paths)} classes, {len(too_large)} too large")
    return 1 if too_large or len(sizes) <= len(paths) else 0


if __name__ == "__main__":
    sys.exit(main())
