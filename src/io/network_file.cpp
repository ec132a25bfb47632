#include "udar/io/network_file.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "io/input_file.hpp"
#include "io/line_mesh.hpp"
#include "io/network_keys.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/member_shape.hpp"

namespace udar::io {
namespace {

/// One file; what it says of a mesh may be of one that another file is.
class NetworkReader {
 public:
  NetworkReader(MPI_Comm comm, const std::string& quantity, std::string path, AcceptSize accept)
      : comm_{comm},
        path_{std::move(path)},
        accept_{std::move(accept)},
        document_{quantity + ": '" + path_ + "'", share_file(comm_, quantity, path_), "junctions: [...]"},
        root_{document_, document_.map(), "network"} {}

  /// @param mesh file, empty: what the file at hand names, if it names one
  NetworkParameters read(const std::string& mesh) {
    for (YamlThing& thing : root_.things("sections", "section")) {
      add_section(thing);
    }
    if (network_.sections.empty()) {
      root_.miss("sections");
    }
    std::string named = mesh;
    if (named.empty()) {
      const auto given = root_.text("mesh");
      named = given ? given->value : "";
    }
    if (!named.empty()) {
      read_mesh(named);
    } else {
      read_frame();
    }
    root_.finish();
    return std::move(network_);
  }

 private:
  void add_section(YamlThing& thing) {
    const auto name = thing.name();
    sections_.add(thing, name);
    network_.sections.push_back(read_section(thing));
    network_.sections.back().name = name.value;
    thing.finish();
  }

  void read_frame() {
    std::vector<JunctionKeys> junctions;
    std::vector<MemberKeys> members;
    for (YamlThing& thing : root_.things("junctions", "junction")) {
      add_junction(thing, junctions);
    }
    for (YamlThing& thing : root_.things("members", "member")) {
      add_member(thing, members);
    }
    std::vector<JunctionKeys> of_junctions(junctions.size());  // what groups say
    std::vector<MemberKeys> of_members(members.size());
    for (YamlThing& thing : root_.things("groups", "group")) {
      read_group(thing, of_junctions, of_members);
    }
    for (std::size_t i = 0; i < junctions.size(); ++i) {
      fill(junctions[i], of_junctions[i]);
      apply(network_.junctions[i], junctions[i]);
    }
    for (std::size_t i = 0; i < members.size(); ++i) {
      fill(members[i], of_members[i]);
      settle(network_.members[i], members[i], marks_[i]);
    }
    accept_size();
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (members[i].grading) {
        network_.members[i].spacing = graded_spacing(network_.members[i].elements, members[i].grading->value);
      }
    }
  }

  void accept_size() const {
    if (accept_) {
      accept_(network_);
    }
  }

  void add_junction(YamlThing& thing, std::vector<JunctionKeys>& keys) {
    const auto name = thing.name();
    junctions_.add(thing, name);
    const auto place = read_place(thing, "place");
    if (!place) {
      thing.miss("place [x, y, z] [m]");
    }
    network_.junctions.push_back({.name = name.value, .place = place->value});
    keys.push_back(read_junction_keys(thing));
    thing.finish();
  }

  void add_member(YamlThing& thing, std::vector<MemberKeys>& keys) {
    const auto name = thing.text("name");
    thing.call(name ? name->value : std::to_string(network_.members.size() + 1));
    if (name) {
      members_.add(thing, *name);
    } else {
      members_.add(thing, {"member " + std::to_string(network_.members.size() + 1), thing.mark()});
    }
    Member member;
    for (std::size_t end = 0; end < 2; ++end) {
      const char* key = end == 0 ? "from" : "to";
      const auto junction = thing.text(key);
      if (!junction) {
        thing.miss(std::string{key} + ", a junction");
      }
      member.ends.at(end).junction = junctions_.find(thing, *junction);
    }
    const auto junction = [&](std::size_t end) { return network_.junctions[member.ends.at(end).junction].name; };
    if (member.ends[0].junction == member.ends[1].junction) {
      thing.refuse(thing.mark(), "goes from junction '" + junction(0) + "' to itself");
    }
    member.name = name ? name->value : junction(0) + " to " + junction(1);
    keys.push_back(read_member_keys(thing, sections_, false));
    thing.finish();
    network_.members.push_back(std::move(member));
    marks_.push_back(thing);
  }

