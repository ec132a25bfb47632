#!/usr/bin/env python3
# ranks: 1; size: short
"""Manual pages without a fault that hold every option, and completion as it answers in bash, zsh and fish."""

import os
import pathlib
import re
import shutil
import subprocess
import unittest

from common import ENVIRONMENT, ROOT, UdarTest

BUILD = pathlib.Path(os.environ["UDAR_BUILD_DIR"])
MANUAL = BUILD / "manual"
PROGRAMS = sorted(path.name for path in BUILD.glob("udar*") if re.fullmatch(r"udar(-\w+)?", path.name))

EXAMPLE = "share/udar/examples/01-falling-beam/case.yaml"  # below the prefix
SWITCH = "udar my.yaml -rotary_inertia "
# What is typed, and what must be offered: all that is, or, where files that lie about are offered, some.
ASKED = {
    "udar -udar_s": {"-udar_summary"},
    "udar -udar_summary ": {"text", "json", "none"},
    "udar my.yaml -ts_type c": {"chebyshev", "cn"},
    SWITCH: {"true", "false"},
    "udar -udar_view -output_dir": {"-output_directory"},
    "udar -output_directory ": {"out"},
    "udar -load_table cu": {"curve.csv"},
    "udar -network_file ": {"my.yaml", "curve.csv", "out"},
    "udar ": {"my.yaml", "out", EXAMPLE},
    "udar-study -study_des": {"-study_design"},
    "udar-study -beam_len": {"-beam_length"},
    "udar-bench -bench_kind so": {"solve"},
    "udar-plot --obj": {"--objectives"},
    "udar-plot --output ": {"out"},
    "udar-compare o": {"out"},
    "udar-report --output cu": {"curve.csv"},
}

BASH = """
for file in "$MANUAL"/bash/*; do source "$file"; done
while IFS= read -r asked; do
  read -ra COMP_WORDS <<< "$asked"
  case $asked in *' ') COMP_WORDS+=("") ;; esac
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  called=$(complete -p "${COMP_WORDS[0]}")
  called=${called#*-F }
  "${called%% *}"
  echo "? $asked"
  printf '%s\\n' "${COMPREPLY[@]}"
done
"""
# A terminal in which keys are pressed; what is found passes through compadd.
ZSH = """
zmodload zsh/zpty
zpty -b terminal zsh -f -i || exit 1
zpty -w terminal "PS1=; fpath=($MANUAL/zsh \\$fpath); autoload -U compinit; compinit -u -D; LISTMAX=10000"
zpty -w terminal 'compadd() {
  local -a hits
  [[ "$*" == *" -"[OAD]" "* || "$1" == -[OAD] ]] || { builtin compadd -A hits "$@"; print -l -- $hits >> found; }
  builtin compadd "$@"
}'
while IFS= read -r asked; do
  rm -f found
  zpty -w -n terminal "$asked"$'\\t'
  for wait in {1..200}; do
    sleep 0.05
    [[ -s found ]] && break
  done
  sleep 0.1
  echo "? $asked"
  cat found
  zpty -w -n terminal $'\\x03'
  sleep 0.05
done
"""
FISH = """
set fish_complete_path $MANUAL/fish
while read --delimiter \\n asked
  echo "? $asked"
  complete -C "$asked"
end
"""


class Pages(unittest.TestCase):
    def test_each_program_has_its_files(self):
        self.assertIn("udar-study", PROGRAMS)
        names = [f"man1/{name}.1" for name in PROGRAMS] + [f"bash/{name}" for name in PROGRAMS]
        names += [f"zsh/_{name}" for name in PROGRAMS] + [f"fish/{name}.fish" for name in PROGRAMS]
        found = [str(path.relative_to(MANUAL)) for path in MANUAL.rglob("*") if path.is_file() and path.name != "stamp"]
        self.assertEqual(sorted(found), sorted(names))

    def test_mandoc_finds_no_fault(self):
        for name in PROGRAMS:
            done = subprocess.run(["mandoc", "-T", "lint", MANUAL / "man1" / f"{name}.1"], capture_output=True,
                                  text=True, check=False)
            self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))

    def test_pages_hold_every_option(self):
        for name in PROGRAMS:
            with self.subTest(name=name):
                told = subprocess.run([BUILD / name, "--help"], capture_output=True, text=True, check=True,
                                      env=ENVIRONMENT, timeout=60).stdout
                heads = [re.split("  | <", line.strip())[0] for line in told.splitlines() if re.match(" +-", line)]
                keys = {key for head in heads for key in re.findall(r"(?:^|, )(--?[A-Za-z]\w*)", head)}
                shown = subprocess.run(["mandoc", "-T", "ascii", MANUAL / "man1" / f"{name}.1"], capture_output=True,
                                       text=True, check=True).stdout
                words = set(re.sub(".\b", "", shown).replace(",", " ").split())
                self.assertGreater(len(keys), 3)
                self.assertEqual(sorted(keys - words), [])
                self.assertIn(name, words)


class Completion(UdarTest):
    """What is typed goes in line by line; what is offered comes back below each line."""

    def answers(self, call, script):
        prefix = self.scratch / "prefix"
        for name in PROGRAMS:
            (prefix / "bin").mkdir(parents=True, exist_ok=True)
            (prefix / "bin" / name).symlink_to(shutil.which("true"))
        (prefix / "share" / "udar").mkdir(parents=True)
        (prefix / "share" / "udar" / "examples").symlink_to(ROOT / "examples")
        here = self.scratch / "here"
        (here / "out").mkdir(parents=True)
        (here / "my.yaml").touch()
        (here / "curve.csv").touch()
        environment = {**os.environ, "PATH": f"{prefix / 'bin'}:{os.environ['PATH']}", "MANUAL": str(MANUAL),
                       "HOME": str(self.scratch), "TERM": "dumb"}
        done = subprocess.run([*call, script], input="\n".join(ASKED) + "\n", capture_output=True, text=True, cwd=here,
                              env=environment, timeout=50, check=False)
        self.assertEqual(done.stderr, "")
        found, asked = {}, None
        for line in done.stdout.splitlines():
            if line.startswith("? "):
                asked = found.setdefault(line[2:], set())
            elif line:
                asked.add(line.split("\t")[0].removesuffix("/").removeprefix(f"{prefix}/"))
        return found

    def check(self, call, script):
        found = self.answers(call, script)
        self.assertEqual(list(found), list(ASKED))
        for asked, expected in ASKED.items():
            with self.subTest(asked=asked):
                begun = asked.rpartition(" ")[2]  # fish 4 goes on with words that are merely like it
                offered = {word for word in found[asked] if word.startswith(begun)}
                offered -= {word for word in offered if "examples" in word and word != EXAMPLE}
                if asked == SWITCH:  # which goes without its value: zsh also offers what may come behind it
                    offered &= expected
                self.assertEqual(offered - {"curve.csv"} if asked == "udar " else offered, expected)

    def test_bash(self):
        self.check(["bash", "--norc", "-c"], BASH)

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh(self):
        try:
            for end in os.openpty():
                os.close(end)
        except OSError:
            self.skipTest("no terminals here: /dev/pts is not mounted")
        self.check(["zsh", "-f", "-c"], ZSH)

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed")
    def test_fish(self):
        self.check(["fish", "--no-config", "-c"], FISH)


if __name__ == "__main__":
    unittest.main()
