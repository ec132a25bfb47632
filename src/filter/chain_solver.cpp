#include "udar/filter/chain_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

using chain::Square;
using chain::Symmetric;

// 2 x 2 algebra of the set-up.
Square multiply(const Square& a, const Square& b) {
  return {a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]};
}
Square full(const Symmetric& a) { return {a[0], a[1], a[1], a[2]}; }
Square transposed(const Square& a) { return {a[0], a[2], a[1], a[3]}; }
Square add(const Square& a, const Square& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]}; }
Square negative(const Square& a) { return {-a[0], -a[1], -a[2], -a[3]}; }
Symmetric add(const Symmetric& a, const Symmetric& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Symmetric symmetric(const Square& a) { return {a[0], (a[1] + a[2]) / 2, a[3]}; }
constexpr Square kIdentity{1, 0, 0, 1};

/// T C T'.
Symmetric congruent(const Square& t, const Symmetric& c) {
  return symmetric(multiply(multiply(t, full(c)), transposed(t)));
}

/// A compliance that may be close to singular (behind a pinned end, displacement and rotation go together): its
/// determinant is carried along, as it cannot be computed from the entries.
struct Compliance {
  Symmetric entries{};
  long double det = 0.0;
};

/// (P^-1 + J)^-1 without inverting P, (1 + J P)^-1, and the factor by which the determinant is smaller than that of P.
/// 1 - J X would be the second, too, but not where J is large: a line held just behind a joint.
struct Combined {
  Compliance value;
  Square reaction{};
  long double shrink = 1.0;
};
Combined combine(const Compliance& p, const Symmetric& j) {
  const auto& e = p.entries;
  const long double det_j = j[0] * j[2] - j[1] * j[1];
  const long double shrink = 1 / (1 + e[0] * j[0] + 2 * e[1] * j[1] + e[2] * j[2] + p.det * det_j);
  const Square product = multiply(full(j), full(e));
  return {
      .value = {.entries = {(e[0] + p.det * j[2]) * shrink, (e[1] - p.det * j[1]) * shrink,
                            (e[2] + p.det * j[0]) * shrink},
                .det = p.det * shrink},
      .reaction = {(1 + product[3]) * shrink, -product[1] * shrink, -product[2] * shrink, (1 + product[0]) * shrink},
      .shrink = shrink};
}

/// T X T' + C, for T of given determinant.
Compliance carry(const Square& t, long double det_t, const Compliance& x, const Compliance& added) {
  const Symmetric& c = added.entries;
  const Symmetric moved = congruent(t, x.entries);
  const long double det_moved = det_t * det_t * x.det;
  // det(M + C) = det M + det C + mixed; the mixed part by completing squares in M, which may be singular.
  const long double mixed = moved[0] > 0 ? (moved[0] * moved[0] * c[2] - 2 * moved[0] * moved[1] * c[1] +
                                            moved[1] * moved[1] * c[0] + det_moved * c[0]) /
                                               moved[0]
                                         : moved[2] * c[0];
  return {.entries = add(moved, c), .det = det_moved + added.det + mixed};
}

template <std::size_t Count>
std::array<double, Count> rounded(const std::array<long double, Count>& values) {
  std::array<double, Count> result{};
  std::ranges::transform(values, result.begin(), [](long double value) { return static_cast<double>(value); });
  return result;
}

/// A spring constant's inverse; none at all for no spring, which the caller must treat.
long double inverse(double stiffness) { return std::isinf(stiffness) ? 0.0L : 1.0L / stiffness; }

bool equal(const BeamElement& a, const BeamElement& b) {
  return a.length == b.length && a.flexural_compliance == b.flexural_compliance &&
         a.shear_compliance == b.shear_compliance;
}

/// Transfer, compliance and stiffness of one element, as of a stretch.
Square element_transfer(const BeamElement& e) { return {1, e.length, 0, 1}; }
Symmetric element_compliance(const BeamElement& e) {
  const long double h = e.length;
  return {h * h * h * e.flexural_compliance / 3 + h * e.shear_compliance, h * h * e.flexural_compliance / 2,
          h * e.flexural_compliance};
}

// Stretches of at most 377 elements: sixteen of them, their gains and what is kept between the two sweeps stay in a
// second-level cache, and joints cost little. Not near multiples of 4 KiB. Shorter than 4, they are no cheaper than
// joints.
constexpr std::size_t kLongest = 377;
constexpr std::size_t kShortest = 4;
/// Beyond so many nodes on a rank (2 MB a vector) what is given comes from memory.
constexpr std::size_t kCached = 250000;
/// Stretches treated between two visits to their joints, whose values are still in the cache then.
constexpr std::size_t kChunk = 4 * chain::kLanes;

}  // namespace

