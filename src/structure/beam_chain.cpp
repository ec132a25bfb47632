#include "udar/structure/beam_chain.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "chain_points.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/describe.hpp"

namespace udar {
namespace {

void require(bool condition, const std::string& message) {
  if (!condition) {
    throw InputError{message};
  }
}

constexpr double kPlaceTolerance = 1e-9;  // of an element: positions typed with ten digits still meet their node

}  // namespace

double BeamParameters::length() const {
  double sum = 0.0;
  for (const BeamSegment& segment : segments) {
    sum += segment.length;
  }
  return sum;
}

bool BeamParameters::yields() const {
  return std::ranges::any_of(segments, [](const BeamSegment& segment) { return std::isfinite(segment.yield_moment); });
}

BeamChain::BeamChain(MPI_Comm comm, BeamParameters parameters) : comm_{comm}, parameters_{std::move(parameters)} {
  require(!parameters_.segments.empty(), "a beam needs at least one segment");
  first_element_.push_back(0);
  first_position_.push_back(0.0);
  bool after_gap = true;
  for (const BeamSegment& segment : parameters_.segments) {
    require(segment.length > 0.0 && std::isfinite(segment.length), "segment length must be > 0 [m]");
    require(segment.elements > 0, "a segment needs at least one element");
    if (segment.is_gap()) {
      require(!after_gap && &segment != &parameters_.segments.back() && segment.elements == 1 &&
                  segment.foundation_stiffness == 0.0,
              "a gap is one element between two segments");
    } else {
      require(segment.bending_stiffness > 0.0 && std::isfinite(segment.bending_stiffness),
              "bending stiffness EI must be > 0 [N m^2]");
      require(segment.mass_per_length > 0.0 && std::isfinite(segment.mass_per_length),
              "mass per length must be > 0 [kg/m]");
    }
    after_gap = segment.is_gap();
    require(segment.shear_stiffness > 0.0, "shear stiffness kGA must be > 0 [N]");
    require(segment.yield_moment > 0.0, "yield moment must be > 0 [N m]");
    require(segment.foundation_stiffness >= 0.0 && std::isfinite(segment.foundation_stiffness),
            "foundation stiffness must be >= 0 [N/m^2]");
    constexpr PetscInt kMost = std::numeric_limits<PetscInt>::max() / 2 - 1;
    require(segment.elements <= kMost - first_element_.back(),
            "beam elements: " + std::to_string(segment.elements) + " is not allowed, expected at most " +
                std::to_string(kMost) + " in all: two unknowns per node, and PETSc was built with indices of " +
                std::to_string(8 * sizeof(PetscInt)) + " bits");
    first_element_.push_back(first_element_.back() + segment.elements);
    first_position_.push_back(first_position_.back() + segment.length);
    total_mass_ += segment.mass_per_length * segment.length;
  }
  require(std::isfinite(first_position_.back()), "beam length: the sum of all lengths must be finite [m]");
  require(parameters_.tension >= 0.0 && std::isfinite(parameters_.tension), "tension must be >= 0 [N]");
  for (const PointMass& point : parameters_.point_masses) {
    require_on("beam point mass position", point.position, {.from = 0.0, .to = length()});
    require(point.mass >= 0.0 && std::isfinite(point.mass), "a point mass must be >= 0 [kg]");
    node_masses_.emplace_back(nearest_node(point.position), point.mass);
    total_mass_ += point.mass;
  }
  require(std::isfinite(total_mass_), "beam density: the mass of the beam must be finite [kg]");
  std::ranges::sort(node_masses_);
  for (const LineSupport& support : parameters_.line_supports) {
    require_on("beam line support position", support.position, {.from = 0.0, .to = length()});
    require(support.stiffness >= 0.0, "the stiffness of a line support must be >= 0 [N/m]");
    node_springs_.emplace_back(nearest_node(support.position), support.stiffness);
  }
  std::ranges::sort(node_springs_);
  cut_masses();

  int rank = 0;
  int size = 1;
  MPI_Comm_rank(comm_, &rank);
  MPI_Comm_size(comm_, &size);
  require(static_cast<PetscInt>(size) <= nodes() / 2, "beam elements: " + std::to_string(elements()) +
                                                          " elements cannot be dealt to " + std::to_string(size) +
                                                          " ranks; use at most one rank per two nodes");
  const PetscInt share = nodes() / size;
  const PetscInt rest = nodes() % size;
  begin_ = rank * share + std::min<PetscInt>(rank, rest);
  end_ = begin_ + share + (rank < rest ? 1 : 0);
  points_ = points_of(*this);
}

PetscInt BeamChain::rigid_modes() const {
  const auto gaps = std::ranges::count_if(parameters_.segments, &BeamSegment::is_gap);
  return 2 * (static_cast<PetscInt>(gaps) + 1);
}

bool BeamChain::grounded() const {
  const auto spring = [](const BeamEnd& end) { return end.translational_stiffness > 0.0 || !end.moment_free(); };
  const auto foundation = [](const BeamSegment& segment) { return segment.foundation_stiffness > 0.0; };
  return spring(parameters_.left) || spring(parameters_.right) || !parameters_.line_supports.empty() ||
         std::ranges::any_of(parameters_.segments, foundation);
}

Topology BeamChain::topology() const {
  constexpr double kSlender = 200.0;  // length over radius, where that is not known
  Topology topology;
  for (PetscInt node = begin(); node < std::min(end(), elements()); ++node) {
    topology.corners.insert(topology.corners.end(), {node, node + 1});
    const BeamSegment& segment = parameters_.segments[segment_of_element(node)];
    const double known = segment.radius > 0.0 ? segment.radius : length() / kSlender;
    topology.radius.push_back(segment.is_gap() ? 0.0 : known);
  }
  return topology;
}

void BeamChain::describe(Description& all) const { udar::describe(all, parameters_); }

MomentStress BeamChain::moment_stress(PetscInt node) const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  MomentStress most{.stress = kNone, .utilisation = kNone};
  for (const PetscInt element : {node - 1, node}) {
    if (element < 0 || element >= elements()) {
      continue;
    }
    const BeamSegment& segment = parameters_.segments[segment_of_element(element)];
    if (segment.section_modulus > 0.0) {  // fmax leaves out what is not a number
      most.stress = std::fmax(most.stress, 1.0 / segment.section_modulus);
      if (segment.yield_stress > 0.0) {
        most.utilisation = std::fmax(most.utilisation, 1.0 / (segment.section_modulus * segment.yield_stress));
      }
    }
  }
  return most;
}

