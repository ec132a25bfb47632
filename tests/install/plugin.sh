#!/bin/bash
# A PETSc program that is not linked with libudar finds preconditioner chain in it at run time.
# usage: plugin.sh PROGRAM LIBRARY
set -euo pipefail

program=$1
library=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

solve() { # without mpiexec, which takes ten seconds to end a run that failed
  "$program" -skip_petscrc "$@" > "$work/out" 2>&1
}

fail() {
  echo "FAILED: $1"
  cat "$work/out"
  exit 1
}

# expect_error TEXT PLACE OPTION...: PETSc's message holds the text, and the function where it came up.
expect_error() {
  local text=$1 place=$2
  shift 2
  echo "== $* must fail in $place"
  if solve "$@"; then
    fail "the run ended as if all were well"
  fi
  grep -qF "$text" "$work/out" || fail "no such text: $text"
  grep -q "PETSC ERROR: #[0-9]* $place()" "$work/out" || fail "not in $place"
}

nm -D --defined-only "$library" > "$work/out"
grep -qw PetscDLLibraryRegister_udar "$work/out" || fail "the library does not export what PETSc looks for"
ldd "$program" > "$work/out"
if grep -q libudar "$work/out"; then
  fail "the program is linked with libudar"
fi

expect_error "Unable to find requested PC type chain" PCSetType -pc_type chain -ksp_type preonly
expect_error "'heat' of type seqaij" PCSetUp -dll_append "$library" -pc_type chain -ksp_type preonly
for type in chebyshev impact; do
  expect_error "Unknown TS type: $type" TSSetType -ts_type $type
  expect_error "no problem is composed with this TS" TSSetUp -dll_append "$library" -ts_type $type
done
echo "== PETSc's own types still work beside it"
solve -dll_append "$library" -pc_type jacobi || fail "not solved"
grep -q "log event of udar: yes" "$work/out" || fail "the plug-in registers no log events"
solve -pc_type jacobi || fail "not solved"
grep -q "log event of udar: no" "$work/out" || fail "a log event where there is no plug-in"
