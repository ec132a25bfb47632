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

/// @brief The keys of a law of contact and its parameters.
struct LawKeys {
  const char* law;
  const char* stiffness;
  const char* exponent;
  const char* damping;
  const char* unloading;
  const char* plateau;
  const char* bottoming;
  const char* bottoming_stiffness;
  const char* table;
  const char* preload;   ///< null: there is none
  const char* quantity;  ///< how quantities begin: "contact" of "contact stiffness"
  const char* thing;     ///< that has a law, "support"
  const char* per_thing;
};
inline constexpr LawKeys kLawsOfSupports{.law = "-contact_law",
                                         .stiffness = "-contact_stiffness",
                                         .exponent = "-contact_exponent",
                                         .damping = "-contact_damping",
                                         .unloading = "-contact_unloading_stiffness",
                                         .plateau = "-contact_plateau_force",
                                         .bottoming = "-contact_bottoming_compression",
                                         .bottoming_stiffness = "-contact_bottoming_stiffness",
                                         .table = "-contact_table",
                                         .preload = "-contact_preload",
                                         .quantity = "contact",
                                         .thing = "support",
                                         .per_thing = kPerSupport};

enum class LawKind : std::uint8_t { none, hertz, hunt_crossley, bilinear, crush, table };

/// @brief A law of contact for each of some things, supports or strikers, and its parameters.
class LawLists {
 public:
  /// @param keys must live as long
  explicit LawLists(const LawKeys& keys) : keys_{&keys} {}
  void read(petsc::OptionGroup& group);
  /// One entry per thing in each list that is given. @throws InputError if one is given that no law takes
  void settle(std::size_t supports);
  /// @brief That of a thing; null: none. @note Collective: reads a table.
  /// @throws InputError naming quantity, value and range
  [[nodiscard]] std::shared_ptr<const ContactLaw> law(MPI_Comm comm, std::size_t support) const;
  /// How far into the structure the face of a support is moved, so that the law presses with the preload there [m].
  [[nodiscard]] double interference(const ContactLaw& law, std::size_t support) const;
  /// As given.
  [[nodiscard]] const char* name(std::size_t support) const;

 private:
  void refuse_idle() const;
  [[nodiscard]] std::shared_ptr<const ContactLaw> made(MPI_Comm comm, std::size_t support) const;

  const LawKeys* keys_;
  std::vector<LawKind> kind_{LawKind::none};
  bool given_ = false;
  NumberList stiffness_{keys_->stiffness, {0.0}};
  NumberList exponent_{keys_->exponent, {1.5}};
  NumberList damping_{keys_->damping, {0.0}};
  NumberList unloading_{keys_->unloading, {0.0}};
  NumberList plateau_{keys_->plateau, {0.0}};
  NumberList bottoming_{keys_->bottoming};
  NumberList bottoming_stiffness_{keys_->bottoming_stiffness, {0.0}};
  std::vector<std::string> table_{"none"};
  bool table_given_ = false;
  NumberList preload_{keys_->preload, {0.0}};
};

/// @brief Refuses an impact law for what gives way, by a key; a restitution of 1 in a list for others passes.
/// @param decides who says in its place how a mass leaves @param restitution the list, with its key
void refuse_impact_law(const char* key, const char* decides, const NumberList& restitution, const char* yield_speed,
                       const Support& support);

}  // namespace udar::app
