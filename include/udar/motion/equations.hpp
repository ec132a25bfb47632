#pragma once
/// @file
/// The filtered equations of motion between impacts, and their energy.

#include <memory>
#include <span>
#include <vector>

#include "udar/contact/carried_masses.hpp"
#include "udar/contact/hinged_line.hpp"
#include "udar/contact/line_contact.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/motion/held_places.hpp"
#include "udar/motion/observer.hpp"
#include "udar/structure/initial_state.hpp"
#include "udar/structure/load.hpp"

namespace udar {

/// @brief Where the line stands at one time, one value per local node.
struct LineState {
  double time = 0.0;                  ///< [s]
  double begin = 0.0;                 ///< of the step whose forces it is under [s]
  std::vector<double> stretch;        ///< d = Yc - Ym [m]; the mass accelerates by wf^2 d
  std::vector<double> amplitude;      ///< of d in the corrected modes [m kg^(1/2)], on every rank: Yc is nearer by them
  std::vector<double> moment;         ///< [N m]; empty unless asked for
  std::vector<double> contact_force;  ///< at `LineContact::points`, away from the supports [N]
  std::vector<double> rotation{};     ///< plastic, of all hinges [rad]
  bool in_contact = false;            ///< whether there is any of them, equal on every rank
  Carried carried{};                  ///< by masses that travel
};

/// @brief What changing loads alone do to the line, by their rates: no mass moves.
struct LoadRate {
  std::vector<double> stretch;    ///< [m/s], one value per local node; empty: loads are steady
  std::vector<double> amplitude;  ///< of it in the corrected modes [m kg^(1/2)/s]
};

/// @brief Rayleigh damping of the filtered beam: the force -(mass M + stiffness D) Ym' on the masses, where D Ym' =
/// -wf^2 M d(Ym') and d(Ym') is the stretch that the masses' velocities alone would give the line. A mode of frequency
/// lambda has the damping ratio mass / (2 lambda) + stiffness lambda / 2.
struct Damping {
  double mass = 0.0;       ///< [1/s], >= 0
  double stiffness = 0.0;  ///< [s], >= 0

  [[nodiscard]] bool any() const noexcept { return mass != 0.0 || stiffness != 0.0; }
};

/// @brief Ym'' = wf^2 (Yc - Ym) with (wf^2 M + C) Yc = wf^2 M Ym + F(t), on absolute positions.
class Equations {
 public:
  /// @param contact supports that hold the line; null: nothing does @param yields whether it has plastic hinges
  /// @param held what holds it and moves; `line` knows of what is held rigidly
  /// @throws InputError naming -damping_mass or -damping_stiffness if it is negative or not finite, or does not go with
  /// a line in contact; what does not go with masses that travel
  Equations(FilteredStructure& line, const Loads& loads, const InitialState& initial, const Damping& damping = {},
            std::unique_ptr<LineContact> contact = nullptr, std::vector<double> damping_ratio = {}, bool yields = false,
            std::vector<HeldMove> held = {});

  [[nodiscard]] const Damping& damping() const noexcept { return damping_; }
  /// Besides, of each flexible mode, the last of all that follow; empty: none.
  [[nodiscard]] const std::vector<double>& damping_ratio() const noexcept { return damping_ratio_; }

  /// Null where nothing holds the line.
  [[nodiscard]] LineContact* line_contact() const noexcept { return line_contact_.get(); }
  /// What holds it and moves.
  [[nodiscard]] const HeldPlaces& held() const noexcept { return held_; }
  /// Null where no mass travels along it.
  [[nodiscard]] CarriedMasses* carried() const noexcept { return carried_.get(); }
  /// Null where the line stays elastic.
  [[nodiscard]] HingedLine* hinges() const noexcept { return hinges_.get(); }
  /// Whether the masses are on filter springs, not those of the line itself.
  [[nodiscard]] bool filtered() const noexcept { return line_->parameters().filtered(); }

  /// No frequency of the motion is higher [rad/s], whoever touches.
  [[nodiscard]] double frequency_bound() const;

  /// @brief Solves for the line at a time, with what its supports do to it. @param[in] mass_position Ym [m] @note
  /// Collective.
  /// @param rotations plastic, of all hinges; empty: those that they have now
  void evaluate(const Instant& at, std::span<const double> mass_position, LineState& state, bool with_moment = false,
                std::span<const double> rotations = {});

  /// @brief d(Vm) [m/s]: the rate of the stretch while loads are steady. @param[in] mass_velocity Vm [m/s]
  /// @note Collective.
  void evaluate_rate(std::span<const double> mass_velocity, std::span<double> stretch_rate);

  /// @brief Adds to it what masses that travel make of it, if there are any.
  /// @note Collective; with such masses a line solve.
  void add_carried_rate(const Instant& at, std::span<const double> mass_position, std::span<const double> mass_velocity,
                        std::span<double> stretch_rate);

  /// @brief What changing loads add to it just after time t, until their next kink.
  /// @note Collective; one line solve between two kinks.
  [[nodiscard]] const LoadRate& load_rate(double time);

  /// @brief Yc - Ym of the line [m], one value per local node: the stretch, less what corrected modes put into the
  /// pull.
  [[nodiscard]] std::vector<double> line_stretch(const LineState& state) const;
  /// Yc of the line [m], one value per local node. @param mass_position Ym, for which `state` was found [m]
  [[nodiscard]] std::vector<double> line_position(const LineState& state, std::span<const double> mass_position) const;

  /// @brief Kinetic, strain, spring and load energy [J], of supports' springs that of those that hold the line. The
  /// scale of the ledger is what rounding alone lets one judge by; its other entries are left at zero.
  /// @param state with moment
  /// @note Collective: one reduction of eight numbers.
  [[nodiscard]] EnergyLedger energy(const LineState& state, std::span<const double> mass_position,
                                    std::span<const double> mass_velocity);

  /// @brief Where held places are and how hard they push. @param mass_position Ym [m] @param line_position Yc [m]
  /// @note Collective if there are any.
  [[nodiscard]] std::vector<PlaceState> places(const Instant& at, std::span<const double> mass_position,
                                               std::span<const double> line_position) const;

  /// @brief Masses that travel at the time of a line, on the first rank; on others their places and forces alone.
  [[nodiscard]] std::vector<RiderState> riders(const LineState& state, std::span<const double> mass_position,
                                               std::span<const double> mass_velocity) const;

  /// Height of the reference axis at the local nodes [m].
  [[nodiscard]] std::span<const double> axis() const noexcept { return axis_; }
  [[nodiscard]] const MassPoints& points() const noexcept { return line_->points(); }
  [[nodiscard]] FilteredStructure& line() const noexcept { return *line_; }
  [[nodiscard]] const Loads& loads() const noexcept { return *loads_; }

 private:
  void refuse_with_riders() const;

  FilteredStructure* line_;
  const Loads* loads_;
  Damping damping_;
  std::vector<double> damping_ratio_;
  std::unique_ptr<LineContact> line_contact_;
  std::unique_ptr<CarriedMasses> carried_;
  std::unique_ptr<HingedLine> hinges_;
  HeldPlaces held_;
  std::vector<double> axis_;          // reference axis at the local nodes
  std::vector<double> displacement_;  // work: Ym minus axis, or a velocity
  std::vector<double> work_;          // loads, if they must be added up
  LoadRate load_rate_;
  std::size_t load_interval_ = 0;  // of `load_rate_`
};

}  // namespace udar