std::size_t BeamChain::segment_of_element(PetscInt element) const {
  if (parameters_.segments.size() == 1) {
    return 0;
  }
  const auto after = std::ranges::upper_bound(first_element_.begin() + 1, first_element_.end() - 1, element);
  return static_cast<std::size_t>(after - first_element_.begin() - 1);
}

BeamElement BeamChain::element(PetscInt element) const {
  if (element < 0 || element >= elements()) {
    return {.flexural_compliance = std::numeric_limits<double>::infinity()};
  }
  const BeamSegment& segment = parameters_.segments[segment_of_element(element)];
  return {.length = segment.length / static_cast<double>(segment.elements),
          .flexural_compliance = 1.0 / segment.bending_stiffness,  // infinite in a gap
          .shear_compliance = 1.0 / segment.shear_stiffness};
}

double BeamChain::position(PetscInt node) const {
  if (node == elements()) {
    return length();
  }
  const std::size_t index = segment_of_element(node);
  const BeamSegment& segment = parameters_.segments[index];
  return first_position_[index] +
         segment.length * (static_cast<double>(node - first_element_[index]) / static_cast<double>(segment.elements));
}

double BeamChain::mass(PetscInt node) const {
  const auto half_element = [this](PetscInt element) {
    const BeamSegment& segment = parameters_.segments[segment_of_element(element)];
    return 0.5 * segment.mass_per_length * segment.length / static_cast<double>(segment.elements);
  };
  const double points = sum_at(node_masses_, node);
  if (!pieces_.empty()) {
    const auto first = [](const MassPiece& piece) { return piece.nodes.first; };
    const MassPiece& piece = *std::prev(std::ranges::upper_bound(pieces_, node, {}, first));
    if (node == piece.nodes.first || node == piece.nodes.last) {
      const auto middle = [this](PetscInt element) { return 0.5 * (position(element) + position(element + 1)); };
      return mass_between(node == piece.nodes.first ? piece.from : middle(node - 1),
                          node == piece.nodes.last ? piece.to : middle(node)) +
             points;
    }
  }
  return (node > 0 ? half_element(node - 1) : 0.0) + (node < elements() ? half_element(node) : 0.0) + points;
}

