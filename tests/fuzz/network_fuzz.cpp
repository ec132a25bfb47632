// A network in YAML, as far as the structure that is made of it.

#include "fuzz/harness.hpp"
#include "udar/app/memory_size.hpp"
#include "udar/io/network_file.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace udar;
  fuzz::write_file("network.yaml", {reinterpret_cast<const char*>(data), size});
  fuzz::allow_refusal([&] {
    const auto accept = [](const NetworkParameters& read) {
      app::refuse_large_network(PETSC_COMM_WORLD, "network", read, fuzz::kMemory);
    };
    const Network network{PETSC_COMM_WORLD, io::read_network(PETSC_COMM_WORLD, "network.yaml", "", accept)};
  });
  return 0;
}
