#pragma once
/// @file
/// The ways to integrate contact on the line that tests run through.

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "support/steel_beam.hpp"

namespace udar::test {

inline constexpr ContactParameters kOnLine{.hop_tolerance = 1e-10, .surface = ContactSurface::line};

/// Contact on the line where so many contact nodes count as few.
inline ContactParameters on_line(PetscInt dense) {
  ContactParameters contact = kOnLine;
  contact.line_dense_max = dense;
  return contact;
}

/// An integrator, and the contact nodes that count as few.
struct Way {
  const char* integrator = "";
  PetscInt dense = 0;
};
inline constexpr Way kRk{.integrator = "rk", .dense = 100};
inline constexpr Way kImpact{.integrator = "impact", .dense = 100};
inline constexpr std::array kWays{kRk, kImpact, Way{.integrator = "rk", .dense = 0},
                                  Way{.integrator = "impact", .dense = 0}};

inline std::string name_of(const testing::TestParamInfo<Way>& tested) {
  return std::string{tested.param.integrator} + (tested.param.dense > 0 ? "" : "_many");
}

/// A test of each.
class LineTest : public testing::TestWithParam<Way> {
 protected:
  [[nodiscard]] static ContactParameters on_line() { return test::on_line(GetParam().dense); }

 private:
  Option type_{"-ts_type", GetParam().integrator};
};

}  // namespace udar::test