double BeamChain::mass_of(NodeRange nodes) const {
  if (nodes.last - nodes.first < 2) {
    return mass(nodes.first) + (nodes.last > nodes.first ? mass(nodes.last) : 0.0);
  }
  // What lies between the middles beside the ends, whatever cuts there are in between.
  double from = 0.5 * (position(nodes.first) + position(nodes.first + 1));
  double to = 0.5 * (position(nodes.last - 1) + position(nodes.last));
  for (const MassPiece& piece : pieces_) {
    from = piece.nodes.last == nodes.first ? piece.to : from;
    to = piece.nodes.first == nodes.last ? piece.from : to;
  }
  double sum = mass(nodes.first) + mass_between(from, to) + mass(nodes.last);
  for (const auto& [node, point] : node_masses_) {
    sum += node > nodes.first && node < nodes.last ? point : 0.0;
  }
  return sum;
}

double BeamChain::mass_between(double from, double to) const {
  double sum = 0.0;
  const auto after = std::ranges::upper_bound(first_position_.begin() + 1, first_position_.end() - 1, from);
  for (auto index = static_cast<std::size_t>(after - first_position_.begin() - 1);
       index < parameters_.segments.size() && first_position_[index] < to; ++index) {
    sum += parameters_.segments[index].mass_per_length *
           (std::min(to, first_position_[index + 1]) - std::max(from, first_position_[index]));
  }
  return sum;
}

/// Where what weighs on the axis is cut, from its start to its end, ascending.
std::vector<double> BeamChain::edges_of_patches() const {
  std::vector<double> edges{0.0};
  for (const MassPatch& patch : parameters_.mass_patches) {
    require(patch.from < patch.to, "a mass patch must have a width > 0 [m]");
    edges.push_back(std::clamp(patch.from, 0.0, length()));
    edges.push_back(std::clamp(patch.to, 0.0, length()));
  }
  edges.push_back(length());
  std::ranges::sort(edges);
  const auto same = [this](double left, double right) {
    return right - left <= kPlaceTolerance * element(std::min(nearest_node(left), elements() - 1)).length;
  };
  edges.erase(std::ranges::unique(edges, same).begin(), edges.end());
  if (same(edges.back(), length())) {
    edges.back() = length();
  }
  return edges;
}

void BeamChain::cut_masses() {
  const std::vector<double> edges = edges_of_patches();
  if (edges.size() < 3) {
    return;  // nothing is cut
  }
  std::vector<std::ptrdiff_t> patches_over;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const double middle = 0.5 * (edges[i] + edges[i + 1]);
    patches_over.push_back(std::ranges::count_if(
        parameters_.mass_patches, [&](const MassPatch& patch) { return patch.from < middle && middle < patch.to; }));
    pieces_.push_back({.from = edges[i],
                       .to = edges[i + 1],
                       .nodes = nodes_inside(edges[i], edges[i + 1]),
                       .patch = patches_over.back() > 0});
  }
  // A node on an edge belongs to the patch, between two patches to the left one.
  for (std::size_t i = 0; i + 1 < pieces_.size(); ++i) {
    if (pieces_[i].nodes.last == pieces_[i + 1].nodes.first) {
      if (patches_over[i] >= patches_over[i + 1]) {
        ++pieces_[i + 1].nodes.first;
      } else {
        --pieces_[i].nodes.last;
      }
    }
  }
  give_nodes_to_narrow_patches();
  refuse_pieces_without_mass();
  for (const MassPatch& patch : parameters_.mass_patches) {
    NodeRange nodes{.first = 0, .last = -1};
    for (const MassPiece& piece : pieces_) {
      const double middle = 0.5 * (piece.from + piece.to);
      if (patch.from < middle && middle < patch.to) {
        nodes = {.first = nodes.last < 0 ? piece.nodes.first : nodes.first, .last = piece.nodes.last};
      }
    }
    patch_nodes_.push_back(nodes);
  }
}