template <std::size_t Width>
struct ChainSolver::JointState {
  std::array<double, Width> target;      // of the line above the mass, by force and ground; then the solution
  std::array<double, Width> kink;        // of the line relative to the masses; then the moment
  std::array<double, Width> deflection;  // of the state after the node, known from the left
  std::array<double, Width> rotation;
  std::array<double, Width> innovation;
  std::array<double, Width> force;  // of the stretch on the right, for this state and a free right end
  std::array<double, Width> moment;
};

ChainSolver::ChainSolver(const LineData& line, int lanes) : comm_{line.comm}, nodes_{line.local_nodes()} {
  MPI_Comm_rank(comm_, &rank_);
  MPI_Comm_size(comm_, &ranks_);
  std::string failure;
  if (nodes_ < 2) {
    failure = "the chain solver needs at least two nodes on every rank; use fewer ranks";
  }
  report_.lanes = lanes == 0 ? chain::native_lanes() : lanes;
  if (!lanes_supported(report_.lanes)) {
    failure = "the chain solver cannot use " + std::to_string(lanes) + " lanes on this processor";
  }
  throw_together<InputError>(comm_, failure);
  cut(line);
  const Piece own = factor(line);
  couple(own);

  std::size_t longest = 0;
  for (const chain::Span& span : spans_) {
    longest = std::max(longest, span.inner());
    report_.factor_bytes += span.inner() * (sizeof(chain::Span::Gain) + 16 * sizeof(double));
  }
  shown_.resize(kBatch * blocks_);
  told_.resize(kBatch * blocks_);
  joint_states_.resize(joints_.size() * sizeof(JointState<kBatch>) / sizeof(double));
  scratch_.resize(4 * chain::kLanes * longest);
  report_.joints = joints_.size();
  report_.spans = spans_.size();
  report_.factor_bytes += joints_.size() * sizeof(Joint) + rows_.size() * sizeof(rows_[0]);
  report_.work_bytes =
      (shown_.size() + told_.size()) * sizeof(chain::Ends) + (joint_states_.size() + scratch_.size()) * sizeof(double);
}

bool ChainSolver::lanes_supported(int lanes) {
  return (lanes == 1 || lanes == 4 || lanes == 8) && lanes <= chain::native_lanes();
}

void ChainSolver::cut(const LineData& line) {
  const auto& elements = line.elements;
  // Whether a node can be inside a stretch, and inside the same as another.
  const auto regular = [&](std::size_t i) {
    return equal(elements[i], elements[i + 1]) && std::isfinite(line.ground_stiffness[i]);
  };
  const auto alike = [&](std::size_t i, std::size_t j) {
    return line.filter_stiffness[i] == line.filter_stiffness[j] &&
           line.ground_stiffness[i] == line.ground_stiffness[j] && line.scale[2 * i] == line.scale[2 * j] &&
           line.scale[2 * i + 1] == line.scale[2 * j + 1];
  };
  const std::size_t last = nodes_ - 1;
  Known known;
  std::size_t from = 0;
  while (from < last) {
    std::size_t to = from + 1;
    // The first element of a beam stands alone: a free end has no compliance to start from before its second node.
    if (LineData::present(elements[from + 1]) && LineData::present(elements[from])) {
      while (to < last && regular(to) && alike(to, from + 1)) {
        ++to;
      }
    }
    add_stretch(line, from, to, known);
    from = to;
  }
  joints_.push_back({.node = last});
  if (line.end < line.nodes && LineData::present(elements[nodes_])) {
    joints_.push_back({.node = nodes_});
  }
}

