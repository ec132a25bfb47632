// Tables of numbers in files, each through the option that names it, as far as the model that is made of it. The first
// letter says which.

#include "fuzz/harness.hpp"
#include "udar/app/case.hpp"
#include "udar/dynamics/model.hpp"

namespace {

using namespace udar;

constexpr const char* kBeam =
    "beam_length: 4\nbeam_elements: 4\nfilter_frequency: 100\nts_max_time: 0.1\noutput_interval: 0.01\n";
constexpr const char* kNetwork =
    "structure_type: network\nnetwork_grillage: [2, 2]\nnetwork_elements: 2\nfilter_frequency: 100\n"
    "ts_max_time: 0.1\n";
constexpr const char* kImport =
    "structure_type: import\nstructure_stiffness: none.mtx\nstructure_mass: none.mtx\nfilter_frequency: 100\n";

std::string case_for(char letter) {
  switch (letter) {
    case 'm':
      return std::string{kBeam} + "support_position: 2\nsupport_motion: table.csv\n";
    case 'l':
      return std::string{kBeam} + "load_position: 1\nload_table: table.csv\n";
    case 's':
      return std::string{kBeam} + "initial_shape: table.csv\n";
    case 'h':
      return std::string{kNetwork} + "support_position: 0.5\nsupport_width: inf\nsupport_height_field: table.csv\n";
    case 'p':
      return std::string{kImport} + "structure_points: table.csv\n";
    default:
      return std::string{kBeam} + "ground_profile: table.csv\n";
  }
}

void evaluate(const app::Case& input) {
  for (const double place : {-1e300, -0.5, 0.0, 0.25, 1.0, 1e300}) {
    for (const Support& support : input.supports) {
      static_cast<void>(support.height_at(place));
      if (support.motion) {
        static_cast<void>(support.motion->at(place));
      }
      if (support.field) {
        static_cast<void>(support.field->at(place, 0.5 - place));
      }
    }
    for (const NodalLoad& load : input.loads) {
      static_cast<void>(load.table->at(place));
    }
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes{data, size};
  const char letter = bytes.number<char>();
  fuzz::write_file("table.csv", bytes.rest());
  fuzz::allow_refusal([&] {
    fuzz::insert_case(case_for(letter));
    const app::Case input = app::resolve(PETSC_COMM_WORLD, app::read_case(PETSC_COMM_WORLD));
    evaluate(input);
    if (!input.imported && !input.network) {
      const Model model{PETSC_COMM_WORLD, input};
    }
  });
  return 0;
}