/// A patch narrower than the mesh takes the nearest node, whose other neighbours take what it carried beside.
void BeamChain::give_nodes_to_narrow_patches() {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (pieces_[i].patch && pieces_[i].empty()) {
      const PetscInt node = nearest_node(0.5 * (pieces_[i].from + pieces_[i].to));
      if (i > 0 && pieces_[i - 1].nodes.last == node) {
        --pieces_[i - 1].nodes.last;
        pieces_[i].nodes = {.first = node, .last = node};
      } else if (i + 1 < pieces_.size() && pieces_[i + 1].nodes.first == node) {
        ++pieces_[i + 1].nodes.first;
        pieces_[i].nodes = {.first = node, .last = node};
      }
    }
  }
}

/// @throws InputError if a piece has no node, or a node no mass
void BeamChain::refuse_pieces_without_mass() const {
  for (const MassPiece& piece : pieces_) {
    if (piece.empty()) {
      const double space = piece.to - piece.from;
      const double middle = 0.5 * (piece.from + piece.to);
      const auto after = std::ranges::upper_bound(first_position_.begin() + 1, first_position_.end() - 1, middle);
      const BeamSegment& segment = parameters_.segments[static_cast<std::size_t>(after - first_position_.begin() - 1)];
      std::ostringstream message;
      message << "beam elements: " << segment.elements << " is not allowed, expected at least "
              << std::ceil(2.0 * segment.length / space) << " on the " << segment.length
              << " m there: the mesh has no node for the mass from " << piece.from << " to " << piece.to
              << " m, between edges of supports (or `support weighting` inclusive)";
      throw InputError{message.str()};
    }
  }
  for (const MassPiece& piece : pieces_) {
    for (const PetscInt node : {piece.nodes.first, piece.nodes.last}) {
      if (!(mass(node) > 0.0)) {
        std::ostringstream message;
        message << "support width: no mass is left for the node at " << position(node)
                << " m beside the edge of a support there; move the edge off the end of the beam [m]";
        throw InputError{message.str()};
      }
    }
  }
}

double BeamChain::sum_at(const NodeValues& values, PetscInt node) {
  double sum = 0.0;
  for (auto point = std::ranges::lower_bound(values, node, {}, &NodeValues::value_type::first);
       point != values.end() && point->first == node; ++point) {
    sum += point->second;
  }
  return sum;
}

double BeamChain::ground_stiffness(PetscInt node) const {
  const auto half_element = [this](PetscInt element) {
    const BeamSegment& segment = parameters_.segments[segment_of_element(element)];
    return 0.5 * segment.foundation_stiffness * segment.length / static_cast<double>(segment.elements);
  };
  const double springs = sum_at(node_springs_, node);
  const BeamEnd* end = end_at(node);
  return (node > 0 ? half_element(node - 1) : 0.0) + (node < elements() ? half_element(node) : 0.0) +
         (std::isinf(springs) ? 0.0 : springs) + (end != nullptr && !end->fixed() ? end->translational_stiffness : 0.0);
}

bool BeamChain::fixed(PetscInt node) const {
  const BeamEnd* end = end_at(node);
  return (end != nullptr && end->fixed()) || std::isinf(sum_at(node_springs_, node));
}