/// Joints and runs from one node up to another, between which all is alike.
void ChainSolver::add_stretch(const LineData& line, std::size_t from, std::size_t to, Known& known) {
  const auto add_run = [&](std::size_t elements, std::size_t blocks) {
    const BeamElement& element = line.elements[from + 1];
    const std::size_t inner = from + 1;
    const chain::SpanKey key{.elements = elements,
                             .length = element.length,
                             .flexural_compliance = element.flexural_compliance,
                             .shear_compliance = element.shear_compliance,
                             .filter_stiffness = line.filter_stiffness[inner],
                             .ground_stiffness = line.ground_stiffness[inner],
                             .scale = {line.scale[2 * inner], line.scale[2 * inner + 1]}};
    const auto [found, unknown] = known.try_emplace(key, spans_.size());
    if (unknown) {
      spans_.emplace_back(key);
    }
    runs_.push_back({.span = found->second, .first = from, .block = blocks_, .blocks = blocks});
    for (std::size_t block = 0; block < blocks; ++block) {
      joints_.push_back({.node = from, .block = static_cast<std::ptrdiff_t>(blocks_)});
      ++blocks_;
      from += elements;
    }
    report_.inner_nodes += blocks * (elements - 1);
  };
  constexpr std::size_t kLanes = chain::kLanes;
  while (to - from >= kLanes * (kLanes + 1)) {
    const std::size_t groups = (to - from + kLanes * kLongest - 1) / (kLanes * kLongest);
    const std::size_t elements = ((to - from) / (kLanes * groups) - 1) / kLanes * kLanes + 1;
    add_run(elements, kLanes * groups);
  }
  if (to - from >= kShortest) {
    add_run(to - from, 1);
  }
  for (; from < to; ++from) {
    joints_.push_back({.node = from});
  }
}

ChainSolver::Piece ChainSolver::factor(const LineData& line) {
  Piece piece;
  piece.shortest = std::numeric_limits<long double>::infinity();
  Compliance compliance_here;  // after the node, or before it
  Symmetric& p = compliance_here.entries;
  Square passed = kIdentity;  // what has come through from the piece's first node
  long double det_passed = 1;
  bool free_start = false;
  auto run = runs_.begin();  // of the last stretch passed
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    Joint& joint = joints_[j];
    const std::size_t i = joint.node;
    const BeamElement& left = line.elements[i];
    const BeamElement& right = line.elements[i + 1];
    joint.starts = !LineData::present(left);
    joint.ends = !LineData::present(right);
    const double stiffness = line.filter_stiffness[i] + line.ground_stiffness[i];
    const long double compliance = inverse(stiffness);
    joint.compliance = static_cast<double>(compliance);
    joint.ground_ratio = std::isinf(stiffness) ? 1.0 : line.ground_stiffness[i] / stiffness;
    const double rotation = line.rotation(i);
    for (std::size_t a = 0; a < 2; ++a) {
      const double scale = line.scale[2 * i + a];
      joint.inverse_scale[a] = scale != 0.0 ? 1.0 / scale : 0.0;
    }
    joint.kink_ratio = joint.starts ? 0.0 : (joint.ends ? 1.0 : right.length / left.length);
    joint.kink_scale = joint.starts && rotation == 0.0 ? 0.0 : 1.0 / (joint.ends ? left.length : right.length);

    if (joint.starts) {
      free_start = rotation == 0.0;
      p = {compliance, 0, free_start ? 0 : inverse(rotation)};
      compliance_here.det = p[0] * p[2];
      passed = {};
      det_passed = 0;
    } else if (j == 0) {
      compliance_here = {};
    } else if (free_start) {
      // Nothing is known of the rotation before this second node: it takes all of the innovation.
      const long double h = left.length;
      const long double first = joints_[j - 1].compliance;
      joint.gain = {1.0, static_cast<double>(1 / h)};
      p = {compliance, compliance / h,
           (first + compliance) / (h * h) + h * left.flexural_compliance / 3 + left.shear_compliance / h};
      compliance_here.det =
          compliance * (first / (h * h) + h * left.flexural_compliance / 3 + left.shear_compliance / h);
      free_start = false;
    } else {
      const long double release = 1 / (p[0] + compliance);
      const long double g0 = p[0] * release;
      const long double g1 = p[1] * release;
      joint.gain = {static_cast<double>(g0), static_cast<double>(g1)};
      joint.release = static_cast<double>(release);
      const Symmetric felt{passed[0] * passed[0] * release, passed[0] * passed[1] * release,
                           passed[1] * passed[1] * release};
      piece.stiffness = add(piece.stiffness, felt);
      const long double kept = compliance * release;
      passed = {kept * passed[0], kept * passed[1], passed[2] - g1 * passed[0], passed[3] - g1 * passed[1]};
      det_passed *= kept;
      compliance_here.det *= kept;
      p = {g0 * compliance, g1 * compliance, p[2] - g1 * p[1]};
    }

    if (j + 1 == joints_.size() && i == nodes_) {
      break;  // the next rank's own affair
    }
    if (joint.ends) {
      const long double release = rotation == 0.0 ? 0 : 1 / (p[2] + inverse(rotation));
      joint.rotation_release = static_cast<double>(release);
      const Symmetric felt{passed[2] * passed[2] * release, passed[2] * passed[3] * release,
                           passed[3] * passed[3] * release};
      piece.stiffness = add(piece.stiffness, felt);
      passed = {};
      det_passed = 0;
      compliance_here = {};
      continue;
    }
    const long double decay =
        std::sqrt(std::sqrt(4.0L * right.length / (right.flexural_compliance * line.filter_stiffness[i])));
    if (decay > piece.decay) {
      piece.decay = decay;
      piece.force = 1 / (right.flexural_compliance * decay * decay * decay);
    }
    piece.shortest = std::min(piece.shortest, decay);
    const bool plain = joint.block < 0;
    if (!plain && static_cast<std::size_t>(joint.block) == run->block + run->blocks) {
      ++run;
    }
    const chain::Span* span = plain ? nullptr : &spans_[run->span];
    const Square transfer = plain ? element_transfer(right) : span->transfer();
    const Symmetric added = plain ? element_compliance(right) : span->compliance();
    const Symmetric stiff = plain ? Symmetric{} : span->stiffness();
    const long double det_transfer = plain ? 1.0L : span->transfer_determinant();
    const Combined combined = combine(compliance_here, stiff);
    const Square& reaction = combined.reaction;
    joint.transfer = rounded(transfer);
    joint.stiffness = rounded(stiff);
    joint.combined = rounded(combined.value.entries);
    joint.reaction = rounded(reaction);
    piece.stiffness = add(piece.stiffness, congruent(transposed(passed), symmetric(multiply(reaction, full(stiff)))));
    passed = multiply(transfer, multiply(transposed(reaction), passed));
    det_passed *= det_transfer * combined.shrink;
    compliance_here = carry(transfer, det_transfer, combined.value, {added, added[0] * added[2] - added[1] * added[1]});
  }
  piece.transfer = passed;
  piece.det_transfer = det_passed;
  piece.compliance = p;
  piece.det_compliance = compliance_here.det;
  return piece;
}

