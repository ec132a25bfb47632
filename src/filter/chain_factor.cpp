#include "udar/filter/chain_factor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "chain_algebra.hpp"
#include "udar/petsc/error.hpp"

namespace udar::chain {
namespace {

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

/// Transfer, compliance and stiffness of one element, as of a span.
Matrix2 element_transfer(const BeamElement& e) { return {1, e.length, 0, 1}; }
Symmetric element_compliance(const BeamElement& e) {
  const long double h = e.length;
  return {h * h * h * e.flexural_compliance / 3 + h * e.shear_compliance, h * h * e.flexural_compliance / 2,
          h * e.flexural_compliance};
}

// Spans of at most 377 elements: sixteen of them, their gains and what is kept between the two sweeps stay in a
// second-level cache, and joints cost little. Not near multiples of 4 KiB. Shorter than 4, they are no cheaper than
// joints.
constexpr std::size_t kLongest = 377;
constexpr std::size_t kShortest = 4;

// A spring with less of the compliance at its node than this is stiff: below, 1 - gain loses three digits and more.
constexpr long double kStiff = 1e-3L;

/// Along the joints of a rank's piece: what the chain so far looks like from here.
class Recursion {
 public:
  Recursion(const LineData& line, const Factor& factor) : line_{&line}, factor_{&factor} {
    piece_.shortest = std::numeric_limits<long double>::infinity();
  }

  /// Adds the springs of a joint. @param previous the joint before, null of the first one
  void enter(Joint& joint, const Joint* previous) {
    const std::size_t i = joint.node;
    const BeamElement& left = line_->elements[i];
    const BeamElement& right = line_->elements[i + 1];
    joint.starts = !LineData::present(left);
    joint.ends = !LineData::present(right);
    const double stiffness = line_->filter_stiffness[i] + line_->ground_stiffness[i];
    const long double compliance = inverse(stiffness);
    joint.compliance = static_cast<double>(compliance);
    joint.ground_ratio = std::isinf(stiffness) ? 1.0 : line_->ground_stiffness[i] / stiffness;
    const double rotation = line_->rotation(i);
    for (std::size_t a = 0; a < 2; ++a) {
      const double scale = line_->scale[2 * i + a];
      joint.inverse_scale[a] = scale != 0.0 ? 1.0 / scale : 0.0;
    }
    joint.kink_ratio = joint.starts ? 0.0 : (joint.ends ? 1.0 : right.length / left.length);
    joint.kink_scale = joint.starts && rotation == 0.0 ? 0.0 : 1.0 / (joint.ends ? left.length : right.length);
    if (joint.starts) {
      start(compliance, rotation);
    } else if (previous == nullptr) {
      here_ = {};
    } else if (free_start_) {
      take_rotation(joint, previous->compliance, compliance);
    } else {
      add_spring(joint, compliance);
    }
  }

  /// Passes the end of a beam at a joint.
  void end(Joint& joint) {
    const double rotation = line_->rotation(joint.node);
    const long double release = rotation == 0.0 ? 0 : 1 / (here_.entries[2] + inverse(rotation));
    joint.rotation_release = static_cast<double>(release);
    const Symmetric felt{passed_[2] * passed_[2] * release, passed_[2] * passed_[3] * release,
                         passed_[3] * passed_[3] * release};
    piece_.stiffness = add(piece_.stiffness, felt);
    passed_ = {};
    det_passed_ = 0;
    here_ = {};
  }

  /// Passes the span on the right of a joint.
  void pass(Joint& joint) {
    const BeamElement& right = line_->elements[joint.node + 1];
    note_decay(right, line_->filter_stiffness[joint.node]);
    const Span* span = span_of(joint);
    const bool plain = span == nullptr;
    const Matrix2 transfer = plain ? element_transfer(right) : span->transfer();
    const Symmetric added = plain ? element_compliance(right) : span->compliance();
    const Symmetric stiff = plain ? Symmetric{} : span->stiffness();
    const long double det_transfer = plain ? 1.0L : span->transfer_determinant();
    const Combined combined = combine(here_, stiff);
    const Matrix2& reaction = combined.reaction;
    joint.transfer = rounded(transfer);
    joint.stiffness = rounded(stiff);
    joint.combined = rounded(combined.value.entries);
    joint.reaction = rounded(reaction);
    piece_.stiffness =
        add(piece_.stiffness, congruent(transposed(passed_), symmetric(multiply(reaction, full(stiff)))));
    passed_ = multiply(transfer, multiply(transposed(reaction), passed_));
    det_passed_ *= det_transfer * combined.shrink;
    here_ = carry(transfer, det_transfer, combined.value, {added, added[0] * added[2] - added[1] * added[1]});
  }

