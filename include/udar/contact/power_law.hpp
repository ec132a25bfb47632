#pragma once
/// @file
/// Contact of curved bodies: Hertz, Hunt and Crossley.

#include <string_view>
#include <vector>

#include "udar/contact/contact_law.hpp"

namespace udar {

/// @brief f = k d^n (1 + c d') while that does not pull; Hertz with n = 3/2 and c = 0.
///
/// Stored is k d^(n + 1) / (n + 1). Lost is k c d^n d'^2, and what was stored where the mass leaves so fast that the
/// law would pull: from there the face follows it at no force. Sources: K. L. Johnson, Contact Mechanics, Cambridge
/// 1985, section 4.2; K. H. Hunt and F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440
class PowerLaw final : public ContactLaw {
 public:
  struct Parameters {
    double stiffness = 0.0;  ///< k [N/m^n], > 0
    double exponent = 1.5;   ///< n, from 1 to 3
    double damping = 0.0;    ///< c [s/m], >= 0
  };
  /// @throws InputError naming quantity, value and range
  explicit PowerLaw(const Parameters& parameters);

  [[nodiscard]] std::string_view name() const noexcept override { return "power law"; }
  [[nodiscard]] std::vector<LawNumber> numbers() const override;
  [[nodiscard]] LawState found(const LawMotion& motion, double largest) const override;
  [[nodiscard]] LawState touch(const LawState& open, const LawMotion& motion) const override;
  [[nodiscard]] LawPiece piece(const LawState& state) const override;
  [[nodiscard]] LawState next(const LawState& state, LawEnd end, double compression) const override;
  [[nodiscard]] double stored(double compression, double largest) const override;
  [[nodiscard]] double loss_rate(const LawState& state, double compression, double rate) const override;
  [[nodiscard]] double compression_for(double force) const override;

 private:
  [[nodiscard]] double near(const LawMotion& motion) const;

  Parameters parameters_;
};

}  // namespace udar
