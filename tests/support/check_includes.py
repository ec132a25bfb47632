#!/usr/bin/env python3
"""Checks who includes whom in include/udar and src: one walk through the rooms, no way back.

    petsc <- numerics <- structure <- filter <- contact <- motion <- integrators <- dynamics <- app
    local stands beside motion and knows numerics and contact alone; modal stands beside motion;
    io knows nothing of filter and integrators

Words neither: below the program no message names an option that only the program reads; it names the quantity,
"support damping: ..." or `filter frequency`, and the program adds the key (petsc::with_option_keys).

Usage: check_includes.py SOURCE_DIR. Prints every line that breaks a rule; the exit code is their presence.
"""

import re
import sys
from pathlib import Path

# From the lowest room to the highest; beside each the rooms whose headers it may include.
MAY_INCLUDE = {
    "petsc": {"petsc"},
    "numerics": {"petsc", "numerics"},
    "structure": {"petsc", "numerics", "structure"},
    "filter": {"petsc", "numerics", "structure", "filter"},
    "contact": {"petsc", "numerics", "structure", "filter", "contact"},
    "motion": {"petsc", "numerics", "structure", "filter", "contact", "motion"},
    "local": {"numerics", "contact", "local"},
    "modal": {"petsc", "numerics", "structure", "filter", "contact", "modal"},
    "integrators": {
        "petsc",
        "numerics",
        "structure",
        "filter",
        "contact",
        "motion",
        "local",
        "modal",
        "integrators",
    },
    "dynamics": {"petsc", "numerics", "structure", "filter", "contact", "motion", "integrators", "dynamics"},
    "io": {"petsc", "numerics", "structure", "contact", "motion", "io"},
    "app": {"petsc", "numerics", "structure", "filter", "contact", "motion", "integrators", "dynamics", "io", "app"},
}

SPEAKS_OF_OPTIONS = {"petsc", "app"}
STRING = re.compile(r'"(?:[^"\\]|\\.)*"')
# Keys of the program; those that PETSc's objects read behind a prefix, or as ts_, belong to whoever makes the objects.
OPTION = re.compile(
    r"(?<![\w-])-(?:(?:beam|contact|damping|filter|floor|gauge|ground|initial|load|network|output|restart|structure"
    r"|support|udar)_(?!ksp_|pc_|mat_|eps_|moment_ksp_|tao_)\w|gravity\b|floor\b)"
)

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
VERSION_TEST = re.compile(r"^\s*#\s*(?:if|ifdef|ifndef|elif)\b.*\b(?:PETSC|SLEPC)_VERSION_")
PRIVATE_HEADER = re.compile(r"^(?:petsc|slepc)/private/")


def room_of_file(path):
    """The room of include/udar/<room>/... or src/<room>/..., None for src/main.cpp and src/tools."""
    parts = path.parts[2:] if path.parts[0] == "include" else path.parts[1:]
    return parts[0] if len(parts) > 1 and parts[0] in MAY_INCLUDE else None


def room_of_include(name, own_room):
    """The room a quoted include reaches, None if it is none of ours."""
    parts = name.removeprefix("udar/").split("/")
    if len(parts) == 1:
        return None if name.startswith("udar/") else own_room
    return parts[0] if parts[0] in MAY_INCLUDE else None


def complaints(path, lines):
    room = room_of_file(path)
    for number, line in enumerate(lines, start=1):
        where = f"{path}:{number}"
        if VERSION_TEST.match(line) and room != "petsc":
            yield f"{where}: only the room petsc tests PETSc versions"
        include = INCLUDE.match(line)
        if room and room not in SPEAKS_OF_OPTIONS and not include:
            for text in STRING.findall(line):
                if OPTION.search(text):
                    yield f"{where}: {room} names an option, {text}; name the quantity (petsc::with_option_keys)"
        if not include:
            continue
        bracket, name = include.groups()
        if ".." in name.split("/"):
            yield f'{where}: "{name}" climbs out of its folder; include "udar/<room>/..."'
            continue
        if PRIVATE_HEADER.match(name) and room != "petsc":
            yield f"{where}: only the room petsc includes private headers, here {name}"
        if name == "petscts.h" and room == "contact":
            yield f"{where}: contact knows no time stepper, here {name}"
        if bracket == "<" and name.startswith("udar/"):
            yield f'{where}: write "{name}" in quotes'
        target = room_of_include(name, room)
        if (bracket == '"' or name.startswith("udar/")) and room and target and target not in MAY_INCLUDE[room]:
            yield f"{where}: {room} must not include {target}, here {name}"


def main():
    source_dir = Path(sys.argv[1])
    files = sorted(file for top in ("include/udar", "src") for file in (source_dir / top).rglob("*.[ch]pp"))
    found = [
        complaint
        for file in files
        for complaint in complaints(file.relative_to(source_dir), file.read_text(encoding="utf-8").splitlines())
    ]
    for complaint in found:
        print(complaint)
    print(f"{len(files)} files, {len(found)} lines against the rules")
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main())
