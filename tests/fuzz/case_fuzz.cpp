// A case file: keys in YAML, read, checked and made what is run.

#include <cstring>

#include "fuzz/harness.hpp"
#include "udar/app/case.hpp"
#include "udar/app/memory_size.hpp"
#include "udar/petsc/option_sources.hpp"
#include "udar/petsc/options.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace udar;
  const std::string yaml{reinterpret_cast<const char*>(data), size};
  fuzz::allow_refusal([&] {
    fuzz::insert_case(yaml);
    petsc::insert_source(PETSC_COMM_WORLD,
                         {.kind = petsc::OptionSource::Kind::yaml_text, .text = "structure_memory: 1e8\n"});
    petsc::check_petsc_options();
    const app::CaseInput input = app::read_case(PETSC_COMM_WORLD);
    petsc::check_unknown_options(PETSC_COMM_WORLD);
    app::refuse_large_memory(PETSC_COMM_WORLD, input);
    if (!input.filter.automatic) {  // which computes modes
      static_cast<void>(app::resolve(PETSC_COMM_WORLD, input));
    }
  });
  return 0;
}