/// Weights of what all ranks show in (state after, force and moment after) the first node of rank `boundary`.
std::vector<std::array<long double, 4>> ChainSolver::boundary_rows(const std::vector<Piece>& pieces,
                                                                   std::size_t boundary) {
  std::vector<std::array<long double, 4>> rows(4 * pieces.size());
  if (boundary == pieces.size()) {
    return rows;
  }
  // From the left, P and the weights of the state; combined[i] = (P^-1 + J)^-1 at the start of piece i.
  Compliance p;
  std::vector<Combined> combined;
  for (std::size_t i = 0; i < boundary; ++i) {
    combined.push_back(combine(p, pieces[i].stiffness));
    p = carry(pieces[i].transfer, pieces[i].det_transfer, combined[i].value,
              {pieces[i].compliance, pieces[i].det_compliance});
  }
  std::vector<Square> from_state(pieces.size());
  std::vector<Square> from_reaction(pieces.size());
  Square weight = kIdentity;
  for (std::size_t i = boundary; i-- > 0;) {
    from_state[i] = weight;
    weight = multiply(weight, pieces[i].transfer);
    from_reaction[i] = multiply(weight, full(combined[i].value.entries));
    weight = multiply(weight, transposed(combined[i].reaction));
  }
  // From the right, the stiffness j of all pieces from i on, and the weights of their common reaction.
  Symmetric j{};
  std::vector<Symmetric> beyond(pieces.size());
  std::vector<Square> carried(pieces.size());
  for (std::size_t i = pieces.size(); i-- > boundary;) {
    beyond[i] = j;
    const Square reaction = combine({pieces[i].compliance, pieces[i].det_compliance}, j).reaction;
    carried[i] = multiply(transposed(pieces[i].transfer), reaction);
    j = add(pieces[i].stiffness, congruent(transposed(pieces[i].transfer), symmetric(multiply(reaction, full(j)))));
  }
  std::vector<Square> reaction_of_state(pieces.size());
  std::vector<Square> reaction_of_reaction(pieces.size());
  weight = kIdentity;
  for (std::size_t i = boundary; i < pieces.size(); ++i) {
    reaction_of_reaction[i] = weight;
    weight = multiply(weight, carried[i]);
    reaction_of_state[i] = negative(multiply(weight, full(beyond[i])));
  }
  // s = (1 + P J)^-1 m + X eta,  r = (1 + J P)^-1 (eta - J m).
  const Combined here = combine(p, j);
  const Square to_state = transposed(here.reaction);
  const Square x = full(here.value.entries);
  const Square pull = multiply(here.reaction, full(j));
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto put = [&](std::size_t column, const Square& state, const Square& eta) {
      const Square s = add(multiply(to_state, state), multiply(x, eta));
      const Square r = add(multiply(here.reaction, eta), negative(multiply(pull, state)));
      rows[4 * i + column] = {s[0], s[2], r[0], r[2]};
      rows[4 * i + column + 1] = {s[1], s[3], r[1], r[3]};
    };
    put(0, from_state[i], reaction_of_state[i]);
    put(2, from_reaction[i], reaction_of_reaction[i]);
  }
  return rows;
}

