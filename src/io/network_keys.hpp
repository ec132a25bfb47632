#pragma once
/// @file
/// What YAML says of sections, junctions and members, by themselves or by their groups.

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/yaml_thing.hpp"
#include "udar/structure/network.hpp"

namespace udar::io {

/// @brief Names of things and their numbers, in their order.
class NameTable {
 public:
  /// @param what the things are, for messages: "section"
  explicit NameTable(const char* what) : what_{what} {}

  /// @throws InputError if the name is there
  void add(const YamlThing& thing, const Given<std::string>& name);
  /// @throws InputError if the name is not there, naming some that are
  [[nodiscard]] std::size_t find(const YamlThing& thing, const Given<std::string>& name) const;
  [[nodiscard]] std::size_t size() const noexcept { return numbers_.size(); }

 private:
  std::string what_;
  std::map<std::string, std::size_t> numbers_;
};

/// @brief Into which elements a member is cut: so many, such of at most this length, or these.
struct Division {
  std::size_t elements = 0;
  double length = 0.0;            ///< [m]; 0: by `elements`
  std::vector<double> lengths{};  ///< of each [m]; empty: equal or graded ones
};

/// @brief What members, and groups of them, may say.
struct MemberKeys {
  std::optional<Given<std::size_t>> section{};
  std::optional<Given<Division>> division{};
  std::optional<Given<double>> grading{};  ///< length of the last element over that of the first
  std::optional<Given<Place>> orientation{};
  std::array<std::optional<Given<std::array<double, 3>>>, 2> joint{};
  std::array<std::optional<Given<Place>>, 2> offset{};
};

/// @brief What junctions, and groups of them, may say.
struct JunctionKeys {
  std::optional<Given<std::array<bool, 6>>> held{};
  std::optional<Given<std::array<double, 6>>> stiffness{};
  std::optional<Given<double>> mass{};
};

/// @name Each asks a thing for the keys of its kind. @throws InputError naming line, column, value and unit
/// @{
[[nodiscard]] MemberSection read_section(YamlThing& thing);
[[nodiscard]] std::optional<Given<Place>> read_place(YamlThing& thing, const char* key);
/// @param of_mesh whether elements are a mesh's, and ends have no order
[[nodiscard]] MemberKeys read_member_keys(YamlThing& thing, const NameTable& sections, bool of_mesh);
[[nodiscard]] JunctionKeys read_junction_keys(YamlThing& thing);
/// @}

/// @brief Adds what a group says to what others said. @throws InputError if both say the same
void add_group(MemberKeys& keys, const MemberKeys& group, const YamlThing& thing);
void add_group(JunctionKeys& keys, const JunctionKeys& group, const YamlThing& thing);
/// @brief Fills in what a thing does not say by itself.
void fill(MemberKeys& own, const MemberKeys& group);
void fill(JunctionKeys& own, const JunctionKeys& group);

void apply(Junction& junction, const JunctionKeys& keys);
/// Without division, which needs the length. @throws InputError if there are many sections and none is said
void apply(Member& member, const MemberKeys& keys);

}  // namespace udar::io
