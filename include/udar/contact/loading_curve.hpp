#pragma once
/// @file
/// Contact with what yields: loading along a curve, unloading along a line.

#include <string_view>
#include <vector>

#include "udar/contact/contact_law.hpp"

namespace udar {

/// @brief f = F(d) where the compression is larger than ever before, F of straight pieces; else f falls from there with
/// the unloading slope, and comes back on the same line.
///
/// What is left at no force, the largest compression less F over the unloading slope, is the permanent set: the face is
/// there from then on. Stored is f^2 / 2 over the unloading slope, lost the rest of the work. Sources: W. Goldsmith,
/// Impact, London 1960; O. R. Walton and R. L. Braun, J. Rheol. 30 (1986) 949; docs/theory.md, "Contact laws"
class LoadingCurve final : public ContactLaw {
 public:
  struct Parameters {
    std::vector<double> compression;  ///< [m], ascending from 0
    std::vector<double> force;        ///< F there [N], 0 first, then > 0
    double last_slope = 0.0;          ///< beyond the last of them [N/m], >= 0
    double unloading = 0.0;           ///< slope [N/m], >= all of F
  };
  /// @throws InputError naming quantity, value and range
  explicit LoadingCurve(Parameters parameters);

  /// F = `loading` d. @param loading, unloading slopes [N/m]
  [[nodiscard]] static Parameters bilinear(double loading, double unloading);
  /// @brief Elastic up to a plateau of force, which ends where what is crushed bottoms out.
  struct Crush {
    double stiffness = 0.0;            ///< elastic, of unloading, too [N/m]
    double plateau = 0.0;              ///< force [N]
    double bottoming = 0.0;            ///< compression where the plateau ends [m]
    double bottoming_stiffness = 0.0;  ///< from there on [N/m]
  };
  [[nodiscard]] static Parameters crush(const Crush& of);
  /// @brief Through the rows of a table, and on with the last slope.
  [[nodiscard]] static Parameters table(std::vector<double> compression, std::vector<double> force, double unloading);

  [[nodiscard]] std::string_view name() const noexcept override { return "loading curve"; }
  [[nodiscard]] std::vector<LawNumber> numbers() const override;
  [[nodiscard]] bool remembers() const noexcept override { return true; }
  [[nodiscard]] double permanent_set(double largest) const override;
  [[nodiscard]] LawState found(const LawMotion& motion, double largest) const override;
  [[nodiscard]] LawState touch(const LawState& open, const LawMotion& motion) const override;
  [[nodiscard]] LawPiece piece(const LawState& state) const override;
  [[nodiscard]] LawState next(const LawState& state, LawEnd end, double compression) const override;
  [[nodiscard]] double stored(double compression, double largest) const override;
  [[nodiscard]] double loss_rate(const LawState& state, double compression, double rate) const override;
  [[nodiscard]] double compression_for(double force) const override;

 private:
  [[nodiscard]] std::size_t piece_at(double compression) const;
  [[nodiscard]] double loading_force(double compression) const;
  [[nodiscard]] double slope(std::size_t piece) const;
  [[nodiscard]] int unloading_piece() const { return static_cast<int>(parameters_.compression.size()); }

  Parameters parameters_;
};

}  // namespace udar
