#include "udar/structure/held_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "structure/place_algebra.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// @name Of a beam.
/// @{
double stiffness_of(const BeamParameters& beam, const HeldPlace& place) {
  return place.kind == HeldKind::line_support
             ? beam.line_supports[place.number].stiffness
             : (place.kind == HeldKind::left_end ? beam.left : beam.right).translational_stiffness;
}

PetscInt node_of(const BeamChain& beam, const HeldPlace& place) {
  return place.kind == HeldKind::left_end ? 0
         : place.kind == HeldKind::right_end
             ? beam.elements()
             : beam.nearest_node(beam.parameters().line_supports[place.number].position);
}

/// How many places hold a node rigidly.
std::ptrdiff_t holding(const BeamChain& beam, PetscInt node) {
  const BeamParameters& all = beam.parameters();
  return std::ranges::count_if(all.line_supports,
                               [&](const LineSupport& support) {
                                 return support.stiffness == BeamEnd::kRigid &&
                                        beam.nearest_node(support.position) == node;
                               }) +
         (node == 0 && all.left.fixed() ? 1 : 0) + (node == beam.elements() && all.right.fixed() ? 1 : 0);
}

MovedPoint moved_node(const BeamChain& beam, const HeldPlace& place) {
  const BeamParameters& parameters = beam.parameters();
  if (place.kind == HeldKind::junction) {
    throw InputError{
        "base motion place: a junction is not allowed, a beam has none, expected left, right or a line "
        "support"};
  }
  if (place.kind == HeldKind::line_support && place.number >= parameters.line_supports.size()) {
    throw InputError{"base motion place: line_support_" + std::to_string(place.number) +
                     " is not allowed, expected line_support_0 to line_support_N of the N + 1 line supports given, " +
                     std::to_string(parameters.line_supports.size())};
  }
  const PetscInt node = node_of(beam, place);
  MovedPoint moved{.number = node, .stiffness = stiffness_of(parameters, place)};
  if (!(moved.stiffness > 0.0)) {
    throw InputError{"base motion place: " + place_name(place) +
                     " is not allowed, nothing holds the beam there, expected an end or a line support that does"};
  }
  if (holding(beam, node) > (moved.held() ? 1 : 0)) {
    throw InputError{"base motion place: " + place_name(place) +
                     " is not allowed, another support holds its node, too, expected a node with one"};
  }
  if (beam.points().owns(node)) {
    moved.point = static_cast<std::size_t>(node - beam.points().begin());
  }
  return moved;
}
/// @}

/// Of a junction: each of its coordinates along which the place moves.
std::vector<MovedPoint> moved_junction(const Network& network, const HeldMotion& motion) {
  if (motion.place.kind != HeldKind::junction) {
    throw InputError{
        "base motion place: left, right or a line support is not allowed with a network, expected the name "
        "of a junction"};
  }
  const Junction& junction = network.parameters().junctions[motion.place.number];
  const Network::Node node = network.junction_node(motion.place.number);
  const std::array<double, 3> share = values_of(motion.motion.direction());
  std::vector<MovedPoint> all;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (share.at(axis) == 0.0) {
      continue;
    }
    MovedPoint moved{.number = network.point(node, axis),
                     .share = share.at(axis),
                     .stiffness = junction.held.at(axis) ? BeamEnd::kRigid : junction.stiffness.at(axis)};
    if (!(moved.stiffness > 0.0)) {
      throw InputError{"base motion place: junction " + junction.name + " is not allowed, nothing holds it along " +
                       "xyz"[axis] + ", expected one that is held, or on a spring, in the direction of the motion"};
    }
    if (network.points().owns(moved.number)) {
      moved.point = static_cast<std::size_t>(moved.number - network.points().begin());
    }
    all.push_back(moved);
  }
  throw_together<InputError>(network.comm(), network.points().frames().empty()
                                                 ? ""
                                                 : "base motion place: a junction is not allowed where nodes face an "
                                                   "oblique support, expected base");
  return all;
}

/// Pieces of a motion in which its acceleration is linear.
struct MotionPiece {
  double from = 0.0;  // [s]
  double to = 0.0;
  BaseMotion::State begin{};  // just after
  double end = 0.0;           // acceleration just before [m/s^2]

  [[nodiscard]] double bend() const { return std::max(std::abs(begin.acceleration), std::abs(end)); }
};

/// From t = 0, where a motion has begun before, to long after its last row.
std::vector<MotionPiece> motion_pieces(const BaseMotion& motion) {
  constexpr double kAfter = 1e6;  // [s]
  std::vector<double> times{motion.acceleration()->time().begin(), motion.acceleration()->time().end()};
  times.erase(std::ranges::unique(times).begin(), times.end());
  if (times.front() > 0.0) {
    times.insert(times.begin(), 0.0);
  }
  times.push_back(std::max(times.back(), 0.0) + kAfter);
  std::vector<MotionPiece> pieces;
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    const BaseMotion::State begin = motion.at(times[i]);
    const double end = motion.acceleration()->at({times[i + 1], times[i]}).value;
    pieces.push_back({.from = times[i], .to = times[i + 1], .begin = begin, .end = end});
  }
  return pieces;
}

}  // namespace

