#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "app/input/readers.hpp"
#include "udar/app/memory_size.hpp"
#include "udar/io/network_file.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"
#include "udar/structure/member_shape.hpp"
#include "udar/structure/network_place.hpp"

namespace udar::app {
namespace {

using petsc::OptionGroup;
using ShapeKind = MemberShape::Kind;

enum class MemberTheory : std::uint8_t { euler_bernoulli, timoshenko };

/// One size of a cross-section: the shapes that have it, and where it goes.
struct ShapeSize {
  const char* key;
  std::vector<ShapeKind> shapes;
  double MemberShape::* value;
  const char* text;
};

/// What makes a network without a file: rows of junctions, one kind of member.
class Generator {
 public:
  void read(OptionGroup& group) {
    count(group.integers("-network_grillage", grillage_, petsc::at_least(1.0),
                         "nx,ny: so many junctions along x and z, in the horizontal plane"));
    count(group.integers("-network_lattice", lattice_, petsc::at_least(1.0),
                         "nx,ny,nz: so many junctions along x, y (up) and z"));
    count(group.reals("-network_spacing", spacing_, "m", petsc::positive(),
                      "for grillage and lattice: length of members, one for all or one along each axis of theirs"));
    count(group.integer("-network_elements", elements_, petsc::at_least(1.0),
                        "for grillage and lattice: elements of a member"));
    count(group.real("-network_grading", grading_, "-", petsc::positive(),
                     "for grillage and lattice: length of a member's last element over that of its first, a geometric "
                     "progression between; 1: equal ones"));
    read_section(group);
  }

  /// How many of its keys were given.
  [[nodiscard]] int keys() const noexcept { return keys_; }
  [[nodiscard]] bool grillage() const noexcept { return !grillage_.empty(); }
  [[nodiscard]] bool lattice() const noexcept { return !lattice_.empty(); }

  [[nodiscard]] NetworkParameters make(MPI_Comm comm, double memory) const {
    const char* const key = grillage() ? "-network_grillage" : "-network_lattice";
    const std::vector<PetscInt> counts =
        petsc::one_per(key, grillage() ? grillage_ : lattice_, grillage() ? 2 : 3, "one along each axis");
    const Numbers spacing = petsc::one_per("-network_spacing", spacing_, counts.size(), "one along each axis");
    RegularNetwork regular;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const std::size_t axis = grillage() ? 2 * i : i;
      regular.junctions.at(axis) = static_cast<std::size_t>(counts[i]);
      regular.spacing.at(axis) = spacing[i];
    }
    regular.elements = static_cast<std::size_t>(elements_);
    regular.grading = grading_;
    regular.section = section_;
    require_countable(key, regular);
    refuse_large_memory(comm, key_and(key, counts), size_of(regular), memory);
    return regular_network(regular);
  }

 private:
  void count(bool given) { keys_ += given ? 1 : 0; }

