#pragma once
/// @file
/// A reduced model that is no structure's, for the two ways to move one.

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "udar/modal/reduced_model.hpp"

namespace udar::test {

inline constexpr double kReducedMass = 2500.0;  // of a beam on one support [kg]

/// A beam of two rigid modes over one support in its middle.
inline ReducedModel over_centre(double compliance, double give) {
  return {
      .frequency = {0.0, 0.0}, .row = {1.0 / std::sqrt(kReducedMass), 0.0}, .compliance = {compliance}, .give = {give}};
}

/// Six modes of so much mass [kg] over four supports that give way [m/N]: rigid motions, and waves of a free line.
inline ReducedModel table_on_supports(double give, double mass) {
  ReducedModel model;
  model.frequency = {0.0, 0.0, 60.0, 170.0, 330.0, 540.0};
  const std::vector<double> places{-0.8, -0.3, 0.3, 0.8};
  for (const double x : places) {
    for (std::size_t m = 0; m < 6; ++m) {
      const double shape =
          m == 0   ? 1.0
          : m == 1 ? std::numbers::sqrt3 * x
                   : std::numbers::sqrt2 * std::cos(std::numbers::pi * 0.5 * static_cast<double>(m) * (x + 1.0));
      model.row.push_back(shape / std::sqrt(mass));
    }
  }
  model.compliance.assign(16, 0.0);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      model.compliance[i * 4 + j] = 2e-9 * std::exp(-3.0 * std::abs(places[i] - places[j]));
    }
  }
  model.give.assign(4, give);
  return model;
}

}  // namespace udar::test
