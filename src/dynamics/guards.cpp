#include "udar/dynamics/guards.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "udar/motion/finite.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar {
namespace {

// Integration that deserves the name is off by a thousandth of the motion's length at most: a mass this deep in a rigid
// support has fallen through it.
constexpr double kFallenThrough = 0.1;
// An energy balance that is off by half of the largest energy seen belongs to an unstable integration.
constexpr double kUnstable = 0.5;
// One that is off by this is worth a warning.
constexpr double kDrift = 1e-3;
// Rounding, and what sweeps leave of an error, beside the largest energy: what takes energy gives no more than this.
constexpr double kGainRounding = 1e-9;
// Events are located to round-off, and gaps of a line in contact are solved for: depths seen are below 1e-15 of the
// motion's length (docs/theory.md, "Guards").
constexpr double kDepth = 1e-6;

struct Words {
  const char* finding;
  const char* unit;  // of value and limit; null: there are none
  const char* advice;
};
constexpr std::array<Words, kGuards> kWords{{
    {"the motion is no longer finite", nullptr,
     "a load or the line solve is not finite, or the steps are too long for `filter frequency` (see -ts_dt, "
     "-ts_adapt_type)"},
    {"the energy is no longer finite", nullptr,
     "the motion has outgrown double precision: the integration is unstable (see -ts_dt, -ts_adapt_type, -ts_rtol), or "
     "a load, a speed or a height is too large"},
    {"the beam has fallen through a rigid support by", " m",
     "the steps are too long to see it come (see -ts_dt, -ts_rtol)"},
    {"the integration is unstable: the energy balance is off by", " of the energy",
     "steps must stay below about 1 / `filter frequency` (see -ts_dt, -ts_adapt_type, -ts_rtol)"},
    {"dampers, which can but take energy, have given", " J", "shorten the steps (see -ts_dt, -ts_rtol)"},
    {"the beam is below a rigid support by", " m", "do not trust this contact; lower -ts_rtol or -ts_dt"},
    {"an impact, which can but take energy, has given", " J", "do not trust these impacts; lower -ts_rtol or -ts_dt"},
    {"impacts and rests, which can but take energy, have given", " J",
     "do not trust these impacts; lower -ts_rtol or -ts_dt"},
    {"the energy balance is off by", " of the energy", "do not trust these curves; lower -ts_rtol or -ts_dt"},
}};

constexpr bool ends_every_run(Guard guard) { return guard < Guard::depth; }
constexpr std::size_t index_of(Guard guard) { return static_cast<std::size_t>(guard); }

}  // namespace

bool Guards::watches(Guard guard) const noexcept {
  return ends_every_run(guard) || (mode_ != GuardMode::silent && !told_[index_of(guard)]);
}

void Guards::find(Guard guard, const Finding& finding) {
  auto& found = findings_[index_of(guard)];
  if (watches(guard) && !found) {
    found = finding;
  }
}

void Guards::find_at(Guard guard, Finding finding, std::size_t point) {
  if (watches(guard) && !findings_[index_of(guard)]) {
    const NodeName name = name_of_node(equations_->line().structure(), point);
    finding.node = static_cast<double>(name.node);
    finding.x = name.x;
    find(guard, finding);
  }
}

void Guards::see(const JudgedStep& step) {
  if (const std::size_t first = first_not_finite(step.after); first < step.after.size()) {
    find_at(Guard::finite, {.time = step.time}, first % equations_->points().points());
  }
  if (equations_->filtered() && equations_->line_contact() != nullptr) {
    see_line(step);
  } else {
    see_masses(step);
  }
  see_impacts();
}

/// Of the smallest gap of the run so far this rank has had its say when it was found.
void Guards::see_line(const JudgedStep& step) {
  const LineGap& gap = contact_->local_line_gap();
  if (gap.point >= 0 && std::ranges::none_of(contact_->supports(), &Support::elastic)) {
    see_depth(step, -gap.gap, static_cast<std::size_t>(gap.point));
  }
}

void Guards::see_masses(const JudgedStep& step) {
  const double least = kDepth * scale_.length;
  for (const ContactSet& set : sets_) {
    const double lift = set.lift(step.time, step.begin).height;
    for (std::size_t node = set.first; node < set.last && !set.elastic(); ++node) {
      const double depth = -set.side * (step.after[node] - set.height(node) - lift);
      if (!(depth <= least)) {
        see_depth(step, depth, node);
      }
    }
  }
}

