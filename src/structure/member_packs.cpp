#include "udar/structure/member_packs.hpp"

#include <algorithm>

namespace udar {
namespace {

constexpr std::size_t kLanes = MemberPack::kLanes;
/// Elements of a span, at least.
constexpr std::size_t kShortest = 32;
/// What a cut costs, in nodes of a lane.
constexpr double kCutNodes = 16.0;
/// How much longer spans take that share no tables: 1.4 with 1000 elements, 2.7 with 100 000.
constexpr double kOwnTables = 2.0;
/// What cuts must save at least.
constexpr double kWorth = 0.85;

std::size_t rounded_up(std::size_t value, std::size_t to) { return (value + to - 1) / to; }

/// What a solve of so many members costs, in nodes of a lane.
double cost_of(const MemberCut& cut, std::size_t elements, std::size_t members) {
  const std::size_t full = elements / cut.length;  // spans
  const std::size_t rest = elements % cut.length;
  const std::size_t lanes =
      kLanes * (rounded_up(members * full, kLanes) * cut.length + (rest > 0 ? rounded_up(members, kLanes) * rest : 0));
  return static_cast<double>(lanes) + kCutNodes * static_cast<double>(members * (cut.spans - 1));
}

MemberCut cut_of(const MemberPacks::Kind& kind) {
  const std::size_t elements = kind.elements;
  const std::size_t members = kind.members.size();
  const MemberCut whole{.length = elements, .spans = 1};
  MemberCut best = whole;
  if (members == 0) {
    return best;
  }
  double least = kWorth * cost_of(whole, elements, members);
  for (const std::size_t spans : {std::size_t{2}, std::size_t{4}, kLanes}) {
    if (elements / spans < kShortest) {
      continue;
    }
    const std::size_t length = elements / spans;
    const MemberCut cut{.length = length, .spans = rounded_up(elements, length)};
    if (const double cost = (kind.equal ? 1.0 : kOwnTables) * cost_of(cut, elements, members); cost < least) {
      best = cut;
      least = cost;
    }
  }
  return best;
}

}  // namespace

MemberPacks::MemberPacks(std::span<const Kind> kinds, std::size_t members, std::size_t first) : standing_(members) {
  for (const Kind& kind : kinds) {
    cuts_.push_back(cut_of(kind));
    for (const std::size_t member : kind.members) {
      standing_[member] = {.first_cut = first + cut_nodes_, .first_span = spans_.size()};
      spans_.resize(spans_.size() + cuts_.back().spans);
      cut_nodes_ += cuts_.back().spans - 1;
    }
  }
  std::size_t next = first + cut_nodes_;
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    const std::size_t elements = kinds[kind].elements;
    const MemberCut& cut = cuts_[kind];
    std::vector<std::array<std::size_t, 2>> full;  // member, span
    std::vector<std::array<std::size_t, 2>> last;
    for (const std::size_t member : kinds[kind].members) {
      for (std::size_t span = 0; span < cut.spans; ++span) {
        ((span + 1) * cut.length <= elements ? full : last).push_back({member, span});
      }
    }
    add_packs(kind, cut.length, full, next);
    add_packs(kind, elements % cut.length, last, next);
  }
}

void MemberPacks::add_packs(std::size_t kind, std::size_t elements, std::span<const std::array<std::size_t, 2>> lanes,
                            std::size_t& next) {
  for (; !lanes.empty(); lanes = lanes.subspan(std::min(kLanes, lanes.size()))) {
    MemberPack pack{.kind = kind, .elements = elements, .first = next, .lanes = std::min(kLanes, lanes.size())};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const auto& [member, span] = lanes[std::min(lane, pack.lanes - 1)];
      pack.member.at(lane) = member;
      pack.span.at(lane) = span;
      if (lane < pack.lanes) {
        spans_[standing_[member].first_span + span] = {.first = next + lane, .stride = pack.lanes};
      }
    }
    next += (elements - 1) * pack.lanes;
    packs_.push_back(pack);
  }
}

std::size_t MemberPacks::node(std::size_t member, std::size_t kind, std::size_t number) const {
  const std::size_t length = cuts_[kind].length;
  const auto& [first_cut, first_span] = standing_[member];
  if (number % length == 0) {
    return first_cut + number / length - 1;
  }
  const auto& [first, stride] = spans_[first_span + number / length];
  return first + (number % length - 1) * stride;
}

}  // namespace udar
