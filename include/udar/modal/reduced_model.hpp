#pragma once
/// @file
/// A structure as its lowest modes and the static flexibility of all others, seen from its contact points.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/numerics/power_series.hpp"

namespace udar {

/// @brief q'' + 2 zeta w q' + w^2 q = load + b' r and 0 <= r, 0 <= g = b q + offset + W rho + y, r'g = 0, where rho is
/// the force that the static rest has followed, and y the way a support has given.
///
/// Rows are contact points, their signs those of the gap: force and gap are positive away from the support.
/// The same numbers on every rank. Source: docs/theory.md, "The modal integrator"
struct ReducedModel {
  std::vector<double> frequency{};    ///< w of each mode [rad/s], >= 0
  std::vector<double> ratio{};        ///< zeta of each mode, in [0, 1); empty: undamped
  std::vector<double> row{};          ///< b: points x modes, by rows [kg^(-1/2)]
  std::vector<double> compliance{};   ///< W: points x points, symmetric [m/N]
  std::vector<double> give{};         ///< 1/K of each point's support [m/N], 0: rigid
  std::vector<double> support_lag{};  ///< damping over stiffness of each point's support [s]; empty: no dampers
  double rest_lag = 0.0;              ///< tau in rho + tau rho' = r [s]

  [[nodiscard]] std::size_t modes() const noexcept { return frequency.size(); }
  [[nodiscard]] std::size_t points() const noexcept { return give.size(); }
  [[nodiscard]] std::span<const double> row_of(std::size_t point) const {
    return std::span{row}.subspan(point * modes(), modes());
  }
  /// W + 1/K, by rows.
  [[nodiscard]] std::vector<double> closed_compliance() const;
  [[nodiscard]] bool conservative() const noexcept { return ratio.empty() && support_lag.empty() && rest_lag == 0.0; }

  /// @brief omega_S: no frequency of the structure is higher, whoever touches [rad/s]; infinite where contact points
  /// cannot be told apart without the modes that are left out.
  /// Source: w_k^2 + the largest eigenvalue of b'(W + 1/K)^-1 b, Weyl's inequality
  [[nodiscard]] double frequency_bound() const;
};

/// @brief What acts from a time on, linear over time.
struct Drive {
  double time = 0.0;                  ///< [s]
  std::vector<double> load{};         ///< Phi'F [N kg^(-1/2)], by mode
  std::vector<double> load_rate{};    ///< [N kg^(-1/2)/s]; empty: steady
  std::vector<double> offset{};       ///< gap of each point with q = 0 and no contact force [m]
  std::vector<double> offset_rate{};  ///< [m/s]; empty: at rest
  /// How far each face has moved away, in powers of the time since then [m/s^n]; empty: all stand still.
  std::vector<std::array<double, 4>> retreat{};

  [[nodiscard]] double load_at(std::size_t mode, double at) const {
    return load_rate.empty() ? load[mode] : load[mode] + (at - time) * load_rate[mode];
  }
  [[nodiscard]] double load_slope(std::size_t mode) const { return load_rate.empty() ? 0.0 : load_rate[mode]; }
  [[nodiscard]] double offset_at(std::size_t point, double at) const {
    const double still = offset_rate.empty() ? offset[point] : offset[point] + (at - time) * offset_rate[point];
    return retreat.empty() ? still : still + power_series::value(retreat[point].data(), 4, at - time);
  }
  /// Of what loads do to it.
  [[nodiscard]] double offset_slope(std::size_t point) const { return offset_rate.empty() ? 0.0 : offset_rate[point]; }
};

/// @brief Where a reduced model is at a time.
struct ModalState {
  double time = 0.0;                  ///< [s]
  std::vector<double> amplitude;      ///< q [m kg^(1/2)]
  std::vector<double> velocity;       ///< q' [m kg^(1/2)/s]
  std::vector<double> force;          ///< r of each point [N]
  std::vector<double> rest_force;     ///< rho [N]; r where nothing lags
  std::vector<double> give;           ///< y, how far each support has given [m]
  std::vector<std::uint8_t> touches;  ///< of each point

  /// At rest with q = 0, no contact.
  ModalState(std::size_t modes, std::size_t points)
      : amplitude(modes), velocity(modes), force(points), rest_force(points), give(points), touches(points) {}
};

/// @brief What is stored in a reduced model [J].
struct ModalEnergy {
  double kinetic = 0.0;         ///< 1/2 q'^2
  double strain = 0.0;          ///< of the modes
  double rest_strain = 0.0;     ///< 1/2 rho'W rho
  double springs = 0.0;         ///< of the supports
  double load_potential = 0.0;  ///< -load q; heights of static parts left out
  /// In all that gives way beside the modes.
  [[nodiscard]] double held() const noexcept { return rest_strain + springs; }
  /// Whatever the height.
  [[nodiscard]] double swinging() const noexcept { return kinetic + strain + held(); }
  [[nodiscard]] double total() const noexcept { return kinetic + strain + rest_strain + springs + load_potential; }
};
[[nodiscard]] ModalEnergy modal_energy(const ReducedModel& model, const Drive& drive, const ModalState& state);

}  // namespace udar
