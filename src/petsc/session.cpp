#include "udar/petsc/session.hpp"

#include <dlfcn.h>
#include <petsclog.h>
#include <petscoptions.h>
#include <slepcsys.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "petsc/help.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/ignored_signals.hpp"
#include "udar/petsc/log.hpp"
#include "udar/petsc/option_sources.hpp"
#include "udar/petsc/options.hpp"

namespace udar::petsc {
namespace {

std::string& error_message() {
  static std::string message;
  return message;
}

bool& first_rank() {
  static bool first = true;
  return first;
}

/// Keeps the first message of an error chain and prints nothing.
PetscErrorCode record_error(MPI_Comm /*comm*/, int line, const char* function, const char* file, PetscErrorCode code,
                            PetscErrorType kind, const char* message, void* /*context*/) {
  if (kind == PETSC_ERROR_INITIAL && error_message().empty()) {
    error_message() = message != nullptr ? message : "";
    while (!error_message().empty() && error_message().back() == '\n') {
      error_message().pop_back();
    }
    error_message() += std::string{" ["} + function + ", " + file + ":" + std::to_string(line) + "]";
  }
  return code;
}

/// OpenBLAS, where it is the BLAS in use, maps a work space for each of its threads when they start, before `main`, and
/// tries for ever where it gets none. Where the address space is limited to less than all of them may need the program
/// starts again with one thread, whose failures have messages.
void spare_work_spaces(char** argv) {
  constexpr const char* kThreads = "OPENBLAS_NUM_THREADS";
  constexpr rlim_t kMebibyte = 1024UL * 1024UL;
  constexpr rlim_t kWorkSpace = 128 * kMebibyte;  // BUFFER_SIZE in its common_x86_64.h; other processors take less
  constexpr rlim_t kProgram = 512 * kMebibyte;    // of libraries and a small case (found: 230 MiB)
  int initialized = 0;
  MPI_Initialized(&initialized);
  rlimit space{};
  const char* threads = std::getenv(kThreads);
  const bool single = threads != nullptr && std::string_view{threads} == "1";
  if (initialized != 0 || single || dlsym(RTLD_DEFAULT, "openblas_get_num_threads") == nullptr ||
      getrlimit(RLIMIT_AS, &space) != 0) {
    return;
  }
  const auto processors = static_cast<rlim_t>(std::max(1L, sysconf(_SC_NPROCESSORS_ONLN)));
  if (space.rlim_cur < kProgram + processors * kWorkSpace) {  // no limit is the largest number
    setenv(kThreads, "1", 1);
    execv("/proc/self/exe", argv);  // goes on as it is where that fails
  }
}

/// How ranks of Open MPI 5 wait, unless the user says it: those that offer their core to others in turn answer within
/// microseconds, those that sleep after 50 at the least. Found on a busy machine with 2 cores: sleeping is 6 and 4.5
/// times slower with 2 and 3 ranks, as fast with 4, and 1.4 to 6 times faster with 8.
void choose_waiting() {
  const char* ranks = std::getenv("OMPI_COMM_WORLD_LOCAL_SIZE");
  if (ranks != nullptr) {
    const bool crowded = std::strtol(ranks, nullptr, 10) > 2 * sysconf(_SC_NPROCESSORS_ONLN);
    setenv("OMPI_MCA_threads_pthreads_yield_strategy", crowded ? "nanosleep" : "sched_yield", 0);
  }
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

/// Files that the environment names are read here, as those of the command line.
void keep_back_files_of_environment() {
  std::vector<std::string> words = option_words(environment("PETSC_OPTIONS"));
  if (!take_sources(words).empty()) {
    std::string rest;
    for (const std::string& word : words) {
      rest += "\"" + word + "\" ";
    }
    setenv("PETSC_OPTIONS", rest.c_str(), 1);
  }
  unsetenv("PETSC_OPTIONS_YAML");
}

void insert_environment(const std::string& options, const std::string& yaml) {
  std::vector<std::string> words = option_words(shared_text(PETSC_COMM_WORLD, options));
  for (const OptionSource& source : take_sources(words)) {
    insert_source(PETSC_COMM_WORLD, source);
  }
  check_option_words(words, " in PETSC_OPTIONS");
  if (const std::string text = shared_text(PETSC_COMM_WORLD, yaml); !text.empty()) {
    insert_source(PETSC_COMM_WORLD, {.kind = OptionSource::Kind::yaml_text, .text = text});
  }
}

bool is_any_of(std::string_view word, std::initializer_list<std::string_view> names) {
  return std::ranges::find(names, word) != names.end();
}

}  // namespace

Session::Session(int argc, char** argv, const char* help) : Session{argc, argv} { insert_options(help); }

void Session::insert_options(const char* help) {
  if (help_ && help_topic_.empty()) {
    UDAR_CALL(PetscPrintf(PETSC_COMM_WORLD, "%s", help));
  }
  if (help_) {
    set_help_topic(help_topic_);
    UDAR_CALL(PetscOptionsSetValue(nullptr, "-help", nullptr));
  }
  insert_environment(environment_[0], environment_[1]);
  check_option_words(words_);
  for (const OptionSource& source : sources_) {
    insert_source(PETSC_COMM_WORLD, source);
  }
  std::ranges::for_each(words_, forget_place);
  UDAR_CALL(PetscOptionsInsertArgs(nullptr, static_cast<int>(words_.size()), arguments_.data() + 1));  // over the files
  begin_log_of_files();
}

// PETSc would abort inside PetscInitialize on a bad options file, and would print pages of general options for -help:
// both are kept back here and inserted once PETSc is up.
Session::Session(int argc, char** argv)
    : environment_{environment("PETSC_OPTIONS"), environment("PETSC_OPTIONS_YAML")} {
  spare_work_spaces(argv);
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (!words.empty() && !words.front().starts_with('-')) {
    words.insert(words.begin(), "-options_file");  // a case file
  }
  sources_ = take_sources(words);
  for (auto word = words.begin(); word != words.end(); ++word) {
    if (is_any_of(*word, {"-version", "--version"})) {
      version_ = true;
    } else if (is_any_of(*word, {"-help", "--help", "-h"})) {
      help_ = true;
      if (word + 1 != words.end() && !(word + 1)->starts_with('-')) {
        help_topic_ = *++word;
      }
    } else {
      words_.push_back(*word);
    }
  }
  keep_back_files_of_environment();
  arguments_.push_back(argv[0]);
  for (std::string& word : words_) {
    arguments_.push_back(word.data());
  }
  int count = static_cast<int>(arguments_.size());
  arguments_.push_back(nullptr);
  char** values = arguments_.data();
  choose_waiting();
  note_ignored_signals();
  check(SlepcInitialize(&count, &values, nullptr, nullptr), "SlepcInitialize");
  ignore_noted_signals();
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  first_rank() = rank == 0;
  UDAR_CALL(PetscPushErrorHandler(record_error, nullptr));
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-log_view", &log_begun_));
  UDAR_CALL(register_log_events());
}

/// The log that `-log_view` in a file asks for; PETSc has begun the one of the command line.
void Session::begin_log_of_files() const {
  const char* form = nullptr;
  PetscBool asked = PETSC_FALSE;
  UDAR_CALL(PetscOptionsFindPair(nullptr, nullptr, "-log_view", &form, &asked));
  if (asked == PETSC_FALSE || log_begun_ == PETSC_TRUE) {
    return;
  }
  const std::string_view name{form != nullptr ? form : ""};
  if (name.find(":ascii_xml") != std::string_view::npos || name.find(":ascii_flamegraph") != std::string_view::npos) {
    UDAR_CALL(PetscLogNestedBegin());
  } else {
    UDAR_CALL(PetscLogDefaultBegin());
  }
}

/// PETSc 3.20 and later list them by themselves.
void Session::forget_unused_options() {
  PetscBool asked = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, "-options_left", &asked));
  if (asked == PETSC_FALSE) {
    UDAR_CALL(PetscOptionsSetValue(nullptr, "-options_left", "no"));
  }
}

Session::~Session() {
  PetscPopErrorHandler();
  SlepcFinalize();
}

bool Session::on_first_rank() { return first_rank(); }

bool Session::help_found_nothing() { return petsc::help_found_nothing(); }

bool Session::help_requested() {
  PetscBool help = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasHelp(nullptr, &help));
  return help == PETSC_TRUE;
}

const std::vector<std::string>& Session::options_files() { return inserted_files(); }

void join_petsc() {
  check(SlepcInitialize(nullptr, nullptr, nullptr, nullptr), "SlepcInitialize");
  UDAR_CALL(register_log_events());
}

RecordedErrors::RecordedErrors() { PetscPushErrorHandler(record_error, nullptr); }

RecordedErrors::~RecordedErrors() { PetscPopErrorHandler(); }

std::string take_error_message() { return std::exchange(error_message(), {}); }

}  // namespace udar::petsc
