#pragma once
/// @file
/// The keys of laws of contact.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/input/readers.hpp"
#include "udar/contact/contact_law.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {

enum class LawKind : std::uint8_t { none, hertz, hunt_crossley, bilinear, crush, table };

/// @brief A law of contact for each support, and its parameters.
class LawLists {
 public:
  void read(petsc::OptionGroup& group);
  /// One entry per support in each list that is given. @throws InputError if one is given that no law takes
  void settle(std::size_t supports);
  /// @brief That of a support; null: none. @note Collective: reads a table.
  /// @throws InputError naming quantity, value and range
  [[nodiscard]] std::shared_ptr<const ContactLaw> law(MPI_Comm comm, std::size_t support) const;
  /// How far into the structure the face of a support is moved, so that the law presses with the preload there [m].
  [[nodiscard]] double interference(const ContactLaw& law, std::size_t support) const;
  /// As given.
  [[nodiscard]] const char* name(std::size_t support) const;

 private:
  void refuse_idle() const;

  std::vector<LawKind> kind_{LawKind::none};
  bool given_ = false;
  NumberList stiffness_{"-contact_stiffness", {0.0}};
  NumberList exponent_{"-contact_exponent", {1.5}};
  NumberList damping_{"-contact_damping", {0.0}};
  NumberList unloading_{"-contact_unloading_stiffness", {0.0}};
  NumberList plateau_{"-contact_plateau_force", {0.0}};
  NumberList bottoming_{"-contact_bottoming_compression"};
  NumberList bottoming_stiffness_{"-contact_bottoming_stiffness", {0.0}};
  std::vector<std::string> table_{"none"};
  bool table_given_ = false;
  NumberList preload_{"-contact_preload", {0.0}};
};

}  // namespace udar::app
