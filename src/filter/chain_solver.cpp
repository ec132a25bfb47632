#include "udar/filter/chain_solver.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// Beyond so many nodes on a rank (2 MB a vector) what is given comes from memory.
constexpr std::size_t kCached = 250000;
/// Spans treated between two visits to their joints, whose values are still in the cache then.
constexpr std::size_t kChunk = 4 * chain::kLanes;

}  // namespace

template <std::size_t Width>
struct ChainSolver::JointState {
  std::array<double, Width> target;      // of the line above the mass, by force and ground; then the solution
  std::array<double, Width> kink;        // of the line relative to the masses; then the moment
  std::array<double, Width> deflection;  // of the state after the node, known from the left
  std::array<double, Width> rotation;
  std::array<double, Width> innovation;
  std::array<double, Width> force;  // of the span on the right, for this state and a free right end
  std::array<double, Width> moment;
};

ChainSolver::ChainSolver(const LineData& line, int lanes) : factor_{line} {
  report_.lanes = lanes == 0 ? chain::native_lanes() : lanes;
  const std::string failure = lanes_supported(report_.lanes)
                                  ? std::string{}
                                  : "the chain solver cannot use " + std::to_string(lanes) + " lanes on this processor";
  throw_together<InputError>(line.comm, failure);
  std::size_t longest = 0;
  for (const chain::Span& span : factor_.spans) {
    longest = std::max(longest, span.inner());
    report_.factor_bytes += span.inner() * (sizeof(chain::Span::Gain) + 16 * sizeof(double));
  }
  shown_.resize(kBatch * factor_.blocks);
  told_.resize(kBatch * factor_.blocks);
  joint_states_.resize(factor_.joints.size() * sizeof(JointState<kBatch>) / sizeof(double));
  scratch_.resize(4 * chain::kLanes * longest);
  report_.inner_nodes = factor_.inner_nodes;
  report_.shortest_decay = factor_.shortest_decay;
  report_.longest_decay = factor_.longest_decay;
  report_.carried = factor_.carried;
  report_.coupling = factor_.coupling;
  report_.joints = factor_.joints.size();
  report_.spans = factor_.spans.size();
  report_.factor_bytes +=
      factor_.joints.size() * sizeof(chain::Joint) + factor_.boundary.size() * sizeof(factor_.boundary[0]);
  report_.work_bytes =
      (shown_.size() + told_.size()) * sizeof(chain::Ends) + (joint_states_.size() + scratch_.size()) * sizeof(double);
}

bool ChainSolver::lanes_supported(int lanes) {
  return (lanes == 1 || lanes == 4 || lanes == 8) && lanes <= chain::native_lanes();
}

