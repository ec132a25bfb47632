#include "udar/integrators/sweep.hpp"

namespace udar {

void Sweep::find_rates() {
  std::array<double, kMostTerms> place{};
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < terms; ++j) {
      place[j] = moment(j, i) + series.rows[j][i];
    }
    const double last = moment(terms, i) + series.end_stretch[i];
    for (std::size_t j = 0; j < terms; ++j) {
      series.rates[j][i] = rate_term(j, place, last) / step;
    }
  }
}

void Sweep::find_drive(bool solved) {
  for (std::size_t j = 0; j < terms; ++j) {
    for (std::size_t i = 0; i < count && solved; ++i) {
      const bool forced = j < series.steady.size() && !series.steady[j].empty();
      series.rows[j][i] +=
          moment(j, i) + (forced ? series.steady[j][i] : 0.0) + (j == 0 ? series.start_stretch[i] : 0.0);
    }
    for (std::size_t i = 0; i < count; ++i) {
      series.drives[j][i] = series.rows[j][i] + line_damping * series.rates[j][i];
    }
  }
}

}  // namespace udar
