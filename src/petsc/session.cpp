#include "udar/petsc/session.hpp"

#include <dlfcn.h>
#include <petsclog.h>
#include <petscoptions.h>
#include <petsctime.h>
#include <slepcsys.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"

namespace udar::petsc {
namespace {

std::string& error_message() {
  static std::string message;
  return message;
}

LogEvents& mutable_log_events() {
  static LogEvents events;
  return events;
}

bool& first_rank() {
  static bool first = true;
  return first;
}

std::vector<std::string>& mutable_options_files() {
  static std::vector<std::string> files;
  return files;
}

/// The scope that is open on this rank, and seconds of each event outside the scopes within it.
LogScope*& open_scope() {
  static LogScope* scope = nullptr;
  return scope;
}

std::map<PetscLogEvent, double>& own_seconds() {
  static std::map<PetscLogEvent, double> seconds;
  return seconds;
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

void insert_options_file(const std::string& path) {
  std::string failure;
  errno = 0;
  std::ifstream file{path};
  file.peek();  // opening a folder succeeds, reading it does not
  if (!file.good() && !(file.is_open() && file.eof())) {
    failure = "option -options_file: cannot read '" + path + "': " + std::strerror(errno != 0 ? errno : EIO);
  }
  throw_together<InputError>(PETSC_COMM_WORLD, failure);
  const PetscErrorCode code = PetscOptionsInsertFile(PETSC_COMM_WORLD, nullptr, path.c_str(), PETSC_TRUE);
  if (code != 0) {
    failure = "option -options_file: '" + path +
              "' is neither valid YAML (name ends in .yaml or .yml) nor a PETSc options file: " + take_error_message();
  }
  throw_together<InputError>(PETSC_COMM_WORLD, failure);
  mutable_options_files().push_back(path);
}

}  // namespace

Session::Session(int& argc, char**& argv, const char* help) : Session{argc, argv} {
  if (help_) {
    UDAR_CALL(PetscPrintf(PETSC_COMM_WORLD, "%s", help));
    UDAR_CALL(PetscOptionsSetValue(nullptr, "-help", nullptr));
  }
  for (const std::string& file : files_) {
    insert_options_file(file);
  }
  if (!files_.empty()) {
    int count = static_cast<int>(arguments_.size()) - 1;
    char** values = arguments_.data();
    UDAR_CALL(PetscOptionsInsert(nullptr, &count, &values, nullptr));
  }
}

// PETSc would abort inside PetscInitialize on a bad options file, and would print pages of general options for -help:
// both are kept back here and inserted once PETSc is up.
Session::Session(int argc, char** argv) {
  spare_work_spaces(argv);
  for (int i = 0; i < argc; ++i) {
    const std::string_view argument{argv[i]};
    if (argument == "-options_file" && i + 1 < argc) {
      files_.emplace_back(argv[++i]);
    } else if (argument == "-help" || argument == "--help" || argument == "-h") {
      help_ = true;
    } else {
      arguments_.push_back(argv[i]);
    }
  }
  int count = static_cast<int>(arguments_.size());
  arguments_.push_back(nullptr);
  char** values = arguments_.data();
  check(SlepcInitialize(&count, &values, nullptr, nullptr), "SlepcInitialize");
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  first_rank() = rank == 0;
  UDAR_CALL(PetscPushErrorHandler(record_error, nullptr));
  std::signal(SIGPIPE, SIG_IGN);  // `udar -help | head` is no crash
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows beyond the limit is an error of the write, which names it
  UDAR_CALL(PetscLogDefaultBegin());

  PetscClassId library = 0;
  LogEvents& events = mutable_log_events();
  UDAR_CALL(PetscClassIdRegister("udar", &library));
  UDAR_CALL(PetscLogEventRegister("FilterAssemble", library, &events.assemble));
  UDAR_CALL(PetscLogEventRegister("FilterSolve", library, &events.solve));
  UDAR_CALL(PetscLogEventRegister("Contact", library, &events.contact));
  UDAR_CALL(PetscLogEventRegister("LocalMotion", library, &events.local_motion));
  UDAR_CALL(PetscLogEventRegister("Reduction", library, &events.reduction));
  UDAR_CALL(PetscLogEventRegister("Output", library, &events.output));
  UDAR_CALL(PetscLogEventRegister("OutputFields", library, &events.fields));
}

Session::~Session() {
  PetscPopErrorHandler();
  SlepcFinalize();
}

bool Session::on_first_rank() { return first_rank(); }

bool Session::help_requested() {
  PetscBool help = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasHelp(nullptr, &help));
  return help == PETSC_TRUE;
}

const std::vector<std::string>& Session::options_files() { return mutable_options_files(); }

std::string take_error_message() { return std::exchange(error_message(), {}); }

const LogEvents& log_events() { return mutable_log_events(); }

LogScope::LogScope(PetscLogEvent event) : event_{event} {
  if (event_ >= 0) {
    around_ = std::exchange(open_scope(), this);
    PetscTime(&begin_);
    PetscLogEventBegin(event_, 0, 0, 0, 0);
  }
}

LogScope::~LogScope() {
  if (event_ >= 0) {
    PetscLogEventEnd(event_, 0, 0, 0, 0);
    PetscLogDouble end = 0.0;
    PetscTime(&end);
    own_seconds()[event_] += end - begin_ - inside_;
    open_scope() = around_;
    if (around_ != nullptr) {
      around_->inside_ += end - begin_;
    }
  }
}

Traffic traffic() {
  return {.messages = 0.5 * (petsc_isend_ct + petsc_send_ct + petsc_irecv_ct + petsc_recv_ct),
          .message_bytes = 0.5 * (petsc_isend_len + petsc_send_len + petsc_irecv_len + petsc_recv_len),
          .reductions = petsc_allreduce_ct + petsc_gather_ct + petsc_scatter_ct};
}

EventTotals event_totals(PetscLogEvent event) {
  EventTotals totals;
  if (event < 0) {
    return totals;
  }
  PetscEventPerfInfo info;
  UDAR_CALL(PetscLogEventGetPerfInfo(PETSC_DEFAULT, event, &info));
  totals.seconds = info.time;
  totals.own = own_seconds()[event];
  totals.calls = static_cast<PetscInt>(info.count);
  totals.traffic = {
      .messages = 0.5 * info.numMessages, .message_bytes = 0.5 * info.messageLength, .reductions = info.numReductions};
  return totals;
}

}  // namespace udar::petsc
