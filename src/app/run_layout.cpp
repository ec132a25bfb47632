#include "app/run_layout.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "structure/place_algebra.hpp"
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

/// Unit vectors along this rank's cells, by member: one whose ends are all other ranks' has none. Of a chain along x.
std::map<std::int64_t, Place> directions(const io::RunLayout& layout) {
  const Topology& topology = layout.rows->topology();
  std::map<std::int64_t, Place> along;
  for (std::size_t cell = 0; cell < topology.member.size(); ++cell) {
    std::array<Place, 2> ends;
    bool known = !along.contains(topology.member[cell]);
    for (std::size_t i = 0; known && i < 2; ++i) {
      const PetscInt node = topology.corners[2 * cell + i] - layout.nodes().begin;
      known = node >= 0 && node < layout.nodes().count();
      ends[i] = known ? layout.points->place(layout.rows->a_point()[static_cast<std::size_t>(node)]) : Place{};
    }
    if (known) {
      const Place difference = ends[1] - ends[0];
      along[topology.member[cell]] = (1.0 / norm(difference)) * difference;
    }
  }
  return along;
}

/// How far the cells at each of this rank's nodes reach along x, y and z from their axes [m]. @note Collective.
std::array<std::vector<double>, 3> reach_of_nodes(const io::RunLayout& layout) {
  const Topology& topology = layout.rows->topology();
  const auto corners = static_cast<std::size_t>(Topology::corners_of(topology.shape));
  const std::map<std::int64_t, Place> along = directions(layout);
  std::array<std::vector<double>, 3> of_corners;
  for (std::size_t cell = 0; cell < topology.radius.size(); ++cell) {
    Place axis = layout.members ? Place{} : Place{.x = 1.0};
    if (const auto found = layout.members ? along.find(topology.member[cell]) : along.end(); found != along.end()) {
      axis = found->second;
    }
    const std::array<double, 3> parts = values_of(axis);
    for (std::size_t k = 0; k < 3; ++k) {
      const double reach = topology.radius[cell] * std::sqrt(std::max(0.0, 1.0 - parts[k] * parts[k]));
      of_corners[k].insert(of_corners[k].end(), corners, reach);
    }
  }
  std::array<std::vector<double>, 3> reach;
  for (std::size_t k = 0; k < 3 && layout.tubes; ++k) {
    reach[k] = layout.rows->nodes().largest(topology.corners, of_corners[k]);
  }
  return reach;
}

/// What pictures show between supports and what they touch first.
void add_reach(io::RunLayout& layout, const Contacts& contacts) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const std::array<std::vector<double>, 3> reach = reach_of_nodes(layout);
  std::vector<double> nearest(layout.supports.size(), kNone);
  std::vector<double> radius(layout.supports.size(), 0.0);
  const auto visit = [&](const auto& see) {
    for (const ContactSet& set : contacts.sets) {
      const auto number = static_cast<std::size_t>(set.support);
      const std::vector<double>& space = layout.supports[number].space;
      const Place normal = space.empty() ? kUp : Place{.x = space[0], .y = space[1], .z = space[2]};
      for (std::size_t point = set.first; point < set.last; ++point) {
        Place at = layout.points->place(layout.points->own_point(point));
        at.y = layout.rows->upright() ? 0.0 : at.y;
        see(number, point, normal, set.side * dot(normal, at));
      }
    }
  };
  visit([&](std::size_t support, std::size_t /*point*/, const Place& /*normal*/, double along) {
    nearest[support] = std::min(nearest[support], along);
  });
  const auto supports = static_cast<int>(nearest.size());
  MPI_Allreduce(MPI_IN_PLACE, nearest.data(), supports, MPI_DOUBLE, MPI_MIN, layout.comm());
  visit([&](std::size_t support, std::size_t point, const Place& normal, double along) {
    constexpr double kRounding = 1e-9;  // of coordinates
    const std::optional<std::size_t> node = layout.rows->row(point);
    if (layout.tubes && node && along <= nearest[support] + kRounding * (1.0 + std::abs(nearest[support]))) {
      const std::array<double, 3> part = values_of(normal);
      double reaches = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        reaches += part[k] * part[k] * reach[k][*node];
      }
      radius[support] = std::max(radius[support], reaches);
    }
  });
  MPI_Allreduce(MPI_IN_PLACE, radius.data(), supports, MPI_DOUBLE, MPI_MAX, layout.comm());
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    io::RunLayout::Support& support = layout.supports[k];
    support.reach = nearest[k] < kNone ? support.side * nearest[k] : support.height;
    support.radius = radius[k];
  }
}

}  // namespace

io::RunLayout make_layout(const Case& input, const FilteredStructure& line, const Contacts& contacts,
                          std::vector<FieldInfo> fields) {
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
    layout.gauges.node.push_back(points.nearest(gauge));
    layout.gauges.height.push_back(points.height_of(layout.gauges.node.back()));
    layout.gauges.position.push_back(gauge.x);
  }
  if (!input.base_motion.empty()) {
    layout.base = [motions = input.base_motion](double time) {
      return std::array{base_displacement(motions, time).y, base_velocity(motions, time).y};
    };
  }
  layout.places = input.held_motion.size();
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
  add_reach(layout, contacts);
  return layout;
}

}  // namespace udar::app