  void read_group(YamlThing& thing, std::vector<JunctionKeys>& of_junctions, std::vector<MemberKeys>& of_members) {
    static_cast<void>(thing.name());
    const auto members = thing.words("members");
    const auto junctions = thing.words("junctions");
    if (!members && !junctions) {
      thing.miss("members and no junctions");
    }
    if (members) {
      const MemberKeys keys = read_member_keys(thing, sections_, false);
      for (const Given<std::string>& name : *members) {
        add_group(of_members[members_.find(thing, name)], keys, thing);
      }
    }
    if (junctions) {
      const JunctionKeys keys = read_junction_keys(thing);
      for (const Given<std::string>& name : *junctions) {
        add_group(of_junctions[junctions_.find(thing, name)], keys, thing);
      }
    }
    thing.finish();
  }

  void settle(Member& member, const MemberKeys& keys, const YamlThing& thing) {
    if (!keys.section && network_.sections.size() > 1) {
      thing.miss("section, neither by itself nor by a group");
    }
    apply(member, keys);
    if (!keys.division) {
      thing.miss("elements, element_length [m] or element_lengths [m], neither by itself nor by a group");
    }
    const auto& [elements, length, lengths] = keys.division->value;
    constexpr double kMost = 1e9;
    if (static_cast<double>(elements) > kMost) {
      thing.refuse(keys.division->mark, "elements: more than 1e9 are not allowed");
    }
    member.elements = elements;
    if (length > 0.0) {
      constexpr double kWhole = 1e-9;  // of an element: decimal fractions that rounding has touched
      const double parts = length_of(member) / length;
      if (!(parts < kMost)) {
        thing.refuse(keys.division->mark, "element_length: it makes more than 1e9 elements");
      }
      member.elements = static_cast<std::size_t>(std::max(1.0, std::ceil(parts * (1.0 - kWhole))));
    } else if (!lengths.empty()) {
      require_whole(member, lengths, keys.division->mark, thing);
      member.spacing = lengths;
    }
    if (keys.grading && (length > 0.0 || !lengths.empty() || elements < 2)) {
      thing.refuse(keys.grading->mark, "grading needs elements, a whole number >= 2");
    }
  }

  /// Whether given lengths of elements are those of a member.
  void require_whole(const Member& member, std::span<const double> lengths, const YAML::Mark& mark,
                     const YamlThing& thing) const {
    constexpr double kSame = 1e-6;  // of the length: they may be typed
    const double sum = std::accumulate(lengths.begin(), lengths.end(), 0.0);
    const double length = length_of(member);
    if (!(std::abs(sum - length) <= kSame * length)) {
      std::ostringstream text;
      text << "element_lengths: their sum of " << sum << " m is not allowed, expected the member's length of " << length
           << " m";
      thing.refuse(mark, text.str());
    }
  }

  [[nodiscard]] double length_of(const Member& member) const {
    const auto& [from, to] = member.ends;
    const Place& a = network_.junctions[from.junction].place;
    const Place& b = network_.junctions[to.junction].place;
    return std::hypot(b.x + to.offset.x - a.x - from.offset.x, b.y + to.offset.y - a.y - from.offset.y,
                      b.z + to.offset.z - a.z - from.offset.z);
  }

  /// What the file says of the groups of a mesh.
  struct MeshGroups {
    std::vector<std::optional<MemberKeys>> curves;
    std::vector<std::optional<JunctionKeys>> points;
  };

  void read_mesh(const std::string& file) {
    const LineMesh mesh = read_gmsh(comm_, "network file", file, path_);
    MeshGroups groups{.curves = std::vector<std::optional<MemberKeys>>(mesh.curves.size()),
                      .points = std::vector<std::optional<JunctionKeys>>(mesh.points.size())};
    for (YamlThing& thing : root_.things("groups", "group")) {
      read_mesh_group(thing, file, mesh, groups);
    }
    for (std::size_t i = 0; i < mesh.curves.size(); ++i) {
      require_group(groups.curves[i].has_value(), "curves", mesh.curves[i], file);
      if (!groups.curves[i]->section && network_.sections.size() > 1) {
        root_.refuse(root_.mark(), "group '" + mesh.curves[i] + "' has no section");
      }
    }
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      require_group(groups.points[i].has_value(), "points", mesh.points[i], file);
    }
    build(mesh, groups);
  }

  void require_group(bool given, const char* of, const std::string& name, const std::string& file) const {
    if (!given) {
      root_.refuse(root_.mark(), "'" + file + "' has " + of + " in the physical group '" + name +
                                     "', and there is no group of this name; add - {name: " + name + ", ...}");
    }
  }

