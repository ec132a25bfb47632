#!/usr/bin/env python3
"""Checks that no line of text or code is longer than 120 columns; table rows of Markdown and addresses may be.

Usage: check_lines.py SOURCE_DIR. Prints every line that is too long; the exit code is their presence.
"""

import re
import sys
from pathlib import Path

LONGEST = 120
FOLDERS = ("cmake", "docs", "examples", "include", "petsc-options", "scripts", "src", "tests")
SUFFIXES = {".md", ".yaml", ".py", ".sh", ".c", ".cpp", ".hpp", ".cmake", ".opts", ".sbatch", ""}
NAMES = {"CMakeLists.txt"}
MADE = {"build", "out", "__pycache__"}


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


def main():
    source_dir = Path(sys.argv[1])
    count = found = 0
    for path in files(source_dir):
        count += 1
        for number, line in enumerate((source_dir / path).read_text(encoding="utf-8").splitlines(), start=1):
            if too_long(path, line):
                found += 1
                print(f"{path}:{number}: {len(line)} columns")
    print(f"{count} files, {found} lines longer than {LONGEST} columns")
    return 1 if found or not count else 0


if __name__ == "__main__":
    sys.exit(main())
