#include "udar/contact/support.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

void require(bool condition, const char* quantity, double value, const std::string& expected) {
  if (!condition) {
    std::ostringstream message;
    message << quantity << ": " << value << " is not allowed, expected " << expected;
    throw InputError{message.str()};
  }
}

void require_sound(const MassPoints& points, const Support& support) {
  if (std::isfinite(support.width)) {
    require_on("support position", support.position, points.extent());
  }
  require(support.width >= 0.0, "support width", support.width, "a number >= 0 [m]");
  require(std::isfinite(support.height), "support height", support.height, "a finite number [m]");
  require(support.restitution >= 0.0 && support.restitution <= 1.0, "contact restitution", support.restitution,
          "a number from 0 to 1");
  require(support.friction >= 0.0 && std::isfinite(support.friction), "support friction", support.friction,
          "a number >= 0");
  require(support.yield_speed > 0.0, "support yield speed", support.yield_speed, "a number > 0 or inf [m/s]");
  if (support.field) {
    require(support.normal.y == 1.0, "support normal", support.normal.y,
            "0,1,0 with a field of heights (`support height field`), which has normals of its own");
    if (support.motion) {
      throw InputError{
          "support motion: not allowed with a field of heights (`support height field`), expected none: each node "
          "would move along a normal of its own"};
    }
    require(support.width > 0.0, "support width", support.width,
            "a width that holds the nodes, or inf, with a field of heights (`support height field`) [m]");
  }
}

/// Of the face at a point, as far as its coordinate has it [m].
double height_at(const MassPoints& points, const Support& support, std::size_t point) {
  const Place place = points.place(point);
  if (support.field) {
    const auto surface = support.field->at(place.x, place.z);
    // Along the normal, less what the point's place has across it, which the coordinate does not count.
    return points.axis(point).y * (support.height + (surface ? surface->height : 0.0));
  }
  if (support.normal.y == 1.0) {
    return support.height_at(place.x);
  }
  const Place& normal = support.normal;
  // A coordinate begins at its share of the height.
  const double across = normal.x * place.x + normal.y * place.y + normal.z * place.z - points.reference(point);
  return support.height_at(place.x) - across;
}

void require_touched(const Support& support, std::size_t index, const PointRows& touched) {
  const auto bounded = [](const Extent& extent) { return std::isfinite(extent.length()); };
  if (touched.count > 0) {
    return;
  }
  if (support.boxed() || (!bounded(support.y) && !bounded(support.z))) {
    require(false, "support width", support.width,
            "0 (the nearest node) or wide enough to hold a node; no node that moves along its normal lies within this "
            "support [m]");
  }
  const bool along_z = bounded(support.z);
  std::ostringstream expected;
  expected << "a place with nodes for support " << index << ": none that moves along its normal lies within ";
  if (support.width > 0.0) {
    expected << "x from " << support.from() << " to " << support.to() << ", ";
  }
  expected << "y from " << support.y.from << " to " << support.y.to << ", z from " << support.z.from << " to "
           << support.z.to << " [m]";
  require(false, along_z ? "support z position" : "support y position", (along_z ? support.z : support.y).middle(),
          expected.str());
}

bool overlap(const PointRows& left, const PointRows& right) {
  return std::ranges::any_of(left.rows, [&](const PointRows::Row& own) {
    return std::ranges::any_of(
        right.rows, [&](const PointRows::Row& other) { return own.first < other.last && other.first < own.last; });
  });
}

/// Friction takes a speed that points which stand alone do not have.
void require_nodes_that_rub(const MassPoints& points, const std::vector<Support>& supports,
                            const std::vector<PointRows>& touched) {
  std::string fault;
  for (std::size_t index = 0; index < supports.size(); ++index) {
    if (supports[index].friction > 0.0 && !touched[index].rows.empty() &&
        !points.beside(touched[index].rows.front().first)) {
      fault = "support friction: " + std::to_string(supports[index].friction) +
              " is not allowed where masses move along one axis, expected 0: it is for the nodes of a network";
    }
  }
  throw_together<InputError>(points.comm(), fault);
}

