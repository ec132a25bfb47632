"""A manual page, roff for man(7), from what a program says under -help."""
import re
import textwrap

WIDTH = 79  # longer lines of input are found fault with
ESCAPES = str.maketrans({"\\": r"\e", "'": r"\(aq", "`": r"\(ga", "^": r"\(ha", "~": r"\(ti"})


def escaped(text):
    """Text as it is to be read: of a dash that is typed, and of a minus, a minus."""
    return re.sub(r"(?<![A-Za-z])-|(?<=\de)-(?=\d)", r"\\-", text.translate(ESCAPES))


def lines_of(text):
    """Lines of input, of text that is escaped, none of which is taken for a request."""
    wrapped = textwrap.wrap(text, WIDTH, break_long_words=False, break_on_hyphens=False)
    return ["\\&" + line if line.startswith(".") else line for line in wrapped]


def bold(text):
    return rf"\fB{escaped(text)}\fR"


def entry(option):
    """An option with what it takes and means."""
    head = ", ".join(bold(name) for name in option.names)
    if option.default:
        head += escaped(f" <{option.default}>")
    takes = "" if option.takes == option.names[0] else option.takes
    if option.names[-1].startswith("--"):  # takes a word, as FILE
        head, takes = f"{head} {escaped(takes)}".rstrip(), ""
    text = f"{takes}: {option.meaning}" if takes and option.meaning else takes or option.meaning
    return [".TP", head, *lines_of(escaped(text))]


def page(manual, others, version, date):
    """@param others names of the programs to see, too @param date as 2026-12-01"""
    title = manual.name.upper()
    lines = [r'.\" Made of what the program says under -help.',
             f'.TH {title} 1 {date} "udar {version}" "User commands"', ".nh", ".ad l", ".SH NAME",
             *lines_of(rf"{manual.name} \- {escaped(manual.summary)}"), ".SH SYNOPSIS", ".nf"]
    lines += [escaped(line) for line in manual.usage] + [".fi", ".SH DESCRIPTION"]
    for number, paragraph in enumerate(manual.prose or [manual.summary[0].upper() + manual.summary[1:] + "."]):
        lines += [*([".PP"] if number else []), *lines_of(escaped(paragraph))]
    lines.append(".SH OPTIONS")
    for group in manual.groups:
        lines.append(f".SS {escaped(group.title.rstrip(':').capitalize() if group.title.islower() else group.title)}")
        for option in group.options:
            lines += entry(option)
    own = {name for group in manual.groups for option in group.options for name in option.names}
    of_petsc = [option for option in manual.petsc if option.names[0] not in own]
    if of_petsc:
        lines.append(".SS Of PETSc, whose manual says more")
        for option in of_petsc:
            lines += entry(option)
    lines += [".SH SEE ALSO", *(rf".BR {escaped(other)} (1)" + ("," if other != others[-1] else "")
                                for other in others)]
    return "\n".join(lines) + "\n"