  void read_mesh_group(YamlThing& thing, const std::string& file, const LineMesh& mesh, MeshGroups& groups) {
    const auto name = thing.name();
    const auto number = [&](const std::vector<std::string>& names) {
      return static_cast<std::size_t>(std::ranges::find(names, name.value) - names.begin());
    };
    const std::size_t curve = number(mesh.curves);
    const std::size_t point = number(mesh.points);
    const bool of_curves = curve < mesh.curves.size();
    const bool of_points = point < mesh.points.size();
    if (!of_curves && !of_points) {
      std::string all;
      for (const std::vector<std::string>& names : {mesh.curves, mesh.points}) {
        for (const std::string& other : names) {
          all += (all.empty() ? "" : ", ") + other;
        }
      }
      thing.refuse(name.mark, "'" + file + "' has no physical group of this name, it has " + all);
    }
    if ((of_curves && groups.curves[curve]) || (of_points && groups.points[point])) {
      thing.refuse(name.mark, "there is another group of this name");
    }
    if (of_curves) {
      groups.curves[curve] = read_member_keys(thing, sections_, true);
    }
    if (of_points) {
      groups.points[point] = read_junction_keys(thing);
    }
    thing.finish();
  }

  void build(const LineMesh& mesh, const MeshGroups& groups) {
    std::vector<std::size_t> junction_of(mesh.nodes.size(), LineMesh::kNone);
    std::vector<std::size_t> used(mesh.points.size());  // of each group so far, to number its junctions
    std::vector<std::size_t> all(mesh.points.size());
    for (const std::size_t group : mesh.node_group) {
      if (group != LineMesh::kNone) {
        ++all[group];
      }
    }
    const std::vector<StraightRun> runs = straight_runs(mesh);
    for (const StraightRun& run : runs) {
      junction_of[run.from] = 0;
      junction_of[run.to] = 0;
    }
    for (std::size_t node = 0; node < mesh.nodes.size(); ++node) {
      if (junction_of[node] == LineMesh::kNone) {
        continue;
      }
      junction_of[node] = network_.junctions.size();
      Junction& junction = network_.junctions.emplace_back();
      junction.place = mesh.nodes[node];
      if (const std::size_t group = mesh.node_group[node]; group != LineMesh::kNone) {
        junction.name = mesh.points[group];
        if (all[group] > 1) {
          junction.name += " " + std::to_string(++used[group]);
        }
        apply(junction, *groups.points[group]);
      } else {
        std::ostringstream name;
        name << "(" << junction.place.x << " " << junction.place.y << " " << junction.place.z << ")";
        junction.name = name.str();
      }
    }
    std::vector<std::size_t> count(mesh.curves.size());
    for (const StraightRun& run : runs) {
      Member& member = network_.members.emplace_back();
      member.name = mesh.curves[run.group] + " " + std::to_string(++count[run.group]);
      member.ends[0].junction = junction_of[run.from];
      member.ends[1].junction = junction_of[run.to];
      member.elements = run.elements;
      member.spacing = run.lengths;
      apply(member, *groups.curves[run.group]);
    }
    accept_size();
  }

  MPI_Comm comm_;
  std::string path_;
  AcceptSize accept_;
  petsc::YamlDocument document_;
  YamlThing root_;
  NetworkParameters network_;
  NameTable sections_{"section"};
  NameTable junctions_{"junction"};
  NameTable members_{"member"};
  std::vector<YamlThing> marks_;  // of the members
};

}  // namespace

NetworkParameters read_network(MPI_Comm comm, const std::string& file, const std::string& groups,
                               const AcceptSize& accept) {
  const auto ends_in = [&](const char* end) { return file.ends_with(end); };
  if (ends_in(".msh")) {
    if (groups.empty()) {
      throw InputError{"network groups: the mesh '" + file +
                       "' needs them, a YAML file with sections and what each physical group means"};
    }
    return NetworkReader{comm, "network groups", groups, accept}.read(file);
  }
  if (!ends_in(".yaml") && !ends_in(".yml")) {
    throw InputError{"network file: '" + file + "' is not allowed, expected a name that ends in .yaml, .yml or .msh"};
  }
  if (!groups.empty()) {
    throw InputError{"network groups: '" + groups + "' is not allowed with '" + file +
                     "', expected it with a mesh, whose name ends in .msh"};
  }
  return NetworkReader{comm, "network file", file, accept}.read("");
}

}  // namespace udar::io
