#include "udar/integrators/sweep.hpp"

namespace udar {

void Sweep::find_rates() {
  std::array<double, kMostTerms> place{};
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < terms; ++j) {
      place[j] = moment(j, i) + line_rows[j][i];
    }
    const double last = moment(terms, i) + end_stretch[i];
    for (std::size_t j = 0; j < terms; ++j) {
      rate_rows[j][i] = rate_term(j, place, last) / step;
    }
  }
}

void Sweep::find_drive(bool solved) {
  for (std::size_t j = 0; j < terms; ++j) {
    for (std::size_t i = 0; i < count && solved; ++i) {
      const bool forced = j < steady.size() && !steady[j].empty();
      line_rows[j][i] += moment(j, i) + (forced ? steady[j][i] : 0.0) + (j == 0 ? start_stretch[i] : 0.0);
    }
    for (std::size_t i = 0; i < count; ++i) {
      drive_rows[j][i] = line_rows[j][i] + line_damping * rate_rows[j][i];
    }
  }
}

}  // namespace udar
