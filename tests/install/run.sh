#!/bin/bash
# Installs the build into a fresh prefix and builds one program against it twice, through CMake and through pkg-config.
# usage: run.sh BUILD_DIR CONSUMER_SOURCE
set -euo pipefail

build=$1
source=$2
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cmake=${CMAKE:-cmake}
mpiexec=${MPIEXEC:-mpiexec}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$cmake" --install "$build" --prefix "$work/prefix" > "$work/install.log"

echo "== the program from find_package(udar)"
"$cmake" -S "$here/consumer" -B "$work/consumer" -DCMAKE_PREFIX_PATH="$work/prefix" -DCONSUMER_SOURCE="$source"
"$cmake" --build "$work/consumer"

echo "== the program from pkg-config"
pc=$(find "$work/prefix" -name udar.pc)
export PKG_CONFIG_PATH=${pc%/*}${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}
libdir=$(pkg-config --variable=libdir udar)
read -ra flags < <(pkg-config --cflags --libs udar)
mpicxx -std=c++20 "$source" -o "$work/with_pkg_config" "${flags[@]}" -Wl,-rpath,"$libdir"

for program in "$work/consumer/consumer" "$work/with_pkg_config"; do
  echo "== run ${program##*/}"
  mkdir "$work/run"
  (cd "$work/run" && "$mpiexec" -n 1 "$program" -skip_petscrc)
  rm -r "$work/run"
done

for call in "udar -help" "udar-plot --help"; do
  echo "== installed $call"
  read -ra words <<< "$call"
  "$work/prefix/bin/${words[0]}" "${words[1]}" > "$work/help"
  head -n 3 "$work/help"
done