/// From what the pieces show to what this rank must know.
template <std::size_t Width>
std::array<ChainSolver::Boundary, Width> ChainSolver::exchange(const std::array<Boundary, Width>& own) const {
  using All = std::array<Boundary, Width>;
  constexpr int kCount = 4 * Width;
  std::vector<All> shown(factor_.boundary.size() / 4);
  if (factor_.coupling == chain::Coupling::all) {
    MPI_Allgather(&own, kCount, MPI_DOUBLE, shown.data(), kCount, MPI_DOUBLE, factor_.comm);
  } else {
    const std::size_t at = factor_.rank > 0 ? 1 : 0;
    shown[at] = own;
    // Both ways at once, by calls that PETSc's log counts.
    std::array<MPI_Request, 4> requests{MPI_REQUEST_NULL, MPI_REQUEST_NULL, MPI_REQUEST_NULL, MPI_REQUEST_NULL};
    if (factor_.rank + 1 < factor_.ranks) {
      MPI_Irecv(&shown.back(), kCount, MPI_DOUBLE, factor_.rank + 1, 2, factor_.comm, requests.data());
      MPI_Isend(&own, kCount, MPI_DOUBLE, factor_.rank + 1, 3, factor_.comm, &requests[1]);
    }
    if (factor_.rank > 0) {
      MPI_Irecv(shown.data(), kCount, MPI_DOUBLE, factor_.rank - 1, 3, factor_.comm, &requests[2]);
      MPI_Isend(&own, kCount, MPI_DOUBLE, factor_.rank - 1, 2, factor_.comm, &requests[3]);
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  }
  All known{};
  for (std::size_t c = 0; c < Width; ++c) {
    for (std::size_t i = 0; i < factor_.boundary.size(); ++i) {
      const double value = shown[i / 4][c][i % 4];
      for (std::size_t a = 0; a < 4; ++a) {
        known[c][a] += factor_.boundary[i][a] * value;
      }
    }
  }
  return known;
}

/// Target and kink of one joint. @param beyond what the next rank's first node has
template <std::size_t Width>
void ChainSolver::visit(std::size_t j, const FilterColumn* columns, const Beyond<Width>& beyond) {
  const chain::Joint& joint = factor_.joints[j];
  JointState<Width>& state = states<Width>()[j];
  const std::size_t i = joint.node;
  for (std::size_t c = 0; c < Width; ++c) {
    const FilterColumn& column = columns[c];
    if (column.right_hand_side != nullptr) {
      const double* right = i < factor_.nodes ? column.right_hand_side + 2 * i : beyond[c].data();
      state.target[c] = right[0] * joint.inverse_scale[0] * joint.compliance;
      state.kink[c] = right[1] * joint.inverse_scale[1];
      continue;
    }
    const double* y = column.displacement;
    const double own = i < factor_.nodes ? y[i] : beyond[c][0];
    const double here = column.force != nullptr && i < factor_.nodes ? column.force[i] : 0.0;
    const double force = i < factor_.nodes ? here : beyond[c][2];
    const double left = joint.starts || i == 0 ? 0.0 : own - y[i - 1];
    const double next = joint.ends ? own : (i + 1 < factor_.nodes ? y[i + 1] : beyond[c][i + 1 - factor_.nodes]);
    state.target[c] = joint.compliance * force - joint.ground_ratio * own;
    state.kink[c] = (left * joint.kink_ratio - (next - own)) * joint.kink_scale;
  }
}

/// Along the joints from left to right. @return state after the last node
template <std::size_t Width>
std::array<ChainSolver::State, Width> ChainSolver::sweep_right(const std::array<Boundary, Width>& known) {
  JointState<Width>* const states = this->states<Width>();
  std::array<double, Width> w{};
  std::array<double, Width> t{};
  for (std::size_t j = 0; j < factor_.joints.size(); ++j) {
    const chain::Joint& joint = factor_.joints[j];
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
        w[c] = joint.stiff ? joint.keep * w[c] + joint.gain[0] * s.target[c] : w[c] + joint.gain[0] * s.innovation[c];
        t[c] += joint.gain[1] * s.innovation[c] + s.kink[c];
      }
      s.deflection[c] = w[c];
      s.rotation[c] = t[c];
      const chain::Ends& own = shown != nullptr ? shown[c * factor_.blocks] : kNothing;
      s.force[c] = own[2] - k[0] * w[c] - k[1] * t[c];
      s.moment[c] = own[3] - k[1] * w[c] - k[2] * t[c];
      const double w1 = w[c] + x[0] * s.force[c] + x[1] * s.moment[c];
      const double t1 = t[c] + x[1] * s.force[c] + x[2] * s.moment[c];
      if (j + 1 < factor_.joints.size()) {
        w[c] = f[0] * w1 + f[1] * t1 + own[0];
        t[c] = f[2] * w1 + f[3] * t1 + own[1];
      }
    }
  }
  std::array<State, Width> after{};
  for (std::size_t c = 0; c < Width; ++c) {
    after[c] = {w[c], t[c]};
  }
  return after;
}

