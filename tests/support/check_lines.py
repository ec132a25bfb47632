#!/usr/bin/env python3
"""Checks that no line of text or code is longer than 120 columns; table rows of Markdown and addresses may be.
And that in Markdown each sentence begins a line, so that differences show sentences, outside tables and code.

Usage: check_lines.py SOURCE_DIR. Prints every line that breaks a rule; the exit code is their presence.
"""

import re
import sys
from pathlib import Path

LONGEST = 120
FOLDERS = ("cmake", "docs", "examples", "include", "packaging", "petsc-options", "scripts", "src", "tests")
SUFFIXES = {".md", ".yaml", ".py", ".sh", ".c", ".cpp", ".hpp", ".cmake", ".opts", ".sbatch", ""}
SUFFIXES |= {".css", ".html", ".js"}
NAMES = {"CMakeLists.txt"}
MADE = {"build", "out", "__pycache__", "corpus", "vendor", "missing-sources"}  # the last two: of others


def files(source_dir):
    found = list(source_dir.glob("*"))
    for folder in FOLDERS:
        found += (source_dir / folder).rglob("*")
    for path in sorted(found):
        inside = path.relative_to(source_dir)
        known = path.suffix in SUFFIXES or path.name in NAMES
        if path.is_file() and path.name[0] != "." and known and not MADE & set(inside.parts):
            yield inside


def too_long(path, line):
    if len(line) <= LONGEST or (path.suffix == ".md" and line.lstrip().startswith("|")):
        return False
    return not re.search(r"https?://\S{60,}", line)


# The end of a sentence, and what may begin the next one. Symbols and keys in code may begin one, too.
SHORT = (r"e\.g", r"i\.e", "no", "p", "vol", "[A-Z]", "Appl", "Chem", "Comput", "Mech", "Trans")  # abbreviated
ABBREVIATIONS = "".join(rf"(?<!\b{word})" for word in SHORT)
NEXT_SENTENCE = re.compile(ABBREVIATIONS + r"""[.!?][)"*_]* +["(]*[A-Z`\[]""")
CODE = re.compile(r"^( {4,}\S|```)")


def second_sentences(path, lines):
    """Numbers of lines of prose in which a sentence ends and another begins."""
    fenced = False
    listed = False  # lines of a list are indented as code is
    for number, line in enumerate(lines, start=1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        listed = bool(re.match(r"^ *([-*]|\d+\.) ", line)) or (listed and (line.startswith(" ") or not line))
        code = fenced or (not listed and CODE.match(line)) or line.lstrip().startswith("|")
        text = re.sub(r"`[^`]*`", "`code`", re.sub(r"^ *([-*]|\d+\.) +", "", line))
        if path.suffix == ".md" and not code and NEXT_SENTENCE.search(text):
            yield number


def main():
    source_dir = Path(sys.argv[1])
    count = found = 0
    for path in files(source_dir):
        count += 1
        lines = (source_dir / path).read_text(encoding="utf-8").splitlines()
        for number, line in enumerate(lines, start=1):
            if too_long(path, line):
                found += 1
                print(f"{path}:{number}: {len(line)} columns")
        for number in second_sentences(path, lines):
            found += 1
            print(f"{path}:{number}: a second sentence, begin a line with it")
    print(f"{count} files, {found} lines longer than {LONGEST} columns or of two sentences")
    return 1 if found or not count else 0


if __name__ == "__main__":
    sys.exit(main())
