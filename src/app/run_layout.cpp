#include "app/run_layout.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "udar/petsc/options.hpp"

namespace udar::app {

io::NodeRange node_range(const MassPoints& points) {
  return {.begin = points.begin(), .end = points.end(), .total = points.total()};
}

io::PointOrder point_order(const MassPoints& points) {
  std::vector<std::int64_t> number(points.points());
  for (std::size_t point = 0; point < number.size(); ++point) {
    number[point] = points.number(point);
  }
  return {points.comm(), node_range(points), number};
}

double longest_sample(const Case& input) {
  return (input.filter.unfiltered ? 2.0 : 0.25 * std::numbers::pi) / input.filter.filter_frequency;
}

io::RunLayout make_layout(const Case& input, const FilteredStructure& line, std::vector<FieldInfo> fields) {
  const MassPoints& points = line.points();
  io::RunLayout layout;
  layout.comm = points.comm();
  layout.nodes = node_range(points);
  layout.topology = line.structure().topology();
  layout.filter_frequency = input.filter.filter_frequency;
  layout.longest_sample = longest_sample(input);
  layout.options_text = petsc::effective_options();
  layout.fields = std::move(fields);
  for (std::size_t point = 0; point < points.points(); ++point) {
    layout.x.push_back(points.place(point).x);
  }
  if (layout.topology.cells == Topology::Cells::vertices) {
    for (std::size_t point = 0; point < points.points(); ++point) {
      layout.y.push_back(points.place(point).y);
      layout.z.push_back(points.place(point).z);
      layout.direction.push_back(static_cast<std::int64_t>(points.direction(point)));
      layout.number.push_back(points.number(point));
    }
  }
  if (const BeamChain* beam = line.structure().chain(); beam != nullptr) {
    layout.elements = beam->elements();
    layout.peaks = {{.name = "stress", .unit = "Pa", .field = "moment", .factor = {}},
                    {.name = "utilisation", .unit = "1", .field = "moment", .factor = {}}};
    for (PetscInt node = beam->begin(); node < beam->end(); ++node) {
      const MomentStress per_moment = beam->moment_stress(node);
      layout.peaks[0].factor.push_back(per_moment.stress);
      layout.peaks[1].factor.push_back(per_moment.utilisation);
    }
  }
  layout.mass = line.mass();
  for (const double gauge : input.gauges) {
    require_on("gauge position", gauge, points.extent());
    layout.gauge_node.push_back(points.nearest({.x = gauge}));
  }
  layout.gauge_position = input.gauges;
  for (const Support& support : input.supports) {
    layout.supports.push_back(
        {.position = support.position,
         .width = support.width,
         .height = support.profile.x.empty() ? support.height : std::ranges::max(support.profile.height),
         .restitution = support.restitution,
         .side = static_cast<int>(support.side)});
    if (support.motion) {
      layout.supports.back().lift = [motion = support.motion](double time) { return motion->at(time).height; };
    }
    layout.ground_x.insert(layout.ground_x.end(), support.profile.x.begin(), support.profile.x.end());
    layout.ground_height.insert(layout.ground_height.end(), support.profile.height.begin(),
                                support.profile.height.end());
  }
  return layout;
}

}  // namespace udar::app
