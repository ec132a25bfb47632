#!/bin/bash
# Called by conda-build, with its variables, in the source tree.
set -euo pipefail

cmake -S . -B build-conda ${CMAKE_ARGS:-} \
  -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_INSTALL_PREFIX="$PREFIX" \
  -DUDAR_BUILD_TESTS=OFF \
  -DUDAR_PYTHON="$PYTHON" \
  -DUDAR_PYTHON_DIR="lib/python$PY_VER/site-packages" \
  -DPETSC_DIR="$PREFIX" \
  -DSLEPC_DIR="$PREFIX"
cmake --build build-conda --parallel "${CPU_COUNT:-2}"
cmake --install build-conda
