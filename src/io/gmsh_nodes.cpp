#include "io/gmsh_nodes.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "io/input_file.hpp"
#include "io/text_fields.hpp"

namespace udar::io {
namespace {

/// What Gmsh calls an element by a number, up to hexahedra of second order.
struct ElementType {
  int number;
  int dimension;
  int nodes;
};
constexpr std::array<ElementType, 18> kElementTypes{{{1, 1, 2},
                                                     {2, 2, 3},
                                                     {3, 2, 4},
                                                     {4, 3, 4},
                                                     {5, 3, 8},
                                                     {6, 3, 6},
                                                     {7, 3, 5},
                                                     {8, 1, 3},
                                                     {9, 2, 6},
                                                     {10, 2, 9},
                                                     {11, 3, 10},
                                                     {12, 3, 27},
                                                     {15, 0, 1},
                                                     {16, 2, 8},
                                                     {17, 3, 20},
                                                     {26, 1, 4},
                                                     {27, 1, 5},
                                                     {28, 1, 6}}};

/// Reads a file word by word, as PETSc does, which takes what it says for granted. Throws Complaint.
class Scan {
 public:
  explicit Scan(std::string_view text) : left_{text} {}

  void read() {
    expect("$MeshFormat");
    const std::string_view version = word();
    if ((version != "4.1" && version != "2.2") || word() != "0") {
      return;  // binary, or of a version that is left to PETSc
    }
    require(left_.find('\0') == std::string_view::npos, "a zero byte in a text");
    blocks_ = version == "4.1";
    static_cast<void>(word());  // bytes of a number
    expect("$EndMeshFormat");
    std::string_view section = word();
    if (section == "$PhysicalNames") {
      names();
      section = word();
    }
    if (section == "$Entities" && blocks_) {
      entities();
      section = word();
    }
    require(section == "$Nodes", "'" + std::string{section.substr(0, kShown)} + "' stands where $Nodes should");
    blocks_ ? node_blocks() : node_list();
    expect("$EndNodes");
    expect("$Elements");
    blocks_ ? element_blocks() : element_list();
    expect("$EndElements");
    require_straight_lines();
  }

 private:
  static constexpr std::size_t kShown = 40;
  static constexpr std::string_view kBlanks = " \t\r\n\v\f";

  [[noreturn]] static void fail(const std::string& what) { throw Complaint{what}; }
  static void require(bool good, const std::string& what) {
    if (!good) {
      fail("no Gmsh mesh: " + what);
    }
  }

  std::string_view word() {
    left_.remove_prefix(std::min(left_.size(), left_.find_first_not_of(kBlanks)));
    const std::string_view found = left_.substr(0, left_.find_first_of(kBlanks));
    left_.remove_prefix(found.size());
    return found;
  }

  void expect(std::string_view mark) {
    const std::string_view found = word();
    require(found == mark, found.empty() ? "it ends before " + std::string{mark}
                                         : "'" + std::string{found.substr(0, kShown)} + "' stands where " +
                                               std::string{mark} + " should");
  }

