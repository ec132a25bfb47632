#pragma once
/// @file
/// The readers of a case, one per group of options, and what they share.

#include <mpi.h>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/io/table_file.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {

using Strings = std::vector<std::string>;
using Numbers = std::vector<double>;

/// @brief An option that takes one number for each of some things, or one for all.
struct NumberList {
  const char* key;
  Numbers values{};  ///< the default, then what was given
  bool given = false;

  /// @throws InputError naming option, value, range and unit
  void read(petsc::OptionGroup& group, const char* unit, petsc::Range range, const char* text) {
    given = group.reals(key, values, unit, range, text);
  }
  /// As many entries as things. @throws InputError naming the counts, and what things there are
  void spread(std::size_t count, const char* per_thing) { values = petsc::one_per(key, values, count, per_thing); }
  [[nodiscard]] double operator[](std::size_t i) const { return values[i]; }
};

/// @brief The keys that place things of one kind, and what they say of them: along x, in space, at junctions.
struct PlaceKeys {
  std::array<const char*, 2> position;  ///< key, text; null: there is none
  std::array<const char*, 2> place;
  std::array<const char*, 2> junction;
  const char* thing;
};

/// @brief Where they are, in that order. @throws InputError naming option, value and what is expected
[[nodiscard]] std::vector<Place> read_places(petsc::OptionGroup& group, const PlaceKeys& keys,
                                             const StructureInput& structure);

/// What lists of supports must match.
inline constexpr const char* kPerSupport = "one per -support_position";

/// A word of an option and what it stands for.
template <class T>
using Names = std::pair<const char*, T>;

[[nodiscard]] Numbers column(const io::Table& table, std::size_t index);

/// @brief Refuses a table whose first column does not ascend.
/// @param jumps whether two equal values are a jump
/// @throws InputError naming option, file and row
void require_ascending(const char* option, const std::string& path, const Numbers& values, const char* what,
                       bool jumps = false);

/// @brief Where a junction is. @param option that names it
/// @throws InputError naming option and junction if there is none of this name
[[nodiscard]] Place junction_place(const char* option, const std::string& name,
                                   const std::optional<NetworkParameters>& network);

/// @name Each reads one group of options, and explains it under `-help`; collective.
/// @{
[[nodiscard]] StructureInput read_structure(MPI_Comm comm);
/// @param asked whether there must be a network; else none of its options may be given
/// @param memory that it may ask for, see `refuse_large_memory`
[[nodiscard]] std::optional<NetworkParameters> read_network(MPI_Comm comm, bool asked, double memory);
[[nodiscard]] StartInput read_start(MPI_Comm comm);
/// @param network whose junctions they may be at; its laws have no tables yet
[[nodiscard]] std::vector<NodalLoad> read_loads(MPI_Comm comm, const std::optional<NetworkParameters>& network);
[[nodiscard]] std::vector<TravellingLoad> read_travelling_loads(MPI_Comm comm);
/// @brief Motions of the whole base, and of single places that hold the structure.
struct BaseInput {
  std::vector<BaseMotion> base;
  std::vector<HeldMotion> held;
};
[[nodiscard]] BaseInput read_base_motion(MPI_Comm comm, const std::optional<NetworkParameters>& network);
/// @param network whose nodes boxes are beside
[[nodiscard]] ContactInput read_contact(MPI_Comm comm, const std::optional<NetworkParameters>& network);
/// Strikers, and a support for each that is its face.
[[nodiscard]] std::pair<std::vector<Striker>, std::vector<Support>> read_strikers(MPI_Comm comm,
                                                                                  const StructureInput& structure);
/// Nodes that can touch each other, and a support for each pair that is its face. @param strikers whose faces come
/// first
[[nodiscard]] std::pair<std::vector<NodePair>, std::vector<Support>> read_pairs(MPI_Comm comm,
                                                                                const StructureInput& structure,
                                                                                std::size_t strikers);
[[nodiscard]] OutputInput read_output(MPI_Comm comm, const StructureInput& structure);
/// @param step_needed whether a step must be given
[[nodiscard]] TimeInput read_time(MPI_Comm comm, bool step_needed);
/// @}

}  // namespace udar::app
