// A restart file of any bytes: an even first byte has them as they are, an odd one gives them a right checksum, behind
// which HDF5 has to read them.

#include "fuzz/falls.hpp"
#include "io/file_checksum.hpp"
#include "udar/io/checkpoint.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace udar;
  fuzz::Bytes bytes{data, size};
  const fuzz::Fall& fall = fuzz::falls()[1];
  const io::PointOrder points{fall.model->structure->points()};
  const bool sealed = bytes.choice(2) == 1;
  fuzz::write_file("restart.h5", bytes.rest());
  if (sealed) {
    static_cast<void>(io::append_checksum(PETSC_COMM_WORLD, "restart.h5"));
  }
  fuzz::allow_refusal([&] { static_cast<void>(io::read_checkpoint(points, "restart.h5")); });
  return 0;
}