void ChainSolver::couple(const Piece& own) {
  static_assert(sizeof(Piece) % sizeof(long double) == 0);
  constexpr int kSize = sizeof(Piece) / sizeof(long double);
  std::vector<Piece> pieces(static_cast<std::size_t>(ranks_));
  MPI_Allgather(&own, kSize, MPI_LONG_DOUBLE, pieces.data(), kSize, MPI_LONG_DOUBLE, comm_);
  const Piece& slowest = *std::ranges::max_element(pieces, {}, &Piece::decay);
  const long double length = slowest.decay;
  for (const Piece& piece : pieces) {
    const Square& t = piece.transfer;
    report_.carried =
        std::max({report_.carried, static_cast<double>(std::abs(t[0])), static_cast<double>(std::abs(t[1]) / length),
                  static_cast<double>(std::abs(t[2]) * length), static_cast<double>(std::abs(t[3]))});
  }
  report_.longest_decay = static_cast<double>(length);
  report_.shortest_decay = static_cast<double>(std::ranges::min_element(pieces, {}, &Piece::shortest)->shortest);
  if (ranks_ == 1) {
    return;
  }
  // This rank needs the state at its own first node, and force and moment at the next rank's.
  const auto rank = static_cast<std::size_t>(rank_);
  const auto first = boundary_rows(pieces, rank);
  const auto next = boundary_rows(pieces, rank + 1);
  const std::array<long double, 4> unit{1, 1 / length, slowest.force, slowest.force * length};
  // Below round-off of what comes from near.
  constexpr long double kNegligible = 1e-17L;
  int near = 1;
  rows_.resize(first.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const std::array<long double, 4> row{first[i][0], first[i][1], next[i][2], next[i][3]};
    rows_[i] = rounded(row);
    const std::size_t away = i / 4 > rank ? i / 4 - rank : rank - i / 4;
    for (std::size_t a = 0; a < 4; ++a) {
      if (away > 1 && std::abs(row[a]) * unit[i % 4] > kNegligible * unit[a]) {
        near = 0;
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &near, 1, MPI_INT, MPI_MIN, comm_);
  report_.coupling = near != 0 ? Coupling::neighbours : Coupling::all;
  if (near != 0) {
    rows_.erase(rows_.begin() + static_cast<std::ptrdiff_t>(4 * std::min(rank + 2, pieces.size())), rows_.end());
    rows_.erase(rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(4 * (rank > 0 ? rank - 1 : 0)));
  }
}

/// From what the pieces show to what this rank must know.
template <std::size_t Width>
std::array<ChainSolver::Boundary, Width> ChainSolver::exchange(const std::array<Boundary, Width>& own) const {
  using All = std::array<Boundary, Width>;
  constexpr int kCount = 4 * Width;
  std::vector<All> shown(rows_.size() / 4);
  if (report_.coupling == Coupling::all) {
    MPI_Allgather(&own, kCount, MPI_DOUBLE, shown.data(), kCount, MPI_DOUBLE, comm_);
  } else {
    const std::size_t at = rank_ > 0 ? 1 : 0;
    shown[at] = own;
    // Both ways at once, by calls that PETSc's log counts.
    std::array<MPI_Request, 4> requests{MPI_REQUEST_NULL, MPI_REQUEST_NULL, MPI_REQUEST_NULL, MPI_REQUEST_NULL};
    if (rank_ + 1 < ranks_) {
      MPI_Irecv(&shown.back(), kCount, MPI_DOUBLE, rank_ + 1, 2, comm_, requests.data());
      MPI_Isend(&own, kCount, MPI_DOUBLE, rank_ + 1, 3, comm_, &requests[1]);
    }
    if (rank_ > 0) {
      MPI_Irecv(shown.data(), kCount, MPI_DOUBLE, rank_ - 1, 3, comm_, &requests[2]);
      MPI_Isend(&own, kCount, MPI_DOUBLE, rank_ - 1, 2, comm_, &requests[3]);
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  }
  All known{};
  for (std::size_t c = 0; c < Width; ++c) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double value = shown[i / 4][c][i % 4];
      for (std::size_t a = 0; a < 4; ++a) {
        known[c][a] += rows_[i][a] * value;
      }
    }
  }
  return known;
}

/// Target and kink of one joint. @param beyond what the next rank's first node has
template <std::size_t Width>
void ChainSolver::visit(std::size_t j, const chain::Column* columns, const Beyond<Width>& beyond) {
  const Joint& joint = joints_[j];
  JointState<Width>& state = states<Width>()[j];
  const std::size_t i = joint.node;
  for (std::size_t c = 0; c < Width; ++c) {
    const chain::Column& column = columns[c];
    if (column.right_hand_side != nullptr) {
      const double* right = i < nodes_ ? column.right_hand_side + 2 * i : beyond[c].data();
      state.target[c] = right[0] * joint.inverse_scale[0] * joint.compliance;
      state.kink[c] = right[1] * joint.inverse_scale[1];
      continue;
    }
    const double* y = column.displacement;
    const double own = i < nodes_ ? y[i] : beyond[c][0];
    const double here = column.force != nullptr && i < nodes_ ? column.force[i] : 0.0;
    const double force = i < nodes_ ? here : beyond[c][2];
    const double left = joint.starts || i == 0 ? 0.0 : own - y[i - 1];
    const double next = joint.ends ? own : (i + 1 < nodes_ ? y[i + 1] : beyond[c][i + 1 - nodes_]);
    state.target[c] = joint.compliance * force - joint.ground_ratio * own;
    state.kink[c] = (left * joint.kink_ratio - (next - own)) * joint.kink_scale;
  }
}

/// Along the joints and back, from a known state after the first node and known force and moment after the last.
/// @return state after the last node, force and moment after the first
/// @note With `Final`, the solution takes the place of target and kink, and the stretches are told.
template <std::size_t Width, bool Final>
std::array<ChainSolver::Boundary, Width> ChainSolver::sweep(const std::array<Boundary, Width>& known) {
  JointState<Width>* const states = this->states<Width>();
  std::array<double, Width> w{};
  std::array<double, Width> t{};
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    JointState<Width>& s = states[j];
    const auto& f = joint.transfer;
    const auto& x = joint.combined;
    const auto& k = joint.stiffness;
    const chain::Ends* shown = joint.block >= 0 ? shown_.data() + joint.block : nullptr;
    for (std::size_t c = 0; c < Width; ++c) {
      if (joint.starts) {
        w[c] = s.target[c];
        t[c] = s.kink[c];
      } else if (j == 0) {
        w[c] = known[c][0];
        t[c] = known[c][1];
      } else {
        s.innovation[c] = s.target[c] - w[c];
        w[c] += joint.gain[0] * s.innovation[c];
        t[c] += joint.gain[1] * s.innovation[c] + s.kink[c];
      }
      s.deflection[c] = w[c];
      s.rotation[c] = t[c];
      const chain::Ends& own = shown != nullptr ? shown[c * blocks_] : kNothing;
      s.force[c] = own[2] - k[0] * w[c] - k[1] * t[c];
      s.moment[c] = own[3] - k[1] * w[c] - k[2] * t[c];
      const double w1 = w[c] + x[0] * s.force[c] + x[1] * s.moment[c];
      const double t1 = t[c] + x[1] * s.force[c] + x[2] * s.moment[c];
      if (j + 1 < joints_.size()) {
        w[c] = f[0] * w1 + f[1] * t1 + own[0];
        t[c] = f[2] * w1 + f[3] * t1 + own[1];
      }
    }
  }
  std::array<Boundary, Width> result{};
  std::array<double, Width> force{};
  std::array<double, Width> moment{};
  for (std::size_t c = 0; c < Width; ++c) {
    result[c][0] = w[c];
    result[c][1] = t[c];
    force[c] = known[c][2];
    moment[c] = known[c][3];
  }
  for (std::size_t j = joints_.size(); j-- > 0;) {
    const Joint& joint = joints_[j];
    JointState<Width>& s = states[j];
    if (j + 1 < joints_.size() && !joint.ends) {
      const auto& f = joint.transfer;
      const auto& x = joint.combined;
      const auto& g = joint.reaction;
      for (std::size_t c = 0; c < Width; ++c) {
        const double pull = s.force[c] + f[0] * force[c] + f[2] * moment[c];
        const double turn = s.moment[c] + f[1] * force[c] + f[3] * moment[c];
        s.deflection[c] += x[0] * pull + x[1] * turn;
        s.rotation[c] += x[1] * pull + x[2] * turn;
        if (Final && joint.block >= 0) {
          told_[c * blocks_ + static_cast<std::size_t>(joint.block)] = {s.deflection[c], s.rotation[c], force[c],
                                                                        moment[c]};
        }
        force[c] = g[0] * pull + g[1] * turn;
        moment[c] = g[2] * pull + g[3] * turn;
      }
    }
    for (std::size_t c = 0; c < Width; ++c) {
      if (joint.ends) {
        force[c] = 0.0;
        moment[c] = -s.rotation[c] * joint.rotation_release;
      }
      double deflection = s.deflection[c];
      const double own_moment = joint.starts && joint.kink_scale == 0.0 ? 0.0 : moment[c];
      if (!joint.starts && j > 0) {
        const double spring = s.innovation[c] * joint.release - joint.gain[0] * force[c] - joint.gain[1] * moment[c];
        // Elsewhere the state on the right gives it without the difference of large forces; on the right of an end
        // there is none, and a held node is where it is held.
        if (joint.ends || joint.compliance == 0.0) {
          deflection = s.target[c] - spring * joint.compliance;
        }
        force[c] += spring;
      }
      if constexpr (Final) {
        s.target[c] = deflection;
        s.kink[c] = own_moment;
      }
    }
  }
  for (std::size_t c = 0; c < Width; ++c) {
    result[c][2] = joints_[0].starts ? 0.0 : force[c];
    result[c][3] = joints_[0].starts ? 0.0 : moment[c];
  }
  return result;
}

