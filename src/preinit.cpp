/// @file
/// What a program does before the constructors of its libraries run: the UCX that Open MPI 5 loads takes SIGHUP in its
/// own, and what the program was started to ignore (`nohup`) is not to be seen any more.

#include "udar/petsc/ignored_signals.hpp"

namespace {

void look_at_signals(int /*argc*/, char** /*argv*/, char** /*environment*/) { udar::petsc::note_ignored_signals(); }

[[gnu::section(".preinit_array"), gnu::used]] void (*const kFirst)(int, char**, char**) = look_at_signals;

}  // namespace
