#pragma once
/// @file
/// What to cite, for PETSc's `-citations`.

namespace udar::app {

/// @brief Tells PETSc what a run uses: udar, and where `filtered` the filter method, as CITATION.cff names them. PETSc
/// prints them as BibTeX under `-citations [file]` when it ends, each once however many runs there were.
/// @note Not collective.
void cite(bool filtered);

}  // namespace udar::app