std::string place_name(const HeldPlace& place, const NetworkParameters* network) {
  switch (place.kind) {
    case HeldKind::left_end:
      return "left";
    case HeldKind::right_end:
      return "right";
    case HeldKind::line_support:
      return "line_support_" + std::to_string(place.number);
    case HeldKind::junction:
      break;
  }
  return network->junctions[place.number].name;
}

std::shared_ptr<const TimeTable> displacement_table(const BaseMotion& motion, double accuracy) {
  constexpr double kMostRows = 1e6;
  if (!(accuracy > 0.0 && accuracy <= 0.1)) {
    std::ostringstream message;
    message << "base motion accuracy: " << accuracy << " is not allowed, expected a number > 0, at most 0.1";
    throw InputError{message.str()};
  }
  const std::vector<MotionPiece> pieces = motion_pieces(motion);
  double largest = 0.0;
  double bend = 0.0;
  for (const MotionPiece& piece : pieces) {
    largest = std::max(largest, std::abs(piece.begin.displacement));
    bend = std::max(bend, piece.bend());
  }
  // What is linear between rows h apart is off by h^2 / 12 of the second derivative at most.
  const double widest =
      bend > 0.0 ? std::sqrt(12.0 * accuracy * largest / bend) : std::numeric_limits<double>::infinity();
  double rows = 0.0;
  for (const MotionPiece& piece : pieces) {
    rows += piece.bend() > 0.0 ? std::ceil((piece.to - piece.from) / widest) : 1.0;
  }
  if (!(rows <= kMostRows)) {
    std::ostringstream message;
    message << "base motion accuracy: " << accuracy << " is not allowed, " << rows
            << " rows of displacement, expected a number that makes at most " << kMostRows;
    throw InputError{message.str()};
  }
  std::vector<double> time;
  std::vector<double> value;
  double before = 0.0;   // h^2 / 24 of the acceleration at the end of the piece before
  bool straight = true;  // and whether that has none
  for (const MotionPiece& piece : pieces) {
    const double length = piece.to - piece.from;
    const auto count = static_cast<std::size_t>(piece.bend() > 0.0 ? std::ceil(length / widest) : 1.0);
    const double step = length / static_cast<double>(count);
    const double curved = step * step / 24.0;
    straight = straight || piece.bend() == 0.0;  // what is straight is exact up to its ends
    for (std::size_t k = 0; k < count; ++k) {
      const double at = piece.from + static_cast<double>(k) * step;
      const auto [displacement, velocity, acceleration] = motion.at(at);
      const double first = straight ? 0.0 : before + curved * acceleration;
      time.push_back(at);
      value.push_back(displacement - (k == 0 ? first : 2.0 * curved * acceleration));
    }
    before = curved * piece.end;
    straight = piece.bend() == 0.0;
  }
  time.push_back(pieces.back().to);
  value.push_back(motion.at(pieces.back().to).displacement);
  return time_table(std::move(time), std::move(value));
}

std::vector<HeldMove> held_moves(const Structure& structure, const std::vector<HeldMotion>& motions) {
  std::vector<HeldMove> moves;
  for (const HeldMotion& motion : motions) {
    HeldMove move{.table = displacement_table(motion.motion, motion.accuracy), .points = {}};
    const Structure& elastic = structure.elastic();
    if (const BeamChain* beam = elastic.chain(); beam != nullptr) {
      move.points = {moved_node(*beam, motion.place)};
      move.points[0].share = motion.motion.direction().y;
    } else if (const Network* network = elastic.network(); network != nullptr) {
      move.points = moved_junction(*network, motion);
    } else {
      throw InputError{
          "base motion place: not allowed with imported matrices, which do not say what holds them, "
          "expected base"};
    }
    for (const HeldMove& other : moves) {
      for (const MovedPoint& moved : other.points) {
        if (std::ranges::find(move.points, moved.number, &MovedPoint::number) != move.points.end()) {
          throw InputError{"base motion place: two motions of one place along one axis are not allowed, expected one"};
        }
      }
    }
    moves.push_back(std::move(move));
  }
  return moves;
}

BeamParameters released(BeamParameters beam, const std::vector<HeldMotion>& motions) {
  for (const auto& [place, motion, accuracy] : motions) {
    if (stiffness_of(beam, place) != BeamEnd::kRigid) {
      continue;
    }
    if (place.kind == HeldKind::line_support) {
      beam.line_supports[place.number].stiffness = 0.0;
    } else {
      (place.kind == HeldKind::left_end ? beam.left : beam.right).translational_stiffness = 0.0;
    }
  }
  return beam;
}

NetworkParameters released(NetworkParameters network, const std::vector<HeldMotion>& motions) {
  for (const auto& [place, motion, accuracy] : motions) {
    const std::array<double, 3> share = values_of(motion.direction());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (share.at(axis) != 0.0) {
        network.junctions[place.number].held.at(axis) = false;
        network.junctions[place.number].stiffness.at(axis) = 0.0;
      }
    }
  }
  return network;
}

}  // namespace udar