  [[nodiscard]] Piece piece() const {
    Piece piece = piece_;
    piece.transfer = passed_;
    piece.det_transfer = det_passed_;
    piece.compliance = here_.entries;
    piece.det_compliance = here_.det;
    return piece;
  }

 private:
  void start(long double compliance, double rotation) {
    free_start_ = rotation == 0.0;
    here_.entries = {compliance, 0, free_start_ ? 0 : inverse(rotation)};
    here_.det = here_.entries[0] * here_.entries[2];
    passed_ = {};
    det_passed_ = 0;
  }

  /// Nothing is known of the rotation before this second node: it takes all of the innovation.
  void take_rotation(Joint& joint, long double first, long double compliance) {
    const BeamElement& left = line_->elements[joint.node];
    const long double h = left.length;
    joint.gain = {1.0, static_cast<double>(1 / h)};
    joint.stiff = compliance < kStiff * element_compliance(left)[0];
    joint.keep = 0.0;
    here_.entries = {compliance, compliance / h,
                     (first + compliance) / (h * h) + h * left.flexural_compliance / 3 + left.shear_compliance / h};
    here_.det = compliance * (first / (h * h) + h * left.flexural_compliance / 3 + left.shear_compliance / h);
    free_start_ = false;
  }

  void add_spring(Joint& joint, long double compliance) {
    Symmetric& p = here_.entries;
    const long double release = 1 / (p[0] + compliance);
    const long double g0 = p[0] * release;
    const long double g1 = p[1] * release;
    joint.gain = {static_cast<double>(g0), static_cast<double>(g1)};
    joint.release = static_cast<double>(release);
    const Symmetric felt{passed_[0] * passed_[0] * release, passed_[0] * passed_[1] * release,
                         passed_[1] * passed_[1] * release};
    piece_.stiffness = add(piece_.stiffness, felt);
    const long double kept = compliance * release;
    joint.stiff = kept < kStiff;
    joint.keep = static_cast<double>(kept);
    passed_ = {kept * passed_[0], kept * passed_[1], passed_[2] - g1 * passed_[0], passed_[3] - g1 * passed_[1]};
    det_passed_ *= kept;
    here_.det *= kept;
    p = {g0 * compliance, g1 * compliance, p[2] - g1 * p[1]};
  }

  void note_decay(const BeamElement& element, double filter_stiffness) {
    const long double decay =
        std::sqrt(std::sqrt(4.0L * element.length / (element.flexural_compliance * filter_stiffness)));
    if (decay > piece_.decay) {
      piece_.decay = decay;
      piece_.force = 1 / (element.flexural_compliance * decay * decay * decay);
    }
    piece_.shortest = std::min(piece_.shortest, decay);
  }

  /// Null where the joint's right neighbour is the next joint.
  const Span* span_of(const Joint& joint) {
    if (joint.block < 0) {
      return nullptr;
    }
    const auto& rows = factor_->rows_of_spans;
    if (static_cast<std::size_t>(joint.block) == rows[row_].block + rows[row_].blocks) {
      ++row_;
    }
    return &factor_->spans[rows[row_].span];
  }