  void read_section(OptionGroup& group) {
    constexpr std::array kShapes{Names<ShapeKind>{"circle", ShapeKind::circle},
                                 Names<ShapeKind>{"tube", ShapeKind::tube},
                                 Names<ShapeKind>{"rectangle", ShapeKind::rectangle}};
    constexpr std::array kMemberTheories{Names<MemberTheory>{"euler_bernoulli", MemberTheory::euler_bernoulli},
                                         Names<MemberTheory>{"timoshenko", MemberTheory::timoshenko}};
    MemberShape shape{.kind = ShapeKind::circle, .radius = 0.05};
    count(group.choice<ShapeKind>("-network_section", shape.kind, kShapes,
                                  "for grillage and lattice: cross-section of all members"));
    const std::array sizes{
        ShapeSize{"-network_section_radius",
                  {ShapeKind::circle, ShapeKind::tube},
                  &MemberShape::radius,
                  "outer radius of circle or tube"},
        ShapeSize{
            "-network_section_inner_radius", {ShapeKind::tube}, &MemberShape::inner_radius, "inner radius of tube"},
        ShapeSize{"-network_section_width",
                  {ShapeKind::rectangle},
                  &MemberShape::width,
                  "width of rectangle, along the member's z axis, which is horizontal"},
        ShapeSize{"-network_section_height",
                  {ShapeKind::rectangle},
                  &MemberShape::height,
                  "height of rectangle, along the member's y axis: up, of a member along y along x"}};
    for (const ShapeSize& size : sizes) {
      const bool given = group.real(size.key, shape.*size.value, "m", petsc::positive(), size.text);
      const bool used = std::ranges::find(size.shapes, shape.kind) != size.shapes.end();
      count(given);
      if (given && !used) {
        throw InputError{std::string{"option "} + size.key + " does not belong to the -network_section in use"};
      }
      if (used && !(shape.*size.value > 0.0)) {
        throw InputError{std::string{"option "} + size.key + " is needed by the -network_section in use"};
      }
    }
    if (shape.kind == ShapeKind::tube && !(shape.inner_radius < shape.radius)) {
      throw InputError{"option -network_section_inner_radius must be smaller than -network_section_radius [m]"};
    }
    double poisson = 0.3;
    MemberTheory theory = MemberTheory::euler_bernoulli;
    section_ = {.name = "members", .youngs_modulus = 2.1e11, .density = 7850.0};
    count(group.real("-network_young_modulus", section_.youngs_modulus, "Pa", petsc::positive(),
                     "for grillage and lattice: Young's modulus E"));
    count(group.real("-network_poisson_ratio", poisson, "-", petsc::between(0.0, 0.5),
                     "for grillage and lattice: Poisson's ratio, for torsion and shear"));
    count(group.real("-network_density", section_.density, "kg/m^3", petsc::positive(),
                     "for grillage and lattice: density"));
    count(group.choice<MemberTheory>("-network_theory", theory, kMemberTheories,
                                     "for grillage and lattice: bending alone, or bending and shear (kGA)"));
    section_.shear_modulus = section_.youngs_modulus / (2.0 * (1.0 + poisson));
    give_shape(section_, shape, theory == MemberTheory::timoshenko);
  }

  static std::string key_and(const char* key, const std::vector<PetscInt>& counts) {
    std::string text = std::string{"option "} + key + ": ";
    for (const PetscInt count : counts) {
      text += (text.ends_with(' ') ? "" : ",") + std::to_string(count);
    }
    return text;
  }

  static ModelSize size_of(const RegularNetwork& regular) {
    ModelSize size{.junctions = 1.0};
    for (const std::size_t count : regular.junctions) {
      size.junctions *= static_cast<double>(count);
    }
    for (const std::size_t count : regular.junctions) {
      size.members += size.junctions * (1.0 - 1.0 / static_cast<double>(count));
    }
    size.inner_nodes = size.members * (static_cast<double>(regular.elements) - 1.0);
    return size;
  }

  /// Three unknowns a node are counted in PETSc's integers.
  static void require_countable(const char* key, const RegularNetwork& regular) {
    const auto& [x, y, z] = regular.junctions;
    const double junctions = static_cast<double>(x) * static_cast<double>(y) * static_cast<double>(z);
    const double nodes = junctions * (1.0 + 3.0 * (static_cast<double>(regular.elements) - 1.0));
    if (3.0 * nodes >= static_cast<double>(std::numeric_limits<PetscInt>::max())) {
      throw InputError{std::string{"option "} + key + ": the network has more nodes than integers of " +
                       std::to_string(8 * sizeof(PetscInt)) + " bits count"};
    }
  }

  int keys_ = 0;
  std::vector<PetscInt> grillage_;
  std::vector<PetscInt> lattice_;
  Numbers spacing_{1.0};
  PetscInt elements_ = 8;
  double grading_ = 1.0;
  MemberSection section_;
};

/// Where the network stands.
class Standing {
 public:
  void read(OptionGroup& group) {
    given_ = group.reals("-network_rotation", angles_, "rad", petsc::any(),
                         "turns the network about the origin: about x, then y, then z, three angles; what holds "
                         "junctions stays along x, y, z");
    given_ |= group.reals("-network_shift", shift_, "m", petsc::any(), "moves it then along x, y, z, three numbers");
  }
  [[nodiscard]] bool given() const noexcept { return given_; }

  [[nodiscard]] NetworkParameters of(NetworkParameters network) const {
    place_network(network, three("-network_rotation", angles_), three("-network_shift", shift_));
    return network;
  }