  template <class Number>
  Number number() {
    const std::string_view found = word();
    Number value{};
    const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), value);
    require(error == std::errc{} && end == found.data() + found.size() && !found.empty(),
            found.empty() ? "it ends early" : "'" + std::string{found.substr(0, kShown)} + "' is not a number here");
    return value;
  }
  int whole() { return number<int>(); }
  /// Of words that follow: there cannot be more than the file is long.
  std::size_t count() {
    const int value = whole();
    require(value >= 0 && static_cast<std::size_t>(value) <= left_.size(),
            "a count of " + std::to_string(value) + " is not that of what follows");
    return static_cast<std::size_t>(value);
  }
  void numbers(std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      require(std::isfinite(number<double>()), "a coordinate is not a finite number");
    }
  }
  void wholes(std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      static_cast<void>(whole());
    }
  }
  int dimension() {
    const int value = whole();
    require(value >= 0 && value <= 3, "a dimension of " + std::to_string(value));
    return value;
  }

  void names() {
    constexpr std::size_t kLongest = 127;  // what Gmsh and PETSc have room for
    const std::size_t all = count();
    for (std::size_t i = 0; i < all; ++i) {
      static_cast<void>(dimension());
      static_cast<void>(whole());
      const std::string_view line = left_.substr(0, left_.find('\n'));
      const std::string_view name = trimmed(line);
      require(name.size() > 2 && name.size() <= kLongest && name.front() == '"' && name.find('"', 1) + 1 == name.size(),
              "the name of a physical group is not between two quotes, or longer than 125 letters");
      require(line.starts_with(" \""), "the name of a physical group does not follow its number after one blank");
      left_.remove_prefix(line.size());
    }
    expect("$EndPhysicalNames");
  }

  void entities() {
    std::array<std::size_t, 4> counts{};
    for (std::size_t& of_dimension : counts) {
      of_dimension = count();
    }
    for (std::size_t of = 0; of < counts.size(); ++of) {
      for (std::size_t i = 0; i < counts.at(of); ++i) {
        entities_.emplace(static_cast<int>(of), whole());
        numbers(of == 0 ? 3 : 6);  // its place, or its box
        wholes(tags());
        if (of > 0) {
          wholes(count());  // what bounds it
        }
      }
    }
    expect("$EndEntities");
  }

  /// That a block belongs to. @return its dimension
  int entity() {
    const int of = dimension();
    const int number = whole();
    require(entities_.contains({of, number}),
            "entity " + std::to_string(number) + " of dimension " + std::to_string(of) + " is not among the entities");
    return of;
  }

  std::size_t tags() {
    constexpr std::size_t kMost = 16;
    const std::size_t size = count();
    require(size <= kMost, std::to_string(size) + " tags of one thing");
    return size;
  }

  void node_list() {
    const std::size_t all = count();
    for (std::size_t i = 0; i < all; ++i) {
      add_node();
      numbers(3);
    }
    judge_range();
  }

  void node_blocks() {
    const std::size_t blocks = count();
    const std::size_t all = count();
    const int least = whole();
    const int largest = whole();
    std::size_t found = 0;
    for (std::size_t block = 0; block < blocks; ++block) {
      entity();
      require(whole() == 0, "nodes with parameters");
      const std::size_t here = count();
      for (std::size_t i = 0; i < here; ++i) {
        add_node();
      }
      numbers(3 * here);
      found += here;
    }
    require(found == all, std::to_string(found) + " nodes where " + std::to_string(all) + " are announced");
    require(nodes_.empty() || (least == least_ && largest == largest_),
            "node numbers are not from " + std::to_string(least) + " to " + std::to_string(largest));
    judge_range();
  }

  void add_node() {
    const int number = whole();
    require(number > 0, "a node of the number " + std::to_string(number));
    if (!nodes_.insert(number).second) {
      fail("node " + std::to_string(number) + " is given twice");
    }
    least_ = std::min(least_, number);
    largest_ = std::max(largest_, number);
  }

  /// PETSc keeps a list from the least to the largest number.
  void judge_range() const {
    constexpr std::size_t kAnyway = 1000000;
    constexpr std::size_t kPerNode = 1000;
    require(static_cast<std::size_t>(largest_) <= kAnyway + kPerNode * nodes_.size(),
            "a node of the number " + std::to_string(largest_) + " among " + std::to_string(nodes_.size()));
  }

  void element_list() {
    const std::size_t all = count();
    for (std::size_t i = 0; i < all; ++i) {
      const int element = whole();
      const ElementType type = element_type();
      wholes(tags());
      nodes_of(element, type);
    }
  }

  void element_blocks() {
    const std::size_t blocks = count();
    const std::size_t all = count();
    wholes(2);
    std::size_t found = 0;
    for (std::size_t block = 0; block < blocks; ++block) {
      const int dimension = entity();
      const ElementType type = element_type();
      require(type.dimension == dimension, "elements of type " + std::to_string(type.number) +
                                               " in an entity of dimension " + std::to_string(dimension));
      const std::size_t here = count();
      for (std::size_t i = 0; i < here; ++i) {
        nodes_of(whole(), type);
      }
      found += here;
    }
    require(found == all, std::to_string(found) + " elements where " + std::to_string(all) + " are announced");
  }

  ElementType element_type() {
    const int number = whole();
    const auto* const known = std::ranges::find(kElementTypes, number, &ElementType::number);
    require(known != kElementTypes.end(), "elements of type " + std::to_string(number));
    dimension_ = std::max(dimension_, known->dimension);
    curved_ = curved_ || (known->dimension == 1 && known->nodes > 2);
    return *known;
  }

  /// Whatever else there is PETSc would read as well as it can.
  void require_straight_lines() const {
    if (dimension_ > 1) {
      fail("it has elements of dimension " + std::to_string(dimension_) +
           ", expected a mesh of lines, of dimension 1; save these alone");
    }
    if (curved_) {
      fail("it has lines of higher order, expected straight ones of order 1: two nodes each");
    }
  }

  void nodes_of(int element, const ElementType& type) {
    for (int i = 0; i < type.nodes; ++i) {
      const int node = whole();
      if (!nodes_.contains(node)) {
        fail("element " + std::to_string(element) + " has node " + std::to_string(node) +
             ", which is not among the nodes");
      }
    }
  }

  std::string_view left_;
  bool blocks_ = false;
  int dimension_ = 0;                       ///< the largest of the elements
  bool curved_ = false;                     ///< some line has more than two nodes
  std::set<std::pair<int, int>> entities_;  ///< dimension, number
  std::unordered_set<int> nodes_;
  int least_ = std::numeric_limits<int>::max();
  int largest_ = 0;
};

}  // namespace

std::string fault_of_mesh(const std::string& text) {
  try {
    Scan{text}.read();
  } catch (const Complaint& complaint) {
    return complaint.text;
  }
  return {};
}

}  // namespace udar::io
