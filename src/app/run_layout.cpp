#include "app/run_layout.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include "udar/app/describe_case.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/structure/network.hpp"

namespace udar::app {

double longest_sample(const Case& input) {
  return (input.filter.filtered() ? 0.25 * std::numbers::pi : 2.0) / input.filter.shift();
}

namespace {

/// Whether a member has this name, or is one of a group of it: these are numbered.
bool is_called(const std::string& member, const std::string& name) {
  return member == name || (member.starts_with(name + ' ') &&
                            member.find_first_not_of("0123456789", name.size() + 1) == std::string::npos);
}

io::RowChoice rows_chosen(const Case& input, const Structure& structure) {
  io::RowChoice choice = input.output.rows;
  if (input.output.members.empty()) {
    return choice;
  }
  if (structure.network() == nullptr) {
    throw InputError{"option -output_members has nothing to choose from: only a network has members"};
  }
  const std::vector<Member>& members = structure.network()->parameters().members;
  for (const std::string& name : input.output.members) {
    const std::size_t before = choice.members.size();
    for (std::size_t member = 0; member < members.size(); ++member) {
      if (is_called(members[member].name, name)) {
        choice.members.push_back(static_cast<std::int64_t>(member));
      }
    }
    if (choice.members.size() == before) {
      throw InputError{"option -output_members: the network has no member or group '" + name + "'"};
    }
  }
  return choice;
}

}  // namespace

io::RunLayout make_layout(const Case& input, const FilteredStructure& line, std::vector<FieldInfo> fields) {
  const MassPoints& points = line.points();
  io::RunLayout layout{points, line.structure().topology(), rows_chosen(input, line.structure())};
  if (!input.modal) {
    layout.filter_frequency = line.filter_frequency();
  }
  layout.longest_sample = longest_sample(input);
  layout.options_text = petsc::effective_options();
  layout.parameters = describe(input, line.structure()).parameters();
  layout.fields = std::move(fields);
  layout.content = input.output.content;
  static_cast<void>(layout.fields_in_files());
  if (const BeamChain* beam = line.structure().chain(); beam != nullptr) {
    layout.peaks = {{.name = "stress", .unit = "Pa", .field = "moment", .factor = {}},
                    {.name = "utilisation", .unit = "1", .field = "moment", .factor = {}}};
    for (PetscInt node = beam->begin(); node < beam->end(); ++node) {
      const MomentStress per_moment = beam->moment_stress(node);
      layout.peaks[0].factor.push_back(per_moment.stress);
      layout.peaks[1].factor.push_back(per_moment.utilisation);
    }
  }
  for (const Place& gauge : input.gauges) {
    require_on("gauge position", gauge.x, points.extent());
    layout.gauge_node.push_back(points.nearest(gauge));
    layout.gauge_height.push_back(points.height_of(layout.gauge_node.back()));
    layout.gauge_position.push_back(gauge.x);
  }
  if (!input.base_motion.empty()) {
    layout.base = [motions = input.base_motion](double time) {
      return std::array{base_displacement(motions, time).y, base_velocity(motions, time).y};
    };
  }
  for (const Support& support : input.supports) {
    const bool bounded = std::isfinite(support.x.length());  // a box's
    layout.supports.push_back({.position = bounded ? support.x.middle() : support.position,
                               .width = bounded ? support.x.length() : support.width,
                               .height = support.field               ? support.height + support.field->highest()
                                         : support.profile.x.empty() ? support.height
                                                                     : std::ranges::max(support.profile.height),
                               .restitution = support.restitution,
                               .side = static_cast<int>(support.side)});
    if (support.strike >= 0) {  // it has no face that stands anywhere
      layout.supports.back().height = std::numeric_limits<double>::quiet_NaN();
      const auto number = [](std::optional<std::size_t> of) { return of ? static_cast<std::int64_t>(*of) : -1; };
      layout.supports.back().striker = number(input.striker_of(support));
      layout.supports.back().pair = number(input.pair_of(support));
    }
    if (std::ranges::any_of(input.supports, &Support::in_space)) {
      const auto& [x, y, z] = support.normal;
      layout.supports.back().space = {x, y, z, support.y.from, support.y.to, support.z.from, support.z.to};
    }
    if (support.field) {
      layout.supports.back().field = support.field;
      layout.supports.back().base = support.height;
    }
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
