#!/bin/bash
# What a user does with an installed udar and with a checkout, the command lines as README.md has them.
# usage: run.sh BUILD_DIR CONSUMER_SOURCE PLUGIN
set -euo pipefail

build=$1
source=$2
plugin=$3
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=${here%/tests/install}
cmake=${CMAKE:-cmake}
mpiexec=${MPIEXEC:-mpiexec}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix

fail() {
  echo "FAILED: $1"
  exit 1
}

# expect TEXT FILE: the file holds the text.
expect() {
  grep -qF -- "$1" "$2" || {
    cat "$2"
    fail "no '$1' in ${2##*/}"
  }
}

# readme_line WORD: the one command of README.md that holds the word.
readme_line() {
  [ "$(grep -c -- "$1" "$root/README.md")" = 1 ] || fail "README.md has not one line with $1"
  grep -- "$1" "$root/README.md"
}

# scripts_run FOLDER: every script there that names its interpreter can be called by its name.
scripts_run() {
  local file script=0
  while IFS= read -r -d '' file; do
    [ "$(head -c 2 "$1/$file" | tr -d '\0')" = '#!' ] || continue
    script=1
    [ -x "$1/$file" ] || fail "$1/$file has no run bit"
  done
  [ $script = 1 ] || fail "no script in $1"
}

"$cmake" --install "$build" --prefix "$prefix" > "$work/install.log"

echo "== manual pages and completions are where they are looked for"
for program in "$prefix"/bin/*; do
  name=${program##*/}
  for file in man/man1/$name.1 bash-completion/completions/$name zsh/site-functions/_$name \
    fish/vendor_completions.d/$name.fish; do
    [ -s "$prefix/share/$file" ] || fail "no $file"
  done
done

echo "== scripts have their run bit"
(cd "$prefix" && find . -type f -print0) | scripts_run "$prefix"
if git -C "$root" rev-parse --is-inside-work-tree > /dev/null 2>&1; then
  git -C "$root" ls-files -z | scripts_run "$root"
fi
pages=("$root"/*.md "$root"/docs/*.md "$root"/examples/*/*.md)
calls=$(grep -hoE '^ *(scripts|examples)/[A-Za-z0-9_./-]+' "${pages[@]}" | sort -u)
for call in $calls; do
  [ -x "$root/$call" ] || fail "$call is called in the documentation and cannot be run"
done

for languages in "C;CXX" CXX; do
  echo "== find_package(udar) in a project in $languages"
  "$cmake" -S "$here/consumer" -B "$work/consumer-${languages/;/-}" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCONSUMER_SOURCE="$source" -DCONSUMER_LANGUAGES="$languages"
done
"$cmake" --build "$work/consumer-CXX"

echo "== the program from pkg-config"
export PATH=$prefix/bin:$PATH
pc=$(find "$prefix" -name udar.pc)
export PKG_CONFIG_PATH=${pc%/*}${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}
LD_LIBRARY_PATH=$(pkg-config --variable=libdir udar)${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export LD_LIBRARY_PATH
mkdir "$work/run"
cd "$work/run"
cp "$source" .
line=$(readme_line 'pkg-config --cflags')
echo "$line"
eval "$line"

for program in "$work/consumer-CXX/consumer" ./falling_beam; do
  echo "== run ${program##*/}"
  "$mpiexec" -n 1 "$program" -skip_petscrc
done

echo "== a PETSc program that loads the installed library"
ln -s "$plugin" my_petsc_program
line=$(readme_line '-dll_append')
echo "$line"
eval "$line -ksp_type preonly -skip_petscrc" > plugin.log 2>&1 && fail "its matrix carries no line"
expect "'heat' of type seqaij" plugin.log

for call in "udar -help" "udar-study -help" "udar-bench -help" \
  "udar-plot --help" "udar-report --help" "udar-compare --help"; do
  echo "== installed $call"
  $call > "$work/help"
  head -n 3 "$work/help"
done

for case in "$prefix"/share/udar/examples/*/case.yaml; do
  echo "== installed ${case#"$prefix/"} from another folder"
  rm -rf out
  mkdir out
  if [ -f "${case%/*}/make_bar.py" ]; then  # what the case asks for, on a coarser mesh
    "${PYTHON:-python3}" "${case%/*}/make_bar.py" --elements 40 2 2 out/bar
  fi
  udar -options_file "$case" -filter_frequency 400 -ts_max_time 0.01 -output_directory out/run > case.log 2>&1 || {
    cat case.log
    fail "it does not run"
  }
done

echo "== the installed Python module, from Debian's place below the prefix"
export PYTHONPATH=$prefix/lib/python3/dist-packages PYTHONDONTWRITEBYTECODE=1
"${PYTHON:-python3}" -W ignore - "$prefix" << 'END'
import pathlib
import sys

import udar
from udar.running import find_program

prefix = pathlib.Path(sys.argv[1])
package = pathlib.Path(udar.__file__).parent
assert package.is_relative_to(prefix) and (package / "py.typed").exists(), package
assert pathlib.Path(find_program()).samefile(prefix / "bin" / "udar"), find_program()
results = udar.run(prefix / "share" / "udar" / "examples" / "01-falling-beam" / "case.yaml", "out/again",
                   filter_frequency=400, ts_max_time=0.01)
assert len(results.gauges) == 11, results.gauges
END
if compgen -G "$prefix/lib/python3/dist-packages/udar/_core*.so" > /dev/null; then
  "$mpiexec" -n 1 "${PYTHON:-python3}" -W ignore - "$prefix" << 'END'
import sys

from udar import core, open

model = core.Model(core.Case(sys.argv[1] + "/share/udar/examples/01-falling-beam/case.yaml", filter_frequency=400,
                             ts_max_time=0.01))
gauges = model.record()
model.advance()
assert (gauges.gauges()["line_2"] == open("out/again").gauges["line_2"]).all()
END
fi
unset PYTHONPATH
udar-compare out/again out/again --tolerance 0 || fail "a run is itself"

echo "== PETSC_DIR and PETSC_ARCH"
configure() {
  "$cmake" -S "$root" -B "$work/configured" -DUDAR_BUILD_TESTS=OFF "$@" > "$work/configure.log" 2>&1
}
pc=$work/petsc/some-arch/lib/pkgconfig/PETSc.pc
mkdir -p "${pc%/*}"
configure -DPETSC_DIR="$work/petsc" -DPETSC_ARCH=some-arch && fail "there is no PETSc"
expect "PETSC_DIR: no lib/pkgconfig/PETSc.pc in '$work/petsc'" "$work/configure.log"
sed 's/^Version:.*/Version: 3.99.7/' "$(pkg-config --variable=pcfiledir PETSc)/PETSc.pc" > "$pc"
configure -DPETSC_DIR="$work/petsc" -DPETSC_ARCH=some-arch || fail "$(cat "$work/configure.log")"
expect "UDAR_PETSC_VERSION:INTERNAL=3.99.7" "$work/configured/CMakeCache.txt"
expect "${pc%/*}" "$work/configured/udarConfig.cmake"
configure -DPETSC_DIR= && fail "a build folder must not change its PETSc"
expect "cmake --fresh" "$work/configure.log"