/// Back, after `sweep_right`. @return force and moment after the first node
/// @note With `Final`, the solution takes the place of target and kink, and the spans are told.
template <std::size_t Width, bool Final>
std::array<ChainSolver::State, Width> ChainSolver::sweep_left(const std::array<Boundary, Width>& known) {
  JointState<Width>* const states = this->states<Width>();
  std::array<double, Width> force{};
  std::array<double, Width> moment{};
  for (std::size_t c = 0; c < Width; ++c) {
    force[c] = known[c][2];
    moment[c] = known[c][3];
  }
  for (std::size_t j = factor_.joints.size(); j-- > 0;) {
    const chain::Joint& joint = factor_.joints[j];
    JointState<Width>& s = states[j];
    if (j + 1 < factor_.joints.size() && !joint.ends) {
      const auto& f = joint.transfer;
      const auto& x = joint.combined;
      const auto& g = joint.reaction;
      for (std::size_t c = 0; c < Width; ++c) {
        const double pull = s.force[c] + f[0] * force[c] + f[2] * moment[c];
        const double turn = s.moment[c] + f[1] * force[c] + f[3] * moment[c];
        s.deflection[c] += x[0] * pull + x[1] * turn;
        s.rotation[c] += x[1] * pull + x[2] * turn;
        if (Final && joint.block >= 0) {
          told_[c * factor_.blocks + static_cast<std::size_t>(joint.block)] = {s.deflection[c], s.rotation[c], force[c],
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
        // there is none, and a node that is fixed, or all but fixed, is where its spring's force puts it.
        if (joint.ends || joint.stiff) {
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
  std::array<State, Width> first{};
  for (std::size_t c = 0; c < Width; ++c) {
    first[c] = {force[c], moment[c]};
  }
  return first;
}

/// Along the joints and back, from a known state after the first node and known force and moment after the last.
/// @return state after the last node, force and moment after the first
template <std::size_t Width, bool Final>
std::array<ChainSolver::Boundary, Width> ChainSolver::sweep(const std::array<Boundary, Width>& known) {
  const auto after = sweep_right<Width>(known);
  const auto first = sweep_left<Width, Final>(known);
  const bool starts = factor_.joints[0].starts;
  std::array<Boundary, Width> result{};
  for (std::size_t c = 0; c < Width; ++c) {
    result[c] = {after[c][0], after[c][1], starts ? 0.0 : first[c][0], starts ? 0.0 : first[c][1]};
  }
  return result;
}

template <std::size_t Width>
void ChainSolver::write(std::size_t j, const FilterColumn* columns) {
  const chain::Joint& joint = factor_.joints[j];
  if (joint.node == factor_.nodes) {
    return;
  }
  const auto& state = states<Width>()[j];
  const std::size_t i = joint.node;
  for (std::size_t c = 0; c < Width; ++c) {
    const FilterColumn& column = columns[c];
    if (column.right_hand_side != nullptr) {
      const std::array<double, 2> values{state.target[c], state.kink[c]};
      for (std::size_t a = 0; a < 2; ++a) {
        column.unknowns[2 * i + a] =
            joint.inverse_scale[a] != 0.0 ? values[a] * joint.inverse_scale[a] : column.right_hand_side[2 * i + a];
      }
      continue;
    }
    column.stretch[i] = state.target[c];
    if (column.internal != nullptr) {
      column.internal[i] = state.kink[c];
    }
  }
}

/// Calls `treat(row, first block, blocks)` for all spans and `visit(joint)` for all joints but the last ones, each
/// shortly after the span on its right.
template <class Treat, class Visit>
void ChainSolver::walk(std::size_t joints, const Treat& treat, const Visit& visit) const {
  auto row = factor_.rows_of_spans.begin();
  std::size_t done = 0;  // blocks of all rows
  for (std::size_t j = 0; j < joints; ++j) {
    if (factor_.joints[j].block >= 0 && static_cast<std::size_t>(factor_.joints[j].block) == done) {
      const std::size_t blocks = std::min(kChunk, row->block + row->blocks - done);
      treat(*row, done, blocks);
      done += blocks;
      if (done == row->block + row->blocks) {
        ++row;
      }
    }
    visit(j);
  }
}

template <std::size_t Width>
void ChainSolver::solve_batch(const FilterColumn* columns) {
  Beyond<Width> first{};
  Beyond<Width> beyond{};
  std::array<MPI_Request, 2> requests{MPI_REQUEST_NULL, MPI_REQUEST_NULL};
  constexpr int kCount = 3 * Width;
  if (factor_.ranks > 1) {
    for (std::size_t c = 0; c < Width; ++c) {
      const FilterColumn& column = columns[c];
      const double* values = column.right_hand_side != nullptr ? column.right_hand_side : column.displacement;
      first[c] = {values[0], values[1], column.force != nullptr ? column.force[0] : 0.0};
    }
    if (factor_.rank + 1 < factor_.ranks) {
      MPI_Irecv(&beyond, kCount, MPI_DOUBLE, factor_.rank + 1, 4, factor_.comm, requests.data());
    }
    if (factor_.rank > 0) {
      MPI_Isend(&first, kCount, MPI_DOUBLE, factor_.rank - 1, 4, factor_.comm, &requests[1]);
    }
  }
  // The last own joint and the one beyond wait for the message.
  const std::size_t early = factor_.joints.size() - (factor_.joints.back().node == factor_.nodes ? 2 : 1);
  walk(
      early,
      [&](const chain::SpanRow& row, std::size_t block, std::size_t blocks) {
        const chain::Span& span = factor_.spans[row.span];
        const std::size_t node = row.first + (block - row.block) * span.key().elements;
        for (std::size_t c = 0; c < Width; ++c) {
          chain::condense(span, columns[c], node, blocks, shown_.data() + c * factor_.blocks + block, report_.lanes,
                          factor_.nodes > kCached);
        }
      },
      [&](std::size_t j) { visit<Width>(j, columns, beyond); });
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  for (std::size_t j = early; j < factor_.joints.size(); ++j) {
    visit<Width>(j, columns, beyond);
  }

  std::array<Boundary, Width> known{};
  if (factor_.ranks > 1) {
    known = exchange<Width>(sweep<Width, false>(known));
  }
  sweep<Width, true>(known);

  walk(
      factor_.joints.size(),
      [&](const chain::SpanRow& row, std::size_t block, std::size_t blocks) {
        const chain::Span& span = factor_.spans[row.span];
        const std::size_t node = row.first + (block - row.block) * span.key().elements;
        for (std::size_t c = 0; c < Width; ++c) {
          chain::resolve(span, columns[c], node, blocks, told_.data() + c * factor_.blocks + block, scratch_.data(),
                         report_.lanes);
        }
      },
      [&](std::size_t j) { write<Width>(j, columns); });
}

void ChainSolver::solve(std::span<const FilterColumn> columns) {
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

double ChainSolver::bytes_per_solve(const FilterColumn& kind) const {
  constexpr double kNumber = sizeof(double);
  const double given = kind.right_hand_side != nullptr ? 2.0 : (kind.force != nullptr ? 2.0 : 1.0);
  const double found = kind.right_hand_side != nullptr || kind.internal != nullptr ? 2.0 : 1.0;
  // What is given is read before and after the joints are solved; joints are passed twice by each sweep.
  const double sweeps = factor_.ranks > 1 ? 4.0 : 2.0;
  return kNumber * (2.0 * given + found) * static_cast<double>(factor_.nodes) +
         sweeps * static_cast<double>(factor_.joints.size() * (sizeof(chain::Joint) + sizeof(JointState<1>))) +
         2.0 * sweeps * static_cast<double>(factor_.blocks * sizeof(chain::Ends));
}

}  // namespace udar
