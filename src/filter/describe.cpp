#include "udar/filter/describe.hpp"

namespace udar {

void describe(Description& all, const FilterParameters& filter) {
  const auto& [frequency, formulation, check_interval, residual_tolerance, unfiltered] = filter;
  static_cast<void>(check_interval);  // checks stop a run, they do not shape it
  static_cast<void>(residual_tolerance);
  all.add("filter", unfiltered ? "none" : "filter springs");
  all.add(unfiltered ? "2 / time step [1/s]" : "filter frequency [rad/s]", frequency);
  all.add("formulation", formulation == Formulation::mixed ? "mixed" : "hermite");
}

}  // namespace udar
