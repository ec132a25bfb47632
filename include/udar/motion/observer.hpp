#pragma once
/// @file
/// What the motion tells the outside world, and the interface of those who listen.

#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "udar/motion/step_records.hpp"
#include "udar/structure/field.hpp"

namespace udar {

struct MotionState;

/// @brief The energy ledger at one time [J]; sums over the whole structure, equal on every rank.
struct EnergyLedger {
  double kinetic = 0.0;             ///< 1/2 Vm' M Vm
  double line_strain = 0.0;         ///< bending, shear, foundation, end springs, tension
  double fictitious_springs = 0.0;  ///< 1/2 wf^2 (Ym-Yc)' M (Ym-Yc)
  double load_potential = 0.0;      ///< -F' Yc, gravity and loads, not inertia forces; zero for the line at y = 0
  double load_work = 0.0;           ///< minus the integral of dF/dt' Yc: what changing loads brought in since t = 0
  double support_springs = 0.0;     ///< in the springs of supports that are not rigid
  double support_work = 0.0;        ///< what moving supports brought in since t = 0
  double base_work = 0.0;           ///< what the base brought in by its motion since t = 0, in its own frame
  double lost_in_impacts = 0.0;     ///< lost in impacts and rests since t = 0
  double lost_in_dampers = 0.0;     ///< lost in dampers of supports and structure since t = 0
  double radiated = 0.0;            ///< lost into motions that a reduced model leaves out since t = 0
  double lost_in_hinges = 0.0;      ///< lost by yielding since t = 0; what hardening stores is in `line_strain`
  double initial = 0.0;             ///< total at t = 0
  double initial_potential = 0.0;   ///< `load_potential` at t = 0
  double base_potential = 0.0;      ///< -F' Yc of inertia forces, which is in `base_work`
  double initial_base_potential = 0.0;
  double scale = 0.0;  ///< what `drift` is relative to: the largest of `turned_over` so far

  [[nodiscard]] double total() const noexcept {
    return kinetic + line_strain + fictitious_springs + load_potential + support_springs;
  }
  /// The largest of what is stored, what forces and supports brought in, and what is lost; heights count from the
  /// start, so that nothing depends on where y is zero.
  [[nodiscard]] double turned_over() const noexcept {
    const double stored = kinetic + line_strain + fictitious_springs + support_springs;
    const double work_of_forces = load_work - (load_potential - initial_potential);
    return std::max({stored, std::abs(work_of_forces), std::abs(support_work), std::abs(base_work),
                     std::abs(lost_in_impacts), std::abs(lost_in_dampers), std::abs(radiated),
                     std::abs(lost_in_hinges)});
  }
  /// Relative error of the balance: (total + lost - brought in - initial) / scale; zero for the exact solution. Not a
  /// number where an energy is none.
  [[nodiscard]] double drift() const noexcept {
    const double error = total() + lost_in_impacts + lost_in_dampers + radiated + lost_in_hinges - load_work -
                         support_work - base_work - initial;
    return error == 0.0 ? 0.0 : error / scale;
  }
};

/// @brief The masses that were in contact over some time: hit, or at rest.
struct ContactZone {
  PetscInt masses = 0;
  double x_min = std::numeric_limits<double>::infinity();   ///< leftmost of them [m]; infinite if there are none
  double x_max = -std::numeric_limits<double>::infinity();  ///< rightmost [m]; minus infinity if there are none
};

/// @brief What the masses do and where the line is; the fields of a structure follow it.
inline constexpr std::array kMotionFields{
    FieldInfo{.name = "mass_position", .unit = "m", .body = Body::masses, .position = true, .gauge = "mass"},
    FieldInfo{.name = "mass_velocity", .unit = "m/s", .body = Body::masses, .gauge = "velocity"},
    FieldInfo{.name = "line_position", .unit = "m", .position = true, .gauge = "line"}};
/// @brief Where a beam yields: how far the line is turned plastically at each node.
inline constexpr FieldInfo kRotationField{.name = "plastic_rotation",
                                          .unit = "rad",
                                          .extremes = true,
                                          .gauge = "plastic_rotation",
                                          .label = "plastic rotation"};
/// @brief 1 where the mass was hit, rested or was pressed on since the listener's last snapshot.
inline constexpr FieldInfo kTouchedField{.name = "touched", .unit = "1", .body = Body::masses, .flag = true};
/// @brief 1 where the mass rests on a support, or the line presses on one; the last of the fields.
inline constexpr FieldInfo kRestingField{.name = "resting", .unit = "1", .body = Body::masses, .flag = true};

/// @brief A place that holds the structure and moves, at one time.
struct PlaceState {
  double displacement = 0.0;  ///< along its motion [m]
  double velocity = 0.0;      ///< [m/s]
  double force = 0.0;         ///< of it on the structure along its motion [N]
};

/// @brief A mass that travels along the structure, at one time.
struct RiderState {
  double x = 0.0;         ///< where it is along the beam, and beyond its ends [m]
  double height = 0.0;    ///< of the mass, y up [m]
  double velocity = 0.0;  ///< the same [m/s]
  double below = 0.0;     ///< where the line, or the road, is under it [m]
  double force = 0.0;     ///< of it on the line, or the road, y up [N]
};

/// @brief The state at one time; the spans hold this rank's points in order and live only during the call.
struct Snapshot {
  double time = 0.0;                        ///< [s]
  std::span<const Field> fields;            ///< the same in the same order in every snapshot of a run
  EnergyLedger energy;                      ///< [J], whole structure
  std::span<const double> support_impulse;  ///< of each support on the masses since t = 0 [N s], y up, all ranks
  std::span<const PlaceState> places{};     ///< that hold the structure and move, in the order of their motions
  std::span<const RiderState> riders{};     ///< masses that travel, on the first rank; on others without heights
  ContactZone zone{};                       ///< since the listener's last snapshot, this rank's masses

