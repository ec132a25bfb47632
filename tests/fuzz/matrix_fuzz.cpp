// Stiffness and mass of an imported structure: the first letter says whether in Matrix Market's or PETSc's form, a line
// of equal signs is between the two.

#include "fuzz/harness.hpp"
#include "udar/structure/imported.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace udar;
  fuzz::Bytes bytes{data, size};
  const std::string end = bytes.number<char>() == 'p' ? ".bin" : ".mtx";
  fuzz::write_file("stiffness" + end, bytes.part("\n====\n"));
  fuzz::write_file("mass" + end, bytes.rest());
  fuzz::allow_refusal([&] {
    const ImportedStructure structure{PETSC_COMM_WORLD,
                                      {.stiffness = "stiffness" + end,
                                       .mass = "mass" + end,
                                       .lumping = size % 2 == 0 ? Lumping::row : Lumping::hrz,
                                       .most_unknowns = 10000}};
  });
  return 0;
}