  const LineData* line_;
  const Factor* factor_;
  Piece piece_;
  Compliance here_;             // after the node, or before it
  Matrix2 passed_ = kIdentity;  // what has come through from the piece's first node
  long double det_passed_ = 1;
  bool free_start_ = false;
  std::size_t row_ = 0;  // of the last span passed
};

/// Weights of what all ranks show in (state after, force and moment after) the first node of rank `boundary`.
std::vector<std::array<long double, 4>> boundary_rows(const std::vector<Piece>& pieces, std::size_t boundary) {
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
  std::vector<Matrix2> from_state(pieces.size());
  std::vector<Matrix2> from_reaction(pieces.size());
  Matrix2 weight = kIdentity;
  for (std::size_t i = boundary; i-- > 0;) {
    from_state[i] = weight;
    weight = multiply(weight, pieces[i].transfer);
    from_reaction[i] = multiply(weight, full(combined[i].value.entries));
    weight = multiply(weight, transposed(combined[i].reaction));
  }
  // From the right, the stiffness j of all pieces from i on, and the weights of their common reaction.
  Symmetric j{};
  std::vector<Symmetric> beyond(pieces.size());
  std::vector<Matrix2> carried(pieces.size());
  for (std::size_t i = pieces.size(); i-- > boundary;) {
    beyond[i] = j;
    const Matrix2 reaction = combine({pieces[i].compliance, pieces[i].det_compliance}, j).reaction;
    carried[i] = multiply(transposed(pieces[i].transfer), reaction);
    j = add(pieces[i].stiffness, congruent(transposed(pieces[i].transfer), symmetric(multiply(reaction, full(j)))));
  }
  std::vector<Matrix2> reaction_of_state(pieces.size());
  std::vector<Matrix2> reaction_of_reaction(pieces.size());
  weight = kIdentity;
  for (std::size_t i = boundary; i < pieces.size(); ++i) {
    reaction_of_reaction[i] = weight;
    weight = multiply(weight, carried[i]);
    reaction_of_state[i] = negative(multiply(weight, full(beyond[i])));
  }
  // s = (1 + P J)^-1 m + X eta,  r = (1 + J P)^-1 (eta - J m).
  const Combined here = combine(p, j);
  const Matrix2 to_state = transposed(here.reaction);
  const Matrix2 x = full(here.value.entries);
  const Matrix2 pull = multiply(here.reaction, full(j));
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto put = [&](std::size_t column, const Matrix2& state, const Matrix2& eta) {
      const Matrix2 s = add(multiply(to_state, state), multiply(x, eta));
      const Matrix2 r = add(multiply(here.reaction, eta), negative(multiply(pull, state)));
      rows[4 * i + column] = {s[0], s[2], r[0], r[2]};
      rows[4 * i + column + 1] = {s[1], s[3], r[1], r[3]};
    };
    put(0, from_state[i], reaction_of_state[i]);
    put(2, from_reaction[i], reaction_of_reaction[i]);
  }
  return rows;
}

}  // namespace

Factor::Factor(const LineData& line) : comm{line.comm}, nodes{line.local_nodes()} {
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  throw_together<InputError>(
      comm, nodes < 2 ? "the chain solver needs at least two nodes on every rank; use fewer ranks" : std::string{});
  cut(line);
  Recursion recursion{line, *this};
  for (std::size_t j = 0; j < joints.size(); ++j) {
    Joint& joint = joints[j];
    recursion.enter(joint, j > 0 ? &joints[j - 1] : nullptr);
    if (j + 1 == joints.size() && joint.node == nodes) {
      break;  // the next rank's own affair
    }
    if (joint.ends) {
      recursion.end(joint);
    } else {
      recursion.pass(joint);
    }
  }
  couple(recursion.piece());
}

void Factor::cut(const LineData& line) {
  const auto& elements = line.elements;
  // Whether a node can be inside a span, and inside the same as another.
  const auto regular = [&](std::size_t i) {
    return equal(elements[i], elements[i + 1]) && std::isfinite(line.ground_stiffness[i]);
  };
  const auto alike = [&](std::size_t i, std::size_t j) {
    return line.filter_stiffness[i] == line.filter_stiffness[j] &&
           line.ground_stiffness[i] == line.ground_stiffness[j] && line.scale[2 * i] == line.scale[2 * j] &&
           line.scale[2 * i + 1] == line.scale[2 * j + 1];
  };
  const std::size_t last = nodes - 1;
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
    add_spans(line, from, to, known);
    from = to;
  }
  joints.push_back({.node = last});
  if (line.end < line.nodes && LineData::present(elements[nodes])) {
    joints.push_back({.node = nodes});
  }
}

