"""Completion for bash, zsh and fish from what a program says under -help: names of options, values of fixed lists,
files and folders; in place of a case file also the installed examples."""
import textwrap

CASES = "share/udar/examples"  # below the prefix, whose bin the program is in


def brief(option):
    """A meaning as it fits beside a name."""
    return textwrap.shorten(option.meaning, 70, placeholder=" ...")


def takes_cases(manual):
    return not manual.operands


def quoted(text):
    """For all three shells' single quotes but fish's, which has \\' in them."""
    return "'" + text.replace("'", "'\\''") + "'"


def function_of(manual):
    return "_" + manual.name.replace("-", "_")


def values_of(manual):
    """Names of options by what completes their values: (kind, words) -> names."""
    values = {}
    for option in manual.options:
        if option.kind:
            values.setdefault((option.kind, " ".join(option.words)), []).extend(option.names)
    return values


def bash(manual):
    function = function_of(manual)
    cases = []
    for (kind, words), names in values_of(manual).items():
        act = {"words": f"words={quoted(words)} ;;", "folder": "kind=folder ;;", "file": "kind=file ;;",
               "text": "return ;;"}[kind]
        pattern = textwrap.fill("|".join(names).replace("|", " | "), 110, subsequent_indent="      ",
                                break_on_hyphens=False).replace("\n", " \\\n")
        cases.append(f"    {pattern}) {act}")
    operand = "case" if takes_cases(manual) else manual.operands[0].kind
    names = textwrap.fill(" ".join(name for option in manual.options for name in option.names), 110,
                          initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False)
    joined = "\n".join(cases)
    return f"""# Completion of {manual.name} in bash. Made of what the program says under -help.
{function}() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} kind={operand} words="" program
  COMPREPLY=()
  case ${{COMP_WORDS[COMP_CWORD - 1]}} in
{joined}
  esac
  if [[ $current == -* ]]; then  # a switch goes without its value, too
    words="
{names}"
  fi
  if [ -n "$words" ]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
    return
  fi
  compopt -o filenames 2> /dev/null
  case $kind in
    folder) mapfile -t COMPREPLY < <(compgen -d -- "$current") ;;
    file) mapfile -t COMPREPLY < <(compgen -f -- "$current") ;;
    case)
      program=$(type -P -- "${{COMP_WORDS[0]}}")
      mapfile -t COMPREPLY < <(
        compgen -d -- "$current"
        compgen -f -X '!*.y*ml' -- "$current"
        compgen -W "$(compgen -G "${{program%/bin/*}}/{CASES}/*/case.yaml")" -- "$current"
      )
      ;;
  esac
}}
complete -F {function} {manual.name}
"""


def zsh(manual):
    function = function_of(manual)
    action = {"words": ":value:({})", "folder": ":folder:_files -/", "file": ":file:_files", "text": ":value: "}

    def entry(name, option):
        meaning = brief(option).replace("\\", "\\\\")
        for mark in "[]:":
            meaning = meaning.replace(mark, "\\" + mark)
        value = action[option.kind].format(" ".join(option.words)) if option.kind else ""
        value = ":" + value if option.words == ["true", "false"] else value  # a switch goes without it, too
        return "    " + quoted(f"*{name}[{meaning}]{value}")

    entries = [entry(name, option) for option in manual.options for name in option.names]
    operand = f"{function}_cases" if takes_cases(manual) else "_files"
    entries.append(f"    '*:case:{operand}'")
    joined = " \\\n".join(entries)
    return f"""#compdef {manual.name}
# Completion of {manual.name} in zsh. Made of what the program says under -help.
{function}_cases() {{
  local -a examples=(${{commands[{manual.name}]:h:h}}/{CASES}/*/case.yaml(N))
  _files -g '*.y(a|)ml'
  compadd -a examples
}}
{function}() {{
  _arguments \\
{joined}
}}
{function} "$@"
"""


def fish(manual):
    def literal(text):
        return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"

    name = manual.name
    lines = [f"# Completion of {name} in fish. Made of what the program says under -help."]
    for option in manual.options:
        line = f"complete -c {name}"
        for spelling in option.names:
            form = "l" if spelling.startswith("--") else "s" if len(spelling) == 2 else "o"
            line += f" -{form} {spelling.lstrip('-')}"
        line += {"words": f" -x -a {literal(' '.join(option.words))}", "file": " -r -F", "text": " -x", "": "",
                 "folder": " -x -a '(__fish_complete_directories)'"}[option.kind]
        lines.append(line + (f" -d {literal(brief(option))}" if option.meaning else ""))
    if takes_cases(manual):
        lines += [f"function __{name.replace('-', '_')}_cases",
                  f"    set -l examples (command -s {name} | string replace -r '/bin/[^/]*$' '')/{CASES}/*/case.yaml",
                  "    printf '%s\\n' $examples", "end",
                  f"complete -c {name} -a '(__{name.replace('-', '_')}_cases)' -d 'example'"]
    return "\n".join(lines) + "\n"
