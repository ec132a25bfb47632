#include "petsc/help.hpp"

#include <petscsys.h>

#include <cstdarg>
#include <cstdio>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"

namespace udar::petsc {
namespace {

struct Topic {
  std::string word;
  bool found = false;
  bool own = false;                                                 ///< lines of our own manual are being printed
  PetscErrorCode (*print)(FILE*, const char[], va_list) = nullptr;  ///< what PETSc printed with before
  std::string line;                                                 ///< of PETSc's manual, which comes in pieces
};

Topic& topic() {
  static Topic one;
  return one;
}

/// Whether a line of PETSc's manual, `  -key <value>: text`, is asked for.
bool line_shown(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(' ');
  return begin != std::string::npos && line[begin] == '-' &&
         help_shows(line.substr(begin, line.find_first_of(" :", begin) - begin));
}

std::string formatted(const char* format, std::va_list arguments) {
  std::va_list again;
  va_copy(again, arguments);
  std::vector<char> text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, again)) + 1);
  va_end(again);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  return text.data();
}

/// In place of what PETSc prints with: some lines of its manual do not go through `PetscHelpPrintf`.
PetscErrorCode print_shown(FILE* file, const char format[], va_list arguments) {
  PetscFunctionBeginUser;
  if (topic().own || file != PETSC_STDOUT) {
    PetscCall(topic().print(file, format, arguments));
    PetscFunctionReturn(0);
  }
  std::string& waiting = topic().line;
  waiting += formatted(format, arguments);
  for (std::size_t end = waiting.find('\n'); end != std::string::npos; end = waiting.find('\n')) {
    const std::string line = waiting.substr(0, end);
    waiting.erase(0, end + 1);
    if (line_shown(line)) {
      std::fprintf(file, "%s\n", line.c_str());
    }
  }
  PetscFunctionReturn(0);
}

}  // namespace

void set_help_topic(const std::string& word) {
  topic().word = word;
  if (!word.empty()) {
    topic().print = std::exchange(PetscVFPrintf, print_shown);
  }
}

bool help_shows(const std::string& key) {
  const std::string& word = topic().word;
  const std::size_t begin = key.find_first_not_of('-');
  const bool shown = word.empty() || (begin != std::string::npos &&
                                      ("_" + key.substr(begin) + "_").find("_" + word + "_") != std::string::npos);
  topic().found = topic().found || shown;
  return shown;
}

void print_own_help(MPI_Comm comm, const std::string& text) {
  topic().own = true;
  UDAR_CALL(PetscPrintf(comm, "%s", text.c_str()));
  topic().own = false;
}

bool help_found_nothing() { return !topic().word.empty() && !topic().found; }

}  // namespace udar::petsc