/// Joints and rows of spans from one node up to another, between which all is alike.
void Factor::add_spans(const LineData& line, std::size_t from, std::size_t to, Known& known) {
  const auto add_row = [&](std::size_t elements, std::size_t count) {
    const BeamElement& element = line.elements[from + 1];
    const std::size_t inner = from + 1;
    const SpanKey key{.elements = elements,
                      .length = element.length,
                      .flexural_compliance = element.flexural_compliance,
                      .shear_compliance = element.shear_compliance,
                      .filter_stiffness = line.filter_stiffness[inner],
                      .ground_stiffness = line.ground_stiffness[inner],
                      .scale = {line.scale[2 * inner], line.scale[2 * inner + 1]}};
    const auto [found, unknown] = known.try_emplace(key, spans.size());
    if (unknown) {
      spans.emplace_back(key);
    }
    rows_of_spans.push_back({.span = found->second, .first = from, .block = blocks, .blocks = count});
    for (std::size_t block = 0; block < count; ++block) {
      joints.push_back({.node = from, .block = static_cast<std::ptrdiff_t>(blocks)});
      ++blocks;
      from += elements;
    }
    inner_nodes += count * (elements - 1);
  };
  while (to - from >= kLanes * (kLanes + 1)) {
    const std::size_t groups = (to - from + kLanes * kLongest - 1) / (kLanes * kLongest);
    const std::size_t elements = ((to - from) / (kLanes * groups) - 1) / kLanes * kLanes + 1;
    add_row(elements, kLanes * groups);
  }
  if (to - from >= kShortest) {
    add_row(to - from, 1);
  }
  for (; from < to; ++from) {
    joints.push_back({.node = from});
  }
}

void Factor::couple(const Piece& own) {
  static_assert(sizeof(Piece) % sizeof(long double) == 0);
  constexpr int kSize = sizeof(Piece) / sizeof(long double);
  std::vector<Piece> pieces(static_cast<std::size_t>(ranks));
  MPI_Allgather(&own, kSize, MPI_LONG_DOUBLE, pieces.data(), kSize, MPI_LONG_DOUBLE, comm);
  const Piece& slowest = *std::ranges::max_element(pieces, {}, &Piece::decay);
  const long double length = slowest.decay;
  for (const Piece& piece : pieces) {
    const Matrix2& t = piece.transfer;
    carried = std::max({carried, static_cast<double>(std::abs(t[0])), static_cast<double>(std::abs(t[1]) / length),
                        static_cast<double>(std::abs(t[2]) * length), static_cast<double>(std::abs(t[3]))});
  }
  longest_decay = static_cast<double>(length);
  shortest_decay = static_cast<double>(std::ranges::min_element(pieces, {}, &Piece::shortest)->shortest);
  if (ranks == 1) {
    return;
  }
  // This rank needs the state at its own first node, and force and moment at the next rank's.
  const auto own_rank = static_cast<std::size_t>(rank);
  const auto first = boundary_rows(pieces, own_rank);
  const auto next = boundary_rows(pieces, own_rank + 1);
  const std::array<long double, 4> unit{1, 1 / length, slowest.force, slowest.force * length};
  // Below round-off of what comes from near.
  constexpr long double kNegligible = 1e-17L;
  int near = 1;
  boundary.resize(first.size());
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    const std::array<long double, 4> row{first[i][0], first[i][1], next[i][2], next[i][3]};
    boundary[i] = rounded(row);
    const std::size_t away = i / 4 > own_rank ? i / 4 - own_rank : own_rank - i / 4;
    for (std::size_t a = 0; a < 4; ++a) {
      if (away > 1 && std::abs(row[a]) * unit[i % 4] > kNegligible * unit[a]) {
        near = 0;
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &near, 1, MPI_INT, MPI_MIN, comm);
  coupling = near != 0 ? Coupling::neighbours : Coupling::all;
  if (near != 0) {
    boundary.erase(boundary.begin() + static_cast<std::ptrdiff_t>(4 * std::min(own_rank + 2, pieces.size())),
                   boundary.end());
    boundary.erase(boundary.begin(),
                   boundary.begin() + static_cast<std::ptrdiff_t>(4 * (own_rank > 0 ? own_rank - 1 : 0)));
  }
}

}  // namespace udar::chain
