"""What a program says of itself under -help, taken apart: for docs/options.md, manual pages and completions.

Three forms are known: udar's own (a line `-key <value now>  what it takes`, then a line of meaning), argparse's of the
programs in Python, and PETSc's, which follow udar's own behind a line of dashes.
"""
import dataclasses
import re

OWN = re.compile(r"^  (-\w+) +<(.*?)>  (.*)$")
PYTHON = re.compile(r"^  (-[-\w]+(?:, -[-\w]+)*|[A-Z]\S*)(?: (\S+))?(?:  +(.*))?$")
PETSC = re.compile(r"^ +(-\w+)(:?(?: <[^>]*>)?:?) (?:(\w+)[:\[]\S*:? )?(.*)$")
RULE = re.compile(r"^-{10,}$")

FOLDER = re.compile(r"\bfolder\b")
FILE = re.compile(r"\b(CSV|YAML|files?|matrix)\b")


@dataclasses.dataclass
class Option:
    """One option, or one word of the command line that is none, as RUN."""
    names: list        # ["-beam_length"], ["-h", "--help"], ["RUN"]
    default: str = ""
    takes: str = ""    # "number [m], > 0"; empty: no value
    meaning: str = ""
    words: list = dataclasses.field(default_factory=list)  # values of a fixed list

    @property
    def kind(self):
        """What completes a value: words, folder, file, or else text, which nothing does, and "" where there is none."""
        if self.words or self.takes in ("", "nothing"):
            return "words" if self.words else ""
        if self.takes in ("DIR", "RUN") or (self.takes == "text" and FOLDER.search(self.meaning)):
            return "folder"
        of_file = "FILE" in self.takes or self.takes.startswith("file") or self.names[0].endswith("_file")
        return "file" if of_file or (self.takes == "text" and FILE.search(self.meaning)) else "text"


@dataclasses.dataclass
class Group:
    title: str
    options: list = dataclasses.field(default_factory=list)


@dataclasses.dataclass
class Manual:
    """A program's -help."""
    name: str
    summary: str
    usage: list        # command lines
    prose: list        # paragraphs
    groups: list       # of the program itself
    petsc: list        # options of PETSc's own, each once

    @property
    def options(self):
        """All that begin with a dash, each once."""
        own = [option for group in self.groups for option in group.options if option.names[0].startswith("-")]
        return list({option.names[0]: option for option in [*self.petsc, *own]}.values())

    @property
    def operands(self):
        return [option for group in self.groups for option in group.options if not option.names[0].startswith("-")]


def fixed_words(takes):
    if takes.startswith("one of "):
        return takes.removeprefix("one of ").split(", ")
    if takes == "true or false":
        return ["true", "false"]
    return re.findall(r" or (\w+)", takes) if takes.startswith(("number", "whole number")) else []


def own_option(match, following):
    key, default, takes = match.groups()
    return Option([key], default, takes, following.strip(), fixed_words(takes))


def python_option(match, following):
    names, takes, meaning = match.groups()
    if meaning is None:  # no room beside a long name
        meaning = following.strip()
    names = names.split(", ")
    return Option(names, "", takes or ("" if names[0].startswith("-") else names[0]), meaning)


def petsc_options(lines):
    """Values now are left out: they are of the case at hand, and some PETSc has not set."""
    found = {}
    for line in lines:
        match = PETSC.match(line)
        if not match:
            continue
        key, value, viewer, meaning = match.groups()
        option = found.setdefault(key, Option([key]))
        if viewer:
            option.words.append(viewer)
            option.takes, option.meaning = "viewer", "where and how this is shown: ascii[:file[:format]], binary[:file]"
            continue
        meaning, _, words = re.sub(r" *\((?:\w*|\(null\))\)$", "", meaning).partition(" (one of) ")
        if not words:
            meaning, _, words = meaning.partition(" (choose one of) ")
        option.meaning, option.words = meaning.strip(), words.split()
        option.takes = "one of " + ", ".join(option.words) if words else "value" if "<" in value else ""
        if value.startswith(": <"):
            option.takes, option.words = "true or false", ["true", "false"]
    return list(found.values())


def read_help(name, text):
    """The manual of the program of this name from what it prints under -help."""
    lines = text.splitlines()
    cut = next((index for index, line in enumerate(lines) if RULE.match(line)), len(lines))
    manual = Manual(name, "", [], [[]], [], petsc_options(lines[cut:]))
    in_usage, title = False, None
    for index, line in enumerate(lines[:cut]):
        following = lines[index + 1] if index + 1 < cut else ""
        own = OWN.match(line)
        match = own or PYTHON.match(line)
        if match and (own or title or manual.groups):
            if title:
                manual.groups.append(Group(title))
                title = None
            manual.groups[-1].options.append((own_option if own else python_option)(match, following))
        elif line.startswith("usage:") or (in_usage and line.startswith(" ")):
            in_usage = True
            manual.usage.append(line.removeprefix("usage:").strip())
        elif not line:
            in_usage = False
            manual.prose.append([])
        elif not line.startswith(" "):
            if line.startswith(name + ": "):
                manual.summary = line.removeprefix(name + ": ")
            elif OWN.match(following) or PYTHON.match(following):
                title = line
            else:
                manual.prose[-1].append(line)
    manual.prose = [" ".join(paragraph) for paragraph in manual.prose if paragraph]
    if not manual.summary:  # argparse has but the description
        manual.summary = manual.prose[0][0].lower() + manual.prose[0][1:].partition(":")[0].rstrip(".")
    manual.usage = manual.usage or [f"{name} [-key value ...]"]
    return manual
