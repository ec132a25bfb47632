#include "fuzz/harness.hpp"

#include <petscsys.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "udar/io/hdf5_file.hpp"
#include "udar/petsc/option_sources.hpp"
#include "udar/petsc/session.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::fuzz {
namespace {

std::string& folder() {
  static std::string path;
  return path;
}

void remove_folder() {
  std::error_code ignored;
  std::filesystem::remove_all(folder(), ignored);
}

}  // namespace

void start() {
  // Crashes are for the fuzzer and the sanitizers, neither for PETSc nor for Open MPI.
  setenv("OMPI_MCA_opal_signal", "", 1);
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 1);
  unsetenv("PETSC_OPTIONS");
  std::array<std::string, 3> words{"udar-fuzz", "-skip_petscrc", "-no_signal_handler"};
  static std::array<char*, 4> arguments{words[0].data(), words[1].data(), words[2].data(), nullptr};
  io::start_hdf5();
  static const petsc::Session* const kSession = new petsc::Session{3, arguments.data(), nullptr};  // to the end
  static_cast<void>(kSession);
  folder() = (std::filesystem::temp_directory_path() / "udar-fuzz-XXXXXX").string();
  if (mkdtemp(folder().data()) == nullptr) {
    std::perror(folder().c_str());
    std::abort();
  }
  std::filesystem::current_path(folder());
  std::atexit(remove_folder);
}

void write_file(const std::string& name, std::string_view content) {
  std::ofstream file{name, std::ios::binary};
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
}

void insert_case(const std::string& yaml) {
  static_cast<void>(petsc::take_warnings());
  UDAR_CALL(PetscOptionsClear(nullptr));
  petsc::insert_source(PETSC_COMM_WORLD, {.kind = petsc::OptionSource::Kind::yaml_text, .text = yaml});
}

}  // namespace udar::fuzz

int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  udar::fuzz::start();
  return 0;
}