/// Supports that move or give way have their points for themselves, on their side.
void require_apart(MPI_Comm comm, const std::vector<Support>& supports, const std::vector<PointRows>& touched) {
  if (std::ranges::all_of(supports, &Support::plain)) {
    return;
  }
  auto first = static_cast<PetscInt>(supports.size());  // the first that shares points with one before it
  for (std::size_t index = 0; index < supports.size(); ++index) {
    for (std::size_t other = 0; other < index; ++other) {
      const bool plain = supports[index].plain() && supports[other].plain();
      if (!plain && supports[index].side == supports[other].side && overlap(touched[index], touched[other])) {
        first = std::min(first, static_cast<PetscInt>(index));
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPIU_INT, MPI_MIN, comm);
  require(first == static_cast<PetscInt>(supports.size()), "support position",
          first < static_cast<PetscInt>(supports.size()) ? supports[static_cast<std::size_t>(first)].position : 0.0,
          "no other support on its side at its nodes, as one of them moves or gives way; floor and ground count");
}

/// Masses rest on a rigid support by the pull of the line alone: no law may press them on it, and two laws of one side
/// are refused above.
void require_no_rigid_support_beside(MPI_Comm comm, const std::vector<Support>& supports,
                                     const std::vector<PointRows>& touched) {
  if (std::ranges::none_of(supports, [](const Support& support) { return support.contact_law != nullptr; })) {
    return;
  }
  auto first = static_cast<PetscInt>(supports.size());
  for (std::size_t index = 0; index < supports.size(); ++index) {
    for (std::size_t other = 0; other < supports.size(); ++other) {
      if (supports[index].contact_law && !supports[other].elastic() && overlap(touched[index], touched[other])) {
        first = std::min(first, static_cast<PetscInt>(index));
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPIU_INT, MPI_MIN, comm);
  require(first == static_cast<PetscInt>(supports.size()), "support position",
          first < static_cast<PetscInt>(supports.size()) ? supports[static_cast<std::size_t>(first)].position : 0.0,
          "no rigid support at the nodes of one with a `contact law`, on either side; floor and ground count [m]");
}

/// The rows of a support without the points that never move.
void add_sets(const MassPoints& points, const Support& support, PetscInt index, const PointRows& touched,
              std::vector<ContactSet>& sets) {
  const double carried = support.elastic() ? touched.mass : 0.0;
  const bool springs = support.elastic() && !support.contact_law;
  const bool level = support.strike >= 0 || (support.normal.y == 1.0 && support.profile.x.empty() && !support.field);
  const double touching =
      support.strike >= 0 ? points.strikes()[static_cast<std::size_t>(support.strike)].touching : 0.0;
  const auto add = [&](std::size_t first, std::size_t last) {
    if (first == last) {
      return;
    }
    ContactSet& set = sets.emplace_back(ContactSet{.first = first,
                                                   .last = last,
                                                   .support = index,
                                                   .side = static_cast<double>(support.side),
                                                   .level = level ? support.height + touching : 0.0,
                                                   .law = support.law(),
                                                   .profile = {},
                                                   .motion = support.motion,
                                                   .carried = carried,
                                                   .stiffness = springs ? support.stiffness / carried : 0.0,
                                                   .damping = springs ? support.damping / carried : 0.0,
                                                   .friction = support.friction,
                                                   .contact_law = support.contact_law});
    for (std::size_t point = first; point < last && !level; ++point) {
      set.profile.push_back(height_at(points, support, point));
    }
  };
  for (const auto& [first, last] : touched.rows) {
    std::size_t from = first;
    for (std::size_t point = first; point < last; ++point) {
      if (points.fixed(point)) {
        add(from, point);
        from = point + 1;
      }
    }
    add(from, last);
  }
}

}  // namespace

PointRows touched_points(const MassPoints& points, const Support& support) {
  if (support.strike >= 0) {
    return points.single(points.strikes()[static_cast<std::size_t>(support.strike)].gap);
  }
  const Region region = support.region();
  return support.width == 0.0 ? points.section(support.position, region, support.facing())
                              : points.within(region, support.facing());
}

Contacts find_contacts(const MassPoints& points, std::vector<Support> supports) {
  std::vector<PointRows> touched;
  for (const Support& support : supports) {
    require_sound(points, support);
    touched.push_back(touched_points(points, support));
    require_touched(support, touched.size() - 1, touched.back());
    require(support.stiffness > 0.0, "support stiffness", support.stiffness, "a number > 0 or inf [N/m]");
    require(support.damping >= 0.0 && std::isfinite(support.damping), "support damping", support.damping,
            "a number >= 0 [N s/m]");
  }
  require_nodes_that_rub(points, supports, touched);
  require_apart(points.comm(), supports, touched);
  require_no_rigid_support_beside(points.comm(), supports, touched);
  Contacts contacts{.supports = std::move(supports), .touched = {}, .sets = {}};
  for (std::size_t i = 0; i < touched.size(); ++i) {
    contacts.touched.push_back(touched[i].count);
    add_sets(points, contacts.supports[i], static_cast<PetscInt>(i), touched[i], contacts.sets);
  }
  return contacts;
}

}  // namespace udar
