#pragma once
/// @file
/// What a case may need of an integrator.

#include <petscsys.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "udar/numerics/complementarity.hpp"

namespace udar {

/// @brief What not every integrator knows.
enum class Feature : std::uint8_t {
  filtered,           ///< masses on filter springs
  unfiltered,         ///< masses that are those of the line itself
  line_contact,       ///< supports that hold the line
  moving_supports,    ///< supports that move
  elastic_supports,   ///< supports that give way to masses
  elastic_line,       ///< supports that give way to the line that they hold
  many_points,        ///< more than `kFewPoints` points where supports hold the line
  mass_damping,       ///< Rayleigh damping by the masses
  stiffness_damping,  ///< Rayleigh damping by the line's springs
  modal_damping,      ///< a damping ratio for each mode
  friction,           ///< supports that rub
  contact_laws,       ///< supports with a law of contact under masses
  laws_of_line,       ///< the same under the line that they hold
  strikers,           ///< masses that strike the structure
  riders,             ///< masses that travel along it
  laws_of_strikers,   ///< strikers with a law of contact
  yielding,           ///< plastic hinges of the line
  many_hinges,        ///< more than `kFewPoints` of them
  yielding_held,      ///< plastic hinges of a line that supports hold
};

/// Contact points of the line whose sets can be told one by one.
inline constexpr std::size_t kFewPoints = Complementarity::kMostFollowed;

/// @brief A set of features.
class Features {
 public:
  constexpr Features() = default;
  constexpr Features(std::initializer_list<Feature> features) {
    for (const Feature feature : features) {
      bits_ |= bit(feature);
    }
  }
  [[nodiscard]] constexpr bool has(Feature feature) const noexcept { return (bits_ & bit(feature)) != 0; }
  [[nodiscard]] constexpr bool covers(Features needed) const noexcept { return (needed.bits_ & ~bits_) == 0; }
  [[nodiscard]] constexpr bool meets(Features others) const noexcept { return (others.bits_ & bits_) != 0; }
  constexpr void add(Feature feature, bool whether = true) noexcept { bits_ |= whether ? bit(feature) : 0U; }

 private:
  [[nodiscard]] static constexpr std::uint32_t bit(Feature feature) noexcept {
    return std::uint32_t{1} << static_cast<unsigned>(feature);
  }
  std::uint32_t bits_ = 0;
};

/// @brief A type of `TS` that udar can run, as the list of them in configure.cpp has it.
struct IntegratorType {
  const char* name = nullptr;            ///< for `-ts_type`
  Features can;                          ///< see `Feature`
  const char* knows = nullptr;           ///< the same in words, for who asked for more
  PetscErrorCode (*enroll)() = nullptr;  ///< makes it known to PETSc; null: PETSc's own
  std::int64_t default_up_to = -1;       ///< so many nodes that can touch something it is a default
  Features default_without{};            ///< but not where one of these is needed
};

}  // namespace udar
