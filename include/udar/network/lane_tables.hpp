#pragma once
/// @file
/// Tables of members side by side that do not share any.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "udar/network/member_tables.hpp"
#include "udar/structure/member_packs.hpp"

namespace udar::network {

inline constexpr std::size_t kLanes = MemberPack::kLanes;

/// One number of each member of a pack.
struct alignas(64) Lanes {
  std::array<double, kLanes> value{};
  double& operator[](std::size_t lane) { return value[lane]; }
  const double& operator[](std::size_t lane) const { return value[lane]; }
};

/// @brief What is read on the way through a pack: numbers that all lanes share, or those of each lane.
template <class Number>
struct TableView {
  std::array<const Gain<Number>*, 2> gains{};
  std::array<const std::array<Number, 4>*, 2> weights{};
  const std::array<Number, 2>* axial_weights = nullptr;
  const Number* releases = nullptr;
  const Number* keeps = nullptr;
  const typename Spacing<Number>::Element* elements = nullptr;  ///< of unequal ones
  const typename Spacing<Number>::Node* nodes = nullptr;
};

/// Of what lanes share.
[[nodiscard]] TableView<double> view_of(const MemberTables& tables);

/// @brief The same of torsion with rotary inertia.
template <class Number>
struct TurningView {
  const std::array<Number, 2>* weights = nullptr;
  const Number* releases = nullptr;
  const Number* keeps = nullptr;
  const typename Spacing<Number>::Element* elements = nullptr;
  const typename Spacing<Number>::Node* nodes = nullptr;
};
[[nodiscard]] TurningView<double> turning_of(const MemberTables& tables);

/// @brief `MemberTables` of unequal elements, of each lane its own.
class LaneTables {
 public:
  /// @param tables of each lane, of as many elements, one h and one K; those behind the last lane are it again
  explicit LaneTables(std::span<const MemberTables* const, kLanes> tables);

  [[nodiscard]] TableView<Lanes> view() const;
  [[nodiscard]] TurningView<Lanes> turning() const;
  [[nodiscard]] std::size_t bytes() const noexcept;

 private:
  /// `AxialTable` by lanes.
  struct Rods {
    std::vector<Lanes> releases;
    std::vector<Lanes> keeps;
    std::vector<std::array<Lanes, 2>> weights;
  };
  static void put(const AxialTable& own, std::size_t lane, Rods& all);

  std::array<std::vector<Gain<Lanes>>, 2> gains_;
  std::array<std::vector<std::array<Lanes, 4>>, 2> weights_;
  Rods axial_;
  Rods turning_;
  Spacing<Lanes> spacing_;
};

}  // namespace udar::network