void Guards::see_depth(const JudgedStep& step, double depth, std::size_t point) {
  double most = kFallenThrough * scale_.length;
  double tolerated = std::max(kDepth, step.tolerance) * scale_.length;
  if (step.late) {  // it may leave a mass below a support by the way it had in a step, where it then stays
    const std::size_t count = step.after.size() / 2;
    const double before = std::abs(step.before[count + point]);
    fastest_ = std::max({fastest_, before, std::abs(step.after[count + point])});
    most = std::max(most, (step.time - step.begin) * before);
    tolerated += (step.time - step.begin) * fastest_;
  }
  if (!(depth <= most)) {
    find_at(Guard::fall, {.time = step.time, .value = depth, .limit = most}, point);
  } else if (!(depth <= tolerated)) {
    find_at(Guard::depth, {.time = step.time, .value = depth, .limit = tolerated}, point);
  }
}

void Guards::see_impacts() {
  for (const ImpactRecord& impact : contact_->journal().impacts()) {
    const double turned =
        std::abs(impact.impulse) * (std::abs(impact.velocity_before) + std::abs(impact.velocity_after));
    const double limit = kGainRounding * (energy_ + turned);
    if (!(impact.energy_loss >= -limit)) {
      find_at(Guard::impact_gain, {.time = impact.time, .value = -impact.energy_loss, .limit = limit},
              static_cast<std::size_t>(impact.node - equations_->points().begin()));
    }
  }
}

void Guards::see(const JudgedRow& row) {
  const double drift = row.now.drift();
  if (!std::isfinite(drift)) {
    find(Guard::finite_energy, {.time = row.time});
    for (const auto* values : {&row.masses.position, &row.masses.velocity}) {
      if (const std::size_t first = first_not_finite(*values); first < values->size()) {
        find_at(Guard::finite, {.time = row.time}, first % equations_->points().points());
      }
    }
    return;
  }
  energy_ = row.now.scale;
  if (!(std::abs(drift) <= kUnstable)) {
    find(Guard::unstable, {.time = row.time, .value = drift, .limit = kUnstable});
  } else if (!(std::abs(drift) <= kDrift)) {
    find(Guard::drift, {.time = row.time, .value = drift, .limit = kDrift});
  }
  const double gain = std::max(kGainRounding, row.tolerance) * energy_;
  const auto judge = [&](Guard guard, double before, double now) {
    if (!(now - before >= -gain)) {
      find(guard, {.time = row.time, .value = before - now, .limit = gain});
    }
  };
  judge(Guard::damper_gain, row.before.lost_in_dampers, row.now.lost_in_dampers);
  judge(Guard::loss_gain, row.before.lost_in_impacts, row.now.lost_in_impacts);
}

double Guards::waiting() const noexcept {
  return std::ranges::any_of(findings_, [](const auto& finding) { return finding.has_value(); }) ? 1.0 : 0.0;
}

/// The gravest of all ranks, the first in time of those alike, until there is no more.
void Guards::tell(double ranks) {
  const MPI_Comm comm = equations_->points().comm();
  while (ranks > 0.0) {
    struct Told {
      double guard = kGuards;
      Finding finding{};
    } own;
    const auto found = std::ranges::find_if(findings_, [](const auto& finding) { return finding.has_value(); });
    if (found != findings_.end()) {
      own = {.guard = static_cast<double>(found - findings_.begin()), .finding = **found};
    }
    int size = 1;
    MPI_Comm_size(comm, &size);
    constexpr int kNumbers = sizeof(Told) / sizeof(double);
    std::vector<Told> all(static_cast<std::size_t>(size));
    MPI_Allgather(&own, kNumbers, MPI_DOUBLE, all.data(), kNumbers, MPI_DOUBLE, comm);
    const auto first = std::ranges::min_element(all, [](const Told& a, const Told& b) {
      return a.guard != b.guard ? a.guard < b.guard : a.finding.time < b.finding.time;
    });
    if (first->guard == kGuards) {
      return;
    }
    const auto guard = static_cast<std::size_t>(first->guard);
    findings_[guard].reset();
    told_[guard] = true;
    const std::string text = text_of(static_cast<Guard>(guard), first->finding, static_cast<int>(first - all.begin()));
    if (ends_every_run(static_cast<Guard>(guard)) || mode_ == GuardMode::stop) {
      throw SolveError{text};
    }
    petsc::warn(comm, "%s", text.c_str());
  }
}

std::string Guards::text_of(Guard guard, const Finding& finding, int rank) {
  const auto [words, unit, advice] = kWords[index_of(guard)];
  std::ostringstream text;
  text << words;
  if (unit != nullptr) {
    text << ' ' << finding.value << unit;
  }
  if (finding.node >= 0.0) {
    text << " at x = " << finding.x << " m, node " << static_cast<std::int64_t>(finding.node) << " on rank " << rank
         << ", t = " << finding.time << " s";
  } else {
    text << " at t = " << finding.time << " s";
  }
  if (unit != nullptr) {
    text << ", allowed " << finding.limit << unit;
  }
  text << "; " << advice;
  return text.str();
}

}  // namespace udar