  /// @brief A field by its name: "mass_position", "moment", ... @throws std::out_of_range if there is none
  [[nodiscard]] std::span<const double> values(std::string_view name) const {
    return find_field(fields, name).numbers();
  }
};

/// @brief One mass hitting one support.
struct ImpactRecord {
  double time = 0.0;             ///< [s]
  PetscInt node = 0;             ///< global node number
  double x = 0.0;                ///< [m] along the beam
  PetscInt support = 0;          ///< index of the support; the floor comes after the last support
  double velocity_before = 0.0;  ///< [m/s] of the mass, y up
  double velocity_after = 0.0;   ///< [m/s]
  double impulse = 0.0;          ///< [N s] from the support on the mass, y up
  double energy_loss = 0.0;      ///< [J]
};

/// @brief One mass coming to rest on a support, or leaving it again.
struct RestRecord {
  double time = 0.0;     ///< [s]
  PetscInt node = 0;     ///< global node number
  double x = 0.0;        ///< [m]
  PetscInt support = 0;  ///< as in `ImpactRecord`
  bool release = false;  ///< false: the mass came to rest; true: it was released
};

/// @brief Events of one step on all ranks together.
struct EventCounts {
  PetscInt impacts = 0;
  PetscInt rests = 0;  ///< and releases
};

/// @brief Where a run stands after a step, equal on every rank.
struct Progress {
  double time = 0.0;          ///< [s]
  double end_time = 0.0;      ///< [s]
  PetscInt steps = 0;         ///< accepted so far
  PetscInt impacts = 0;       ///< so far, all ranks
  PetscInt resting = 0;       ///< masses at rest now
  double energy_drift = 0.0;  ///< at the last snapshot
  bool checkpoint = false;    ///< somebody wants one now
};

/// @brief Listens to a run. All calls are collective over the structure's communicator and may throw `FileError`
/// on all ranks together.
class Observer {
 public:
  Observer() = default;
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;
  virtual ~Observer() = default;

  /// Simulated time [s] between snapshots: one at t = 0, every multiple of it, exactly, and the end of the run; 0 for
  /// none.
  [[nodiscard]] virtual double interval() const { return 0.0; }
  /// The state at such a time.
  virtual void snapshot(const Snapshot& /*state*/) {}
  /// Impacts and rest events of this rank in one step, those of a node in order of time (there may be none here and
  /// some elsewhere). To be read in order, a block at a time: nobody holds all of them.
  virtual void events(const StepRecords<ImpactRecord>& /*impacts*/, const StepRecords<RestRecord>& /*rests*/,
                      const EventCounts& /*all*/) {}
  /// After every accepted step.
  virtual void step(const Progress& /*progress*/) {}
  /// @name What it must keep to go on in another run as if nothing had happened; `restore` comes before any snapshot.
  /// @{
  virtual void save(MotionState& /*state*/) const {}
  virtual void restore(const MotionState& /*state*/) {}
  /// @}
  /// Before a checkpoint: everything told so far must reach the disk, for the run that goes on from there tells nothing
  /// of it again.
  virtual void flush() {}
  /// After the last step, also of a run that was interrupted: everything buffered must reach the disk.
  virtual void finish() { flush(); }
};

}  // namespace udar
