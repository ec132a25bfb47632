#include "udar/petsc/warnings.hpp"

#include <petscsys.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar::petsc {
namespace {

std::vector<std::string>& kept() {
  static std::vector<std::string> texts;
  return texts;
}

bool& quiet() {
  static bool now = false;
  return now;
}

std::string printed(const char* format, std::va_list values) {
  std::va_list again;
  va_copy(again, values);
  std::string text(static_cast<std::size_t>(std::max(std::vsnprintf(nullptr, 0, format, values), 0)), '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  return text;
}

}  // namespace

QuietText::QuietText() { quiet() = true; }

QuietText::~QuietText() { quiet() = false; }

void say(MPI_Comm comm, const char* format, ...) {
  std::va_list values;
  va_start(values, format);
  const std::string text = printed(format, values);
  va_end(values);
  if (!quiet()) {
    UDAR_CALL(PetscPrintf(comm, "%s", text.c_str()));
  }
}

void warn(MPI_Comm comm, const char* format, ...) {
  std::va_list values;
  va_start(values, format);
  const std::string text = printed(format, values);
  va_end(values);
  if (std::ranges::find(kept(), text) == kept().end()) {
    keep_warning(text);
    if (!quiet()) {
      UDAR_CALL(PetscFPrintf(comm, PETSC_STDERR, "udar: warning: %s\n", text.c_str()));
    }
  }
}

void keep_warning(const std::string& text) {
  if (std::ranges::find(kept(), text) == kept().end()) {
    kept().push_back(text);
  }
}

const std::vector<std::string>& warnings() { return kept(); }

std::vector<std::string> take_warnings() { return std::exchange(kept(), {}); }

}  // namespace udar::petsc