 private:
  static Place three(const char* key, const Numbers& given) {
    const Numbers values = petsc::one_per(key, given, 3, "along or about x, y, z");
    return {.x = values[0], .y = values[1], .z = values[2]};
  }

  bool given_ = false;
  Numbers angles_{0.0, 0.0, 0.0};
  Numbers shift_{0.0, 0.0, 0.0};
};

/// What is said of any network beside what it is.
struct Treatment {
  NetworkPartition partition = NetworkPartition::metis;
  bool rotary_inertia = false;

  [[nodiscard]] NetworkParameters of(NetworkParameters network) const {
    network.partition = partition;
    network.rotary_inertia = rotary_inertia;
    return network;
  }
};

}  // namespace

Place junction_place(const char* option, const std::string& name, const std::optional<NetworkParameters>& network) {
  const std::string begin = std::string{"option "} + option + ": '" + name + "' is not allowed";
  if (!network) {
    throw InputError{begin + " without -structure_type network"};
  }
  const auto found = std::ranges::find(network->junctions, name, &Junction::name);
  if (found != network->junctions.end()) {
    return found->place;
  }
  constexpr std::size_t kShown = 8;
  std::string some;
  for (std::size_t i = 0; i < std::min(network->junctions.size(), kShown); ++i) {
    some += (i > 0 ? ", '" : "'") + network->junctions[i].name + "'";
  }
  throw InputError{begin + ", expected the name of a junction: " + some +
                   (network->junctions.size() > kShown ? ", ..." : "")};
}

std::optional<NetworkParameters> read_network(MPI_Comm comm, bool asked, double memory) {
  OptionGroup group{comm, "Network of members, for -structure_type network: from a file, or a regular one"};
  std::string file;
  std::string groups;
  group.string("-network_file", file,
               "YAML with sections, junctions, members and groups, or with sections, groups and the name of a mesh; or "
               "a Gmsh mesh of lines, whose name ends in .msh");
  group.string("-network_groups", groups, "for a mesh: YAML with sections and what each physical group means");
  constexpr std::array kPartitions{Names<NetworkPartition>{"metis", NetworkPartition::metis},
                                   Names<NetworkPartition>{"contiguous", NetworkPartition::contiguous}};
  Treatment treatment;
  const bool dealt = group.choice<NetworkPartition>(
      "-network_partition", treatment.partition, kPartitions,
      "how junctions are dealt to the ranks: by METIS, which cuts few members, or in their order");
  const bool rotary = group.boolean("-rotary_inertia", treatment.rotary_inertia,
                                    "nodes have the rotary inertia of their members about these, so that torsion "
                                    "vibrates; else it has no mass and follows at rest");
  Generator generator;
  generator.read(group);
  Standing standing;
  standing.read(group);
  if (petsc::Session::help_requested()) {
    return std::nullopt;
  }
  const bool from_file = !file.empty();
  const int sources = (from_file ? 1 : 0) + (generator.grillage() ? 1 : 0) + (generator.lattice() ? 1 : 0);
  if (!asked) {
    if (from_file || !groups.empty() || dealt || generator.keys() > 0 || standing.given()) {
      throw InputError{"options -network_* need -structure_type network"};
    }
    if (rotary) {
      throw InputError{
          "option -rotary_inertia needs -structure_type network: other structures have what their masses "
          "say, expected none"};
    }
    return std::nullopt;
  }
  if (sources != 1) {
    throw InputError{
        "option -structure_type: network needs one of -network_file, -network_grillage and "
        "-network_lattice, " +
        std::to_string(sources) + " given"};
  }
  if (!from_file) {
    if (!groups.empty()) {
      throw InputError{"option -network_groups: '" + groups + "' is not allowed without -network_file, a mesh"};
    }
    return treatment.of(standing.of(generator.make(comm, memory)));
  }
  if (generator.keys() > 0) {
    throw InputError{
        "option -network_file: '" + file +
        "' says all of its members, expected no other -network_* but -network_groups and -network_partition"};
  }
  return treatment.of(standing.of(io::read_network(comm, file, groups, [&](const NetworkParameters& read) {
    refuse_large_network(comm, "option -network_file: '" + file + "'", read, memory);
  })));
}

}  // namespace udar::app
