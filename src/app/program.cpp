#include "udar/app/program.hpp"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <new>
#include <string>
#include <thread>

#include "udar/io/hdf5_file.hpp"
#include "udar/io/versions.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"

namespace udar::app {

std::string failure_of(MPI_Comm comm, const std::function<void()>& body) {
  MPI_Comm watch = MPI_COMM_NULL;
  MPI_Comm_dup(comm, &watch);
  std::string failure;
  try {
    body();
  } catch (const std::bad_alloc&) {
    failure = kShortOfMemory;
  } catch (const std::exception& error) {
    failure = petsc::with_option_keys(error.what());
  }
  if (!failure.empty()) {
    // All ranks fail together, or this one is alone and the others wait for it in some collective: find out.
    using namespace std::chrono_literals;
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ibarrier(watch, &request);
    int together = 0;
    for (int wait = 0; wait < 100 && together == 0; ++wait) {
      MPI_Test(&request, &together, MPI_STATUS_IGNORE);
      std::this_thread::sleep_for(together != 0 ? 0ms : 20ms);
    }
    if (together == 0) {
      int rank = 0;
      MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
      std::fprintf(stderr, "udar: error: %s (on rank %d alone)\n", failure.c_str(), rank);
      std::fflush(stderr);
      MPI_Abort(PETSC_COMM_WORLD, 1);
    }
  }
  MPI_Comm_free(&watch);
  return failure;
}

namespace {

void print_versions(MPI_Comm comm) {
  std::map<std::string, std::string> versions = io::library_versions();
  UDAR_CALL(PetscPrintf(comm, "udar %s\n", versions.extract("udar").mapped().c_str()));
  for (const auto& [library, version] : versions) {
    UDAR_CALL(PetscPrintf(comm, "  %-6s %s\n", library.c_str(), version.c_str()));
  }
}

/// Keys of every program, which the session and PETSc read.
void explain_common_keys(MPI_Comm comm) {
  petsc::OptionGroup group{comm, "For every program"};
  group.explain("-options_file", "file", "a case, or options beside one; YAML, or PETSc's own form; later ones win");
  group.explain("-help", "word or nothing", "the keys with this word in their name, or all");
  group.explain("-version", "nothing", "versions of udar and of the libraries that it runs with");
  group.explain("-citations", "file or nothing",
                "at the end, what to cite for this run, as BibTeX: udar, its method, PETSc, solvers");
}

}  // namespace

int guarded_main(int argc, char** argv, const char* help, int (*program)(MPI_Comm)) {
  int code = 0;
  std::signal(SIGPIPE, SIG_IGN);  // `udar -help | head` is no crash
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows beyond the limit is an error of the write, which names it
  io::start_hdf5();
  try {
    petsc::Session session{argc, argv};
    // Printed before the session ends: a rank that ends with an error takes the others with it, also one that has yet
    // to say why.
    const std::string failure = failure_of(PETSC_COMM_WORLD, [&] {
      session.insert_options(help);
      if (session.version_requested()) {
        print_versions(PETSC_COMM_WORLD);
        return;
      }
      explain_common_keys(PETSC_COMM_WORLD);
      code = program(PETSC_COMM_WORLD);
      if (petsc::Session::help_found_nothing()) {
        throw InputError{"-help: no key of that topic; topics are words of keys, such as beam, filter, support, ts"};
      }
    });
    if (!failure.empty()) {
      code = 1;
      petsc::Session::forget_unused_options();
      if (petsc::Session::on_first_rank()) {
        std::fprintf(stderr, "udar: error: %s\n", failure.c_str());
        std::fflush(stderr);
      }
    }
  } catch (const std::exception& error) {  // before MPI is up
    if (petsc::Session::on_first_rank()) {
      std::fprintf(stderr, "udar: error: %s\n", petsc::with_option_keys(error.what()).c_str());
    }
    code = 1;
  }
  return code;
}

}  // namespace udar::app
