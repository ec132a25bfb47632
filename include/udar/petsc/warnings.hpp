#pragma once
/// @file
/// What a user should know before believing a run: printed at once, kept for its summary.

#include <mpi.h>

#include <string>
#include <vector>

namespace udar::petsc {

/// @brief Prints `udar: warning: TEXT` on `PETSC_STDERR` and keeps the text for summary.json, whose pictures show it.
///
/// The finding comes first, then `; ` and what to do about it: pictures show the finding alone.
/// A text that is kept already is neither printed nor kept again, so that a step may warn as often as it likes.
/// @param[in] format as for `printf`, without newline; rank 0 of `comm` prints, every rank keeps its own
/// @note Not collective, but the summary holds what rank 0 was told.
[[gnu::format(printf, 2, 3)]] void warn(MPI_Comm comm, const char* format, ...);

/// @brief Keeps a text that an earlier program of the same run has printed.
void keep_warning(const std::string& text);

/// @brief The texts kept so far, in order.
[[nodiscard]] const std::vector<std::string>& warnings();

/// @brief The texts kept since the last call, in order; forgets them.
[[nodiscard]] std::vector<std::string> take_warnings();

/// @brief Prints on `PETSC_STDOUT`, by rank 0 of `comm`, what a user may want to know of a choice.
/// @param[in] format as for `printf` @note Not collective.
[[gnu::format(printf, 2, 3)]] void say(MPI_Comm comm, const char* format, ...);

/// @brief While it lives warnings are kept and not printed, and nothing is said: for those who tell them in their own
/// way.
class QuietText {
 public:
  QuietText();
  QuietText(const QuietText&) = delete;
  QuietText& operator=(const QuietText&) = delete;
  ~QuietText();
};

}  // namespace udar::petsc