const BeamEnd* BeamChain::end_at(PetscInt node) const {
  static constexpr BeamEnd kFree;
  if (node == 0) {
    return &parameters_.left;
  }
  if (node == elements()) {
    return &parameters_.right;
  }
  const auto gap = [this](PetscInt element) { return parameters_.segments[segment_of_element(element)].is_gap(); };
  return parameters_.segments.size() > 1 && (gap(node - 1) || gap(node)) ? &kFree : nullptr;
}

PetscInt BeamChain::nearest_node(double position) const {
  const auto after = std::ranges::upper_bound(first_position_.begin() + 1, first_position_.end() - 1, position);
  const auto index = static_cast<std::size_t>(after - first_position_.begin() - 1);
  const BeamSegment& segment = parameters_.segments[index];
  const double steps = (position - first_position_[index]) / segment.length * static_cast<double>(segment.elements);
  const double nearest = std::ceil(steps - 0.5 - kPlaceTolerance);
  return first_element_[index] + static_cast<PetscInt>(std::clamp(nearest, 0.0, static_cast<double>(segment.elements)));
}

std::array<BeamChain::NodeShare, 2> BeamChain::lever(double position) const {
  const PetscInt near = nearest_node(position);
  const double off = position - this->position(near);
  const PetscInt between = off > 0.0 ? near : near - 1;
  const BeamElement gap_or_element = element(between);
  const double share = std::abs(off) / gap_or_element.length;
  if (!(share > kPlaceTolerance) || std::isinf(gap_or_element.flexural_compliance)) {
    return {{{.node = near, .share = 1.0}, {.node = near, .share = 0.0}}};
  }
  return {{{.node = near, .share = 1.0 - share}, {.node = off > 0.0 ? near + 1 : near - 1, .share = share}}};
}

BeamChain::NodeRange BeamChain::nodes_within(double from, double to) const {
  const auto patch = std::ranges::find(parameters_.mass_patches, MassPatch{.from = from, .to = to});
  return pieces_.empty() || patch == parameters_.mass_patches.end()
             ? nodes_inside(from, to)
             : patch_nodes_[static_cast<std::size_t>(patch - parameters_.mass_patches.begin())];
}

BeamChain::NodeRange BeamChain::nodes_inside(double from, double to) const {
  // Start from the nearest nodes and step over those outside; a node may belong to either of two segments.
  const auto tolerance = [this](PetscInt node) {
    return kPlaceTolerance * element(std::min(node, elements() - 1)).length;
  };
  PetscInt first = nearest_node(std::clamp(from, 0.0, length()));
  PetscInt last = nearest_node(std::clamp(to, 0.0, length()));
  while (first <= elements() && position(first) < from - tolerance(first)) {
    ++first;
  }
  while (last >= 0 && position(last) > to + tolerance(last)) {
    --last;
  }
  return {.first = first, .last = last};
}

void BeamChain::exchange(std::span<const double> first, std::span<const double> last, std::span<double> left,
                         std::span<double> right) const {
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(comm_, &rank);
  MPI_Comm_size(comm_, &size);
  if (size > 1) {
    const auto count = static_cast<int>(first.size());
    // Both ways at once, by calls that PETSc's log counts.
    std::array<MPI_Request, 4> requests{MPI_REQUEST_NULL, MPI_REQUEST_NULL, MPI_REQUEST_NULL, MPI_REQUEST_NULL};
    if (rank + 1 < size) {
      MPI_Irecv(right.data(), count, MPI_DOUBLE, rank + 1, 0, comm_, requests.data());
      MPI_Isend(last.data(), count, MPI_DOUBLE, rank + 1, 1, comm_, &requests[1]);
    }
    if (rank > 0) {
      MPI_Irecv(left.data(), count, MPI_DOUBLE, rank - 1, 1, comm_, &requests[2]);
      MPI_Isend(first.data(), count, MPI_DOUBLE, rank - 1, 0, comm_, &requests[3]);
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  }
}

}  // namespace udar