template <std::size_t Width>
void ChainSolver::write(std::size_t j, const chain::Column* columns) {
  const Joint& joint = joints_[j];
  if (joint.node == nodes_) {
    return;
  }
  const auto& state = states<Width>()[j];
  const std::size_t i = joint.node;
  for (std::size_t c = 0; c < Width; ++c) {
    const chain::Column& column = columns[c];
    if (column.right_hand_side != nullptr) {
      const std::array<double, 2> values{state.target[c], state.kink[c]};
      for (std::size_t a = 0; a < 2; ++a) {
        column.unknowns[2 * i + a] =
            joint.inverse_scale[a] != 0.0 ? values[a] * joint.inverse_scale[a] : column.right_hand_side[2 * i + a];
      }
      continue;
    }
    column.stretch[i] = state.target[c];
    if (column.moment != nullptr) {
      column.moment[i] = state.kink[c];
    }
  }
}

/// Calls `treat(run, first block, blocks)` for all stretches and `visit(joint)` for all joints but the last ones, each
/// shortly after the stretch on its right.
template <class Treat, class Visit>
void ChainSolver::walk(std::size_t joints, const Treat& treat, const Visit& visit) const {
  auto run = runs_.begin();
  std::size_t done = 0;  // blocks of all runs
  for (std::size_t j = 0; j < joints; ++j) {
    if (joints_[j].block >= 0 && static_cast<std::size_t>(joints_[j].block) == done) {
      const std::size_t blocks = std::min(kChunk, run->block + run->blocks - done);
      treat(*run, done, blocks);
      done += blocks;
      if (done == run->block + run->blocks) {
        ++run;
      }
    }
    visit(j);
  }
}

