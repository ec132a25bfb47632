#pragma once
/// @file
/// How the inner nodes of a rank's members stand in memory: eight members, or eight spans of long ones, side by side.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace udar {

/// @brief Members of one kind, or equally long spans of them, whose inner nodes stand side by side: inner node i = 0,
/// 1, ... of lane l, counted from its first end, is at `first` + i * `lanes` + l. Those of one element have none.
struct MemberPack {
  static constexpr std::size_t kLanes = 8;

  std::size_t kind = 0;
  std::size_t elements = 1;                  ///< of a lane
  std::size_t first = 0;                     ///< local node
  std::size_t lanes = 0;                     ///< members or spans, at most `kLanes`
  std::array<std::size_t, kLanes> member{};  ///< of the network; those behind the last are it again
  std::array<std::size_t, kLanes> span{};    ///< of the member, from its first end
};

/// @brief How the members of a kind are cut into spans for the solver: of as many elements each, but for the last one.
struct MemberCut {
  std::size_t length = 1;  ///< elements of a span
  std::size_t spans = 1;   ///< 1: whole
};

/// @brief The packs of a rank. Few members of a kind are cut where that fills more lanes; the nodes where they are cut,
/// one after the other by member, are before all packs.
class MemberPacks {
 public:
  /// A rank's members of a kind, and how many elements they have; spans of unequal ones share no tables.
  struct Kind {
    std::size_t elements = 1;
    std::vector<std::size_t> members{};
    bool equal = true;
  };

  MemberPacks() = default;
  /// @param members of the network, of all ranks @param first local node behind those of junctions
  MemberPacks(std::span<const Kind> kinds, std::size_t members, std::size_t first);

  [[nodiscard]] const std::vector<MemberPack>& packs() const noexcept { return packs_; }
  [[nodiscard]] const MemberCut& cut(std::size_t kind) const { return cuts_[kind]; }
  [[nodiscard]] std::size_t cut_nodes() const noexcept { return cut_nodes_; }  ///< of all members of the rank
  /// Local node of an inner node, counted from 1, of a member of this rank and its kind.
  [[nodiscard]] std::size_t node(std::size_t member, std::size_t kind, std::size_t number) const;

 private:
  /// Where the inner nodes of a span stand.
  struct InnerNodes {
    std::size_t first = 0;
    std::size_t stride = 0;
  };
  struct Standing {
    std::size_t first_cut = 0;   // node
    std::size_t first_span = 0;  // of `spans_`
  };
  void add_packs(std::size_t kind, std::size_t elements, std::span<const std::array<std::size_t, 2>> lanes,
                 std::size_t& next);

  std::vector<MemberPack> packs_;
  std::vector<MemberCut> cuts_;
  std::vector<Standing> standing_;  // by member of the network
  std::vector<InnerNodes> spans_;
  std::size_t cut_nodes_ = 0;
};

}  // namespace udar
