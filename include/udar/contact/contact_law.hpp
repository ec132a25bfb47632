#pragma once
/// @file
/// Laws of contact: the force of a support that gives way to masses otherwise than by a spring and a damper.

#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

namespace udar {

/// @brief By which of its ends a mass leaves a piece of a law.
enum class LawEnd : std::uint8_t {
  none,
  low,   ///< the compression falls to the lower end
  high,  ///< it grows to the upper one
  turn,  ///< it no longer grows
  pull,  ///< damper and spring together would pull, or no longer would
};

/// @brief Where a mass is in a law.
struct LawState {
  static constexpr int kOpen = -1;
  int piece = kOpen;
  double largest = 0.0;        ///< compression so far [m]; of laws that remember it
  double near = 0.0;           ///< compression below which the force does nothing that a motion shows [m]
  LawEnd zero = LawEnd::none;  ///< the end that is met at the start of an arc, by construction
  bool turned = false;         ///< and the rate is zero there

  [[nodiscard]] bool closed() const noexcept { return piece != kOpen; }
};

/// @brief A piece of a law: the force f [N] at a compression d [m] and its rate d' [m/s] between two ends.
///
/// f = `force` + `stiffness` (d - `from`), or with a coefficient f = `coefficient` d^`exponent` (1 + `damping` d').
struct LawPiece {
  static constexpr double kNowhere = std::numeric_limits<double>::infinity();
  double low = -kNowhere;    ///< [m]
  double high = kNowhere;    ///< [m]
  bool grows = false;        ///< it ends where the compression no longer grows
  double pulls = 0.0;        ///< not 0: it ends where this times (1 + `damping` d') turns negative
  double force = 0.0;        ///< [N]
  double stiffness = 0.0;    ///< [N/m]
  double from = 0.0;         ///< [m]
  double coefficient = 0.0;  ///< [N/m^exponent]
  double exponent = 1.0;
  double damping = 0.0;  ///< [s/m]

  [[nodiscard]] double at(double compression, double rate) const;
  /// df/dd without damping [N/m].
  [[nodiscard]] double tangent(double compression) const;
};

/// @brief A mass as a law sees it at one instant.
struct LawMotion {
  double compression = 0.0;  ///< d: how far the mass is behind the face of the support that nothing has touched [m]
  double rate = 0.0;         ///< d' [m/s]
  double mass = 0.0;         ///< carried by all of the support [kg]
  double resolution = 0.0;   ///< compressions below this do not count [m]
};

/// @brief A parameter of a law for restart files: its name with the unit, and its values.
using LawNumber = std::pair<std::string_view, std::vector<double>>;

/// @brief A law of contact for all of a support, whose masses share it in proportion to their mass.
///
/// A law is a set of pieces, in each of which the force is one formula, and says which piece follows on which. Whoever
/// moves masses finds out when a piece ends. Forces only press. Source: docs/theory.md, "Contact laws"
class ContactLaw {
 public:
  ContactLaw() = default;
  ContactLaw(const ContactLaw&) = delete;
  ContactLaw& operator=(const ContactLaw&) = delete;
  virtual ~ContactLaw() = default;

  /// As keys and files have it.
  [[nodiscard]] virtual std::string_view name() const noexcept = 0;
  [[nodiscard]] virtual std::vector<LawNumber> numbers() const = 0;
  /// Whether the force depends on the largest compression so far.
  [[nodiscard]] virtual bool remembers() const noexcept { return false; }
  /// Where the face is that a mass meets after such a compression, behind that of the support at the start [m].
  [[nodiscard]] virtual double permanent_set(double /*largest*/) const { return 0.0; }

  /// As motion and largest compression so far alone have it.
  [[nodiscard]] virtual LawState found(const LawMotion& motion, double largest) const = 0;
  /// The mass arrives at the face. @param open until then
  [[nodiscard]] virtual LawState touch(const LawState& open, const LawMotion& motion) const = 0;
  [[nodiscard]] virtual LawPiece piece(const LawState& state) const = 0;
  /// What follows where a piece ends. @param compression there [m]
  [[nodiscard]] virtual LawState next(const LawState& state, LawEnd end, double compression) const = 0;

  /// What the support would give back from a compression [J].
  [[nodiscard]] virtual double stored(double compression, double largest) const = 0;
  /// What it loses while it gives a force [W].
  [[nodiscard]] virtual double loss_rate(const LawState& state, double compression, double rate) const = 0;
  /// Compression at which it first presses with a force, at rest [m]. @param force >= 0 [N]
  /// @return infinite: it never does
  [[nodiscard]] virtual double compression_for(double force) const = 0;

  /// Force as motion and largest compression so far alone have it [N].
  [[nodiscard]] double force(const LawMotion& motion, double largest) const;
};

/// @throws InputError naming quantity, value and range unless `sound`
void require_of_law(bool sound, const char* quantity, double value, const char* expected);

}  // namespace udar