template <std::size_t Width>
void ChainSolver::solve_batch(const chain::Column* columns) {
  Beyond<Width> first{};
  Beyond<Width> beyond{};
  std::array<MPI_Request, 2> requests{MPI_REQUEST_NULL, MPI_REQUEST_NULL};
  constexpr int kCount = 3 * Width;
  if (ranks_ > 1) {
    for (std::size_t c = 0; c < Width; ++c) {
      const chain::Column& column = columns[c];
      const double* values = column.right_hand_side != nullptr ? column.right_hand_side : column.displacement;
      first[c] = {values[0], values[1], column.force != nullptr ? column.force[0] : 0.0};
    }
    if (rank_ + 1 < ranks_) {
      MPI_Irecv(&beyond, kCount, MPI_DOUBLE, rank_ + 1, 4, comm_, requests.data());
    }
    if (rank_ > 0) {
      MPI_Isend(&first, kCount, MPI_DOUBLE, rank_ - 1, 4, comm_, &requests[1]);
    }
  }
  // The last own joint and the one beyond wait for the message.
  const std::size_t early = joints_.size() - (joints_.back().node == nodes_ ? 2 : 1);
  walk(
      early,
      [&](const Run& run, std::size_t block, std::size_t blocks) {
        const chain::Span& span = spans_[run.span];
        const std::size_t node = run.first + (block - run.block) * span.key().elements;
        for (std::size_t c = 0; c < Width; ++c) {
          chain::condense(span, columns[c], node, blocks, shown_.data() + c * blocks_ + block, report_.lanes,
                          nodes_ > kCached);
        }
      },
      [&](std::size_t j) { visit<Width>(j, columns, beyond); });
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  for (std::size_t j = early; j < joints_.size(); ++j) {
    visit<Width>(j, columns, beyond);
  }

  std::array<Boundary, Width> known{};
  if (ranks_ > 1) {
    known = exchange<Width>(sweep<Width, false>(known));
  }
  sweep<Width, true>(known);

  walk(
      joints_.size(),
      [&](const Run& run, std::size_t block, std::size_t blocks) {
        const chain::Span& span = spans_[run.span];
        const std::size_t node = run.first + (block - run.block) * span.key().elements;
        for (std::size_t c = 0; c < Width; ++c) {
          chain::resolve(span, columns[c], node, blocks, told_.data() + c * blocks_ + block, scratch_.data(),
                         report_.lanes);
        }
      },
      [&](std::size_t j) { write<Width>(j, columns); });
}

void ChainSolver::solve(std::span<const chain::Column> columns) {
  std::size_t done = 0;
  for (; done + kBatch <= columns.size(); done += kBatch) {
    solve_batch<kBatch>(columns.data() + done);
  }
  if (done + 2 <= columns.size()) {
    solve_batch<2>(columns.data() + done);
    done += 2;
  }
  if (done < columns.size()) {
    solve_batch<1>(columns.data() + done);
  }
}

double ChainSolver::bytes_per_solve(const chain::Column& kind) const {
  constexpr double kNumber = sizeof(double);
  const double given = kind.right_hand_side != nullptr ? 2.0 : (kind.force != nullptr ? 2.0 : 1.0);
  const double found = kind.right_hand_side != nullptr || kind.moment != nullptr ? 2.0 : 1.0;
  // What is given is read before and after the joints are solved; joints are passed twice by each sweep.
  const double sweeps = ranks_ > 1 ? 4.0 : 2.0;
  return kNumber * (2.0 * given + found) * static_cast<double>(nodes_) +
         sweeps * static_cast<double>(joints_.size() * (sizeof(Joint) + sizeof(JointState<1>))) +
         2.0 * sweeps * static_cast<double>(blocks_ * sizeof(chain::Ends));
}

}  // namespace udar
