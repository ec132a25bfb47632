/// @file
/// main() of every GoogleTest binary: the same tests run on any number of ranks, and fail on all if they fail on one.

#include <gtest/gtest.h>
#include <mpi.h>

#include <chrono>
#include <csignal>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "udar/io/hdf5_file.hpp"
#include "udar/petsc/session.hpp"

namespace {

/// How long the other ranks may need to reach the end of a test that failed here before they count as stuck in a
/// collective this rank has left. Far above the duration of any test.
constexpr std::chrono::seconds kPatience{60};

int rank_in(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

/// Rank 0 keeps GoogleTest's printer; the others speak only when something fails.
class FailuresOfThisRank : public testing::EmptyTestEventListener {
 public:
  explicit FailuresOfThisRank(int rank) : rank_{rank} {}

  void OnTestStart(const testing::TestInfo& test) override {
    test_ = std::string{test.test_suite_name()} + '.' + test.name();
  }
  // GoogleTest holds its lock here: asking it for the current test would wait for ever.
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (result.failed()) {
      std::cerr << "[rank " << rank_ << "] " << test_ << ' '
                << (result.file_name() != nullptr ? result.file_name() : "unknown file") << ':' << result.line_number()
                << '\n'
                << result.message() << '\n'
                << std::flush;
    }
  }

 private:
  int rank_;
  std::string test_{"outside a test"};
};

/// Ends every test on all ranks together, so that a rank that failed early does not meet the others in a later test.
class RanksInStep : public testing::EmptyTestEventListener {
 public:
  explicit RanksInStep(MPI_Comm comm) : comm_{comm} {}

  void OnTestEnd(const testing::TestInfo& test) override {
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ibarrier(comm_, &request);
    const bool failed = test.result()->Failed();
    const auto start = std::chrono::steady_clock::now();
    int arrived = 0;
    for (MPI_Test(&request, &arrived, MPI_STATUS_IGNORE); arrived == 0;
         MPI_Test(&request, &arrived, MPI_STATUS_IGNORE)) {
      if (failed && std::chrono::steady_clock::now() - start > kPatience) {
        std::cerr << "[rank " << rank_in(comm_) << "] left " << test.test_suite_name() << '.' << test.name()
                  << " with a failure and the other ranks do not follow; aborting\n"
                  << std::flush;
        MPI_Abort(comm_, 1);
      }
      std::this_thread::sleep_for(std::chrono::microseconds{100});
    }
  }

 private:
  MPI_Comm comm_;
};

int run_all_tests() {
  MPI_Comm comm = MPI_COMM_NULL;
  MPI_Comm_dup(MPI_COMM_WORLD, &comm);
  const int rank = rank_in(comm);
  testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
  if (rank != 0) {
    delete listeners.Release(listeners.default_result_printer());
    delete listeners.Release(listeners.default_xml_generator());
    listeners.Append(new FailuresOfThisRank{rank});
  }
  listeners.Append(new RanksInStep{comm});

  const int failed_here = RUN_ALL_TESTS() == 0 ? 0 : 1;
  int failed_ranks = 0;
  MPI_Allreduce(&failed_here, &failed_ranks, 1, MPI_INT, MPI_SUM, comm);
  if (rank == 0 && failed_here == 0 && failed_ranks > 0) {
    std::cerr << "[  FAILED  ] on " << failed_ranks << " other rank(s), see above\n";
  }
  MPI_Comm_free(&comm);
  return failed_ranks > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  // A PETSc options file of whoever runs the tests must not change what they test.
  std::string skip_user_options{"-skip_petscrc"};
  std::vector<char*> arguments(argv, argv + argc);
  arguments.push_back(skip_user_options.data());
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  char** values = arguments.data();

  std::signal(SIGXFSZ, SIG_IGN);  // as the programs do
  udar::io::start_hdf5();
  const udar::petsc::Session session{count, values, nullptr};
  return run_all_tests();
}
