#include "io/gmsh_nodes.hpp"

#include <cstddef>
#include <sstream>
#include <unordered_set>

namespace udar::io {
namespace {

/// The lines of a file, section by section. Whatever is not as it should be ends the reading: PETSc says what.
class Scan {
 public:
  explicit Scan(const std::string& text) : lines_{text} {}

  std::string fault() {
    int binary = 1;
    if (!(next() >> head_) || head_ != "$MeshFormat" || !(next() >> version_ >> binary) || binary != 0 ||
        !(blocks() || version_ == "2.2")) {
      return {};
    }
    return go_to("$Nodes") && nodes() && go_to("$Elements") ? elements() : fault_;
  }

 private:
  [[nodiscard]] bool blocks() const { return version_ == "4.1"; }

  std::istringstream& next() {
    std::string line;
    std::getline(lines_, line);
    line_.clear();
    line_.str(line);
    return line_;
  }

  bool go_to(const std::string& section) {
    while (lines_) {
      next() >> head_;
      if (head_ == section) {
        return true;
      }
    }
    return false;
  }

  /// How many lines are ahead: of all, or of the next of some blocks. @param before numbers of the line before that one
  std::size_t count(int before) {
    long skipped = 0;
    std::size_t count = 0;
    std::istringstream& line = next();
    for (int i = 0; i < before; ++i) {
      line >> skipped;
    }
    return line >> count ? count : 0;
  }

  bool nodes() {
    const std::size_t all = count(0);  // nodes, or blocks of them
    for (std::size_t block = 0; block < (blocks() ? all : 1) && fault_.empty(); ++block) {
      const std::size_t here = blocks() ? count(3) : all;
      for (std::size_t i = 0; i < here && fault_.empty() && lines_; ++i) {
        add_node();
      }
      for (std::size_t i = 0; blocks() && i < here && lines_; ++i) {
        next();  // places
      }
    }
    return fault_.empty();
  }

  void add_node() {
    long number = 0;
    if (next() >> number && !nodes_.insert(number).second) {
      fault_ = "node " + std::to_string(number) + " is given twice";
    }
  }

  std::string elements() {
    const std::size_t all = count(0);
    for (std::size_t block = 0; block < (blocks() ? all : 1); ++block) {
      const std::size_t here = blocks() ? count(3) : all;
      for (std::size_t i = 0; i < here && lines_ && fault_.empty(); ++i) {
        check_element();
      }
    }
    return fault_;
  }

  void check_element() {
    long element = 0;
    std::istringstream& line = next();
    line >> element;
    if (!blocks()) {
      long type = 0;
      long tags = 0;
      line >> type >> tags;
      for (long tag = 0; tags > 0 && line >> tag; --tags) {
      }
    }
    for (long node = 0; line >> node;) {
      if (!nodes_.contains(node)) {
        fault_ = "element " + std::to_string(element) + " has node " + std::to_string(node) +
                 ", which is not among the nodes";
      }
    }
  }

  std::istringstream lines_;
  std::istringstream line_;
  std::string head_;
  std::string version_;
  std::unordered_set<long> nodes_;
  std::string fault_;
};

}  // namespace

std::string fault_of_nodes(const std::string& text) { return Scan{text}.fault(); }

}  // namespace udar::io
