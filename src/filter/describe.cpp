#include "udar/filter/describe.hpp"

namespace udar {

void describe(Description& all, const FilterParameters& filter) {
  const auto& [frequency, formulation, check_interval, residual_tolerance, step] = filter;
  static_cast<void>(check_interval);  // checks stop a run, they do not shape it
  static_cast<void>(residual_tolerance);
  static_cast<void>(frequency);  // both in the shift
  static_cast<void>(step);
  all.add("filter", filter.filtered() ? "filter springs" : "none");
  all.add(filter.filtered() ? "filter frequency [rad/s]" : "2 / time step [1/s]", filter.shift());
  all.add("formulation", formulation == Formulation::mixed ? "mixed" : "hermite");
}

}  // namespace udar
