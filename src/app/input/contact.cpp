#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <span>
#include <sstream>
#include <utility>

#include "app/input/contact_laws.hpp"
#include "app/input/readers.hpp"
#include "udar/contact/box.hpp"
#include "udar/io/height_field_file.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/structure/network_place.hpp"

namespace udar::app {
namespace {

using petsc::OptionGroup;

enum class Weighting { tributary, inclusive };

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr std::array kSides{Names<SupportSide>{"below", SupportSide::below},
                            Names<SupportSide>{"above", SupportSide::above}};
constexpr std::array kSurfaces{Names<ContactSurface>{"mass", ContactSurface::mass},
                               Names<ContactSurface>{"line", ContactSurface::line}};
constexpr std::array kWeightings{Names<Weighting>{"tributary", Weighting::tributary},
                                 Names<Weighting>{"inclusive", Weighting::inclusive}};

/// @param turned whether heights count the other way
std::shared_ptr<const SupportMotion> read_motion(MPI_Comm comm, const std::string& path, bool turned) {
  const io::Table table =
      io::read_table(comm, "support motion", path, {.names = {"time [s]", "height [m]", "velocity [m/s]"}});
  require_ascending("-support_motion", path, column(table, 0), "times [s]");
  Numbers height = column(table, 1);
  Numbers velocity = table.columns > 2 ? column(table, 2) : Numbers{};
  for (Numbers* values : {&height, &velocity}) {
    std::ranges::transform(*values, values->begin(), [turned](double value) { return turned ? 0.0 - value : value; });
  }
  return std::make_shared<SupportMotion>(column(table, 0), std::move(height), std::move(velocity));
}

/// Of a face: along which axis the coordinates of nodes count it, and from which side the support pushes.
struct Facing {
  Place normal = kUp;
  bool turned = false;  ///< the face looks against `normal`
};

/// The unit vector of three numbers, turned so that its largest component is positive: nodes have one axis for both.
Facing facing(std::span<const double> given) {
  const double size = std::hypot(given[0], given[1], given[2]);
  if (!(size > 0.0) || !std::isfinite(size)) {
    std::ostringstream message;
    message << "option -support_normal: " << given[0] << ',' << given[1] << ',' << given[2]
            << " is not allowed, expected a direction, three numbers along x, y, z of which one is not 0";
    throw InputError{message.str()};
  }
  const auto largest = std::ranges::max_element(given, {}, [](double value) { return std::abs(value); });
  const double scale = std::copysign(size, *largest);
  // Adding 0 makes 0 of -0.
  return {.normal = {.x = given[0] / scale + 0.0, .y = given[1] / scale + 0.0, .z = given[2] / scale + 0.0},
          .turned = *largest < 0.0};
}

/// An option that takes a file for each of some things, or one for all.
struct FileList {
  const char* key;
  Strings paths{"none"};
  bool given = false;

  void read(OptionGroup& group, const char* text) { given = group.strings(key, paths, text); }
  void spread(std::size_t count, const char* per_thing) {
    if (given) {
      paths = petsc::one_per(key, paths, count, per_thing);
    }
  }
  /// Null: none of its own.
  [[nodiscard]] const std::string* operator[](std::size_t i) const {
    return given && paths[i] != "none" ? &paths[i] : nullptr;
  }
};

constexpr const char* kPerSupportOrGround = "one per support, floor or ground included";

/// What stands under the whole beam.
struct Ground {
  bool floor = false;
  double height = 0.0;  ///< [m]
  std::string file;     ///< of its profile; empty: a floor or nothing

  void read(OptionGroup& group) {
    group.boolean("-floor", floor, "a rigid floor under the whole beam");
    const bool height_given = group.real("-floor_height", height, "m", petsc::any(), "height of the floor above y = 0");
    group.string("-ground_profile", file,
                 "CSV file x [m], height [m]: an uneven ground under the whole beam in place of -floor; linear between "
                 "rows, constant outside");
    if (!file.empty() && (floor || height_given)) {
      throw InputError{"option -ground_profile: '" + file +
                       "' is not allowed together with -floor or -floor_height, expected one ground [m]"};
    }
  }
  [[nodiscard]] bool any() const { return floor || !file.empty(); }

  /// @param law its restitution, friction and yield speed
  [[nodiscard]] Support support(MPI_Comm comm, const Support& law) const {
    Support support = law;
    support.width = kInfinity;
    support.height = file.empty() ? height : 0.0;
    if (!file.empty()) {
      const io::Table table = io::read_table(comm, "ground profile", file, {.names = {"x [m]", "height [m]"}});
      require_ascending("-ground_profile", file, column(table, 0), "positions [m]");
      support.profile = {.x = column(table, 0), .height = column(table, 1)};
    }
    return support;
  }
};

/// What is given for each support, and of the impact law for the ground, too.
class SupportLists {
 public:
  void read_places(OptionGroup& group) {
    position_.read(group, "m", petsc::any(), "centres of the rigid supports");
    width_.read(group, "m", petsc::non_negative_or_infinite(),
                "width along x; 0: the nearest node alone; inf: all of it");
    weighting_.given = group.choice<Weighting>(
        "-support_weighting", weighting_.value, kWeightings,
        "what the nodes of a beam within a width carry: tributary, together the mass of the width at any mesh, "
        "or inclusive, each its whole lumped mass, edges included; those of other structures do the latter");
    height_.read(group, "m", petsc::any(), "height of the contact face above y = 0");
    side_given_ =
        group.choices<SupportSide>("-support_side", side_, kSides, "on which side of the beam the support stands");
  }

  void read_boxes(OptionGroup& group) {
    group.reals("-support_box", boxes_, "m", petsc::any(),
                "for networks: rigid boxes, six numbers each, from and to along x, y and z. Nodes touch the face they "
                "stand in front of; each face is a support after those of -support_position, with the entry of its box "
                "in the lists of restitution, friction and yield speed");
    if (boxes_.size() % kBoxNumbers != 0) {
      throw InputError{"option -support_box: " + std::to_string(boxes_.size()) +
                       " numbers are not allowed, expected six for each box, from and to along x, y and z [m]"};
    }
  }

  void read_facing(OptionGroup& group) {
    facing_given_ =
        group.reals("-support_normal", normal_, "-", petsc::any(),
                    "for networks: where the face looks, three numbers along x, y, z of any length, for each "
                    "support or all of them; -support_height counts along it from the origin");
    field_.read(
        group,
        "for networks: files of heights over x and z added to -support_height, one per -support_position, one "
        "for all; none: flat. A CSV file x, z, height [m] with a row for each point of a grid, or an ESRI ASCII "
        "grid, x to the east, z to the south; smooth between");
    for (NumberList* list : {&y_, &z_}) {
      list->read(group, "m", petsc::any(), "for networks: centre of what is touched, see -support_*_width");
    }
    for (NumberList* list : {&y_width_, &z_width_}) {
      list->read(group, "m", petsc::non_negative_or_infinite(), "for networks: what is touched; inf: wherever it is");
    }
  }

  void read_law(OptionGroup& group) {
    restitution_.read(group, "-", petsc::between(0.0, 1.0),
                      "restitution e in v+ = -e v-; one, or one per support (floor or ground after the last support)");
    friction_.read(
        group, "-", petsc::non_negative(),
        "for networks: Coulomb's coefficient of friction, of impacts and of masses that rest or press; one, or "
        "one per support (floor or ground after the last support); by -ts_type rk, then the default");
    yield_speed_.read(group, "m/s", petsc::positive_or_infinite(),
                      "impact speed v_y above which restitution falls, e (v / v_y)^(-1/4); one, or one per support "
                      "(floor or ground after the last support); inf: it does not");
  }

  void read_motion_and_springs(OptionGroup& group) {
    motion_.read(
        group,
        "CSV files time [s], height [m] added to -support_height and, if there is a third column, velocity [m/s], "
        "one per -support_position, one for all; none: at rest. Cubic between rows, at rest beside them; "
        "without velocities no height leaves the range of the two rows around it");
    stiffness_.read(group, "N/m", petsc::positive_or_infinite(),
                    "spring of a support, shared by the masses it touches; it only presses, on the line from the start "
                    "where -support_height is in the beam; inf: rigid");
    damping_.read(group, "N s/m", petsc::non_negative(),
                  "damper beside that spring, for all of the support; pressing alone; none on -contact_surface line");
  }

  /// One entry per support in each list, and one more of the impact law if there is a ground.
  void settle(bool ground) {
    for (NumberList* list : {&width_, &height_, &stiffness_, &damping_, &y_, &z_, &y_width_, &z_width_}) {
      if (count() > 0 || list->given) {
        list->spread(count(), kPerSupport);
      }
    }
    if (count() > 0 || side_given_) {
      side_ = petsc::one_per("-support_side", side_, count(), kPerSupport);
    }
    if (facing_given_ && (count() == 0 || (normal_.size() != 3 && normal_.size() != 3 * count()))) {
      throw InputError{"option -support_normal: " + std::to_string(normal_.size()) + " numbers for " +
                       std::to_string(count()) +
                       " supports are not allowed, expected three for each -support_position, or three for all"};
    }
    motion_.spread(count(), kPerSupport);
    field_.spread(count(), kPerSupport);
    if (const std::size_t all = count() + boxes() + (ground ? 1 : 0); all > 0) {
      restitution_.spread(all, kPerSupportOrGround);
      yield_speed_.spread(all, kPerSupportOrGround);
      friction_.spread(all, kPerSupportOrGround);
    }
  }

  /// Forces hold the massless line off, nothing hits.
  void refuse_law_of_line() const {
    if (std::ranges::any_of(friction_.values, [](double friction) { return friction > 0.0; })) {
      throw InputError{
          "option -support_friction: not allowed with -contact_surface line, expected 0: it acts on masses that hit or "
          "press [-]"};
    }
    for (const double e : restitution_.values) {
      if (e != 1.0) {
        std::ostringstream message;
        message << "option -contact_restitution: " << e
                << " is not allowed with -contact_surface line, expected 1: forces hold the massless line off, nothing "
                   "hits and no coefficient applies";
        throw InputError{message.str()};
      }
    }
  }

  [[nodiscard]] std::size_t count() const noexcept { return position_.values.size(); }
  [[nodiscard]] std::size_t boxes() const noexcept { return boxes_.size() / kBoxNumbers; }
  [[nodiscard]] bool in_space() const noexcept {
    return facing_given_ || field_.given || friction_.given || y_.given || z_.given || y_width_.given || z_width_.given;
  }
  [[nodiscard]] const NumberList& restitution() const noexcept { return restitution_; }
  [[nodiscard]] const NumberList& yield_speed() const noexcept { return yield_speed_; }
  [[nodiscard]] bool tributary() const noexcept { return weighting_.value == Weighting::tributary; }
  [[nodiscard]] bool tributary_given() const noexcept { return weighting_.given && tributary(); }
  /// Restitution, friction and yield speed of an entry: supports, boxes, ground.
  [[nodiscard]] Support law(std::size_t i) const {
    Support support{.restitution = restitution_[i], .yield_speed = yield_speed_[i]};
    support.friction = friction_[i];
    return support;
  }

  /// The faces of all boxes.
  [[nodiscard]] std::vector<Support> faces(const NetworkParameters& network) const {
    std::vector<Support> all;
    const std::vector<Place> nodes = node_places(network);
    for (std::size_t i = 0; i < boxes(); ++i) {
      const auto numbers = std::span{boxes_}.subspan(kBoxNumbers * i, kBoxNumbers);
      const Region box{.from = {.x = numbers[0], .y = numbers[2], .z = numbers[4]},
                       .to = {.x = numbers[1], .y = numbers[3], .z = numbers[5]}};
      const std::vector<Support> own = box_faces(box, law(count() + i), nodes);
      all.insert(all.end(), own.begin(), own.end());
    }
    return all;
  }

  [[nodiscard]] Support support(MPI_Comm comm, std::size_t i) const {
    Support support = law(i);
    support.position = position_[i];
    support.width = width_[i];
    support.height = height_[i];
    support.side = side_[i];
    support.stiffness = stiffness_[i];
    support.damping = damping_[i];
    support.y = around(y_[i], y_width_[i]);
    support.z = around(z_[i], z_width_[i]);
    const auto [normal, turned] = facing(std::span{normal_}.subspan(normal_.size() == 3 ? 0 : 3 * i, 3));
    support.normal = normal;
    if (turned) {
      support.height = 0.0 - support.height;
      support.side = support.side == SupportSide::below ? SupportSide::above : SupportSide::below;
    }
    if (const std::string* path = field_[i]; path != nullptr) {
      support.field = io::read_height_field(comm, "support height field", *path);
    }
    if (const std::string* path = motion_[i]; path != nullptr) {
      support.motion = read_motion(comm, *path, turned);
    }
    if (support.damping > 0.0 && !support.elastic()) {
      throw InputError{"option -support_damping: " + std::to_string(support.damping) +
                       " is not allowed without -support_stiffness, expected 0: a rigid support has no damper [N s/m]"};
    }
    if (support.elastic()) {
      refuse_impact_law("-support_stiffness", "spring and damper decide", restitution_, yield_speed_.key, support);
    }
    return support;
  }

 private:
  static Extent around(double centre, double width) {
    return {.from = centre - 0.5 * width, .to = centre + 0.5 * width};
  }

  static constexpr std::size_t kBoxNumbers = 6;

  NumberList position_{"-support_position"};
  NumberList width_{"-support_width", {0.0}};
  struct {
    Weighting value = Weighting::tributary;
    bool given = false;
  } weighting_;
  NumberList height_{"-support_height", {0.0}};
  std::vector<SupportSide> side_{SupportSide::below};
  bool side_given_ = false;
  Numbers normal_{0.0, 1.0, 0.0};
  bool facing_given_ = false;
  FileList field_{"-support_height_field"};
  Numbers boxes_;
  NumberList y_{"-support_y_position", {0.0}};
  NumberList y_width_{"-support_y_width", {kInfinity}};
  NumberList z_{"-support_z_position", {0.0}};
  NumberList z_width_{"-support_z_width", {kInfinity}};
  NumberList restitution_{"-contact_restitution", {1.0}};
  NumberList yield_speed_{"-support_yield_speed", {kInfinity}};
  NumberList friction_{"-support_friction", {0.0}};
  FileList motion_{"-support_motion"};
  NumberList stiffness_{"-support_stiffness", {kInfinity}};
  NumberList damping_{"-support_damping", {0.0}};
};

/// Gives a support its law of contact, if it has one.
void add_law(MPI_Comm comm, const LawLists& laws, std::size_t i, const SupportLists& lists, Support& support) {
  support.contact_law = laws.law(comm, i);
  if (!support.contact_law) {
    return;
  }
  if (support.stiffness < kInfinity) {
    std::ostringstream message;
    message << "option -support_stiffness: " << support.stiffness << " is not allowed with -contact_law "
            << laws.name(i) << ", expected inf: the law says how the support gives way [N/m]";
    throw InputError{message.str()};
  }
  refuse_impact_law(kLawsOfSupports.law, "the law decides", lists.restitution(), lists.yield_speed().key, support);
  support.height += static_cast<double>(support.side) * laws.interference(*support.contact_law, i);
}

void read_contact_parameters(OptionGroup& group, ContactParameters& contact) {
  group.choice<ContactSurface>("-contact_surface", contact.surface, kSurfaces,
                               "who touches the supports: the masses, by the impact law, or the line, held off by "
                               "contact forces without any restitution");
  group.integer(
      "-contact_line_dense_max", contact.line_dense_max, petsc::at_least(0.0),
      "contact nodes of the line under one support up to which (and to 2000 in all) their compliance is a matrix "
      "on every rank; more go to an active set, in need to TAO (prefix contact_)");
  group.real("-contact_tolerance", contact.hop_tolerance, "m", petsc::positive(),
             "a mass whose next hop would stay lower than this rests on its support; default 1e-10 of the motion's own "
             "scale");
}

}  // namespace

ContactInput read_contact(MPI_Comm comm, const std::optional<NetworkParameters>& network) {
  ContactInput input;
  OptionGroup group{comm, "Supports and contact (lists: one entry per support, or one for all)"};
  SupportLists lists;
  Ground ground;
  lists.read_places(group);
  lists.read_facing(group);
  group.real("-support_field_tolerance", input.field_tolerance, "m", petsc::positive(),
             "a mass keeps the plane of its -support_height_field below or above its start: a warning where that was "
             "off by more while they touched; default 1 % of the motion's own scale");
  lists.read_boxes(group);
  ground.read(group);
  lists.read_law(group);
  read_contact_parameters(group, input.contact);
  lists.read_motion_and_springs(group);
  LawLists laws{kLawsOfSupports};
  laws.read(group);
  input.faces_in_space = lists.in_space();
  input.tributary = lists.tributary_given();
  lists.settle(ground.any());
  laws.settle(lists.count());
  if (input.contact.surface == ContactSurface::line) {
    lists.refuse_law_of_line();
  }
  for (std::size_t i = 0; i < lists.count(); ++i) {
    Support& support = input.supports.emplace_back(lists.support(comm, i));
    add_law(comm, laws, i, lists, support);
    if (lists.tributary() && support.width > 0.0 && std::isfinite(support.width)) {
      input.mass_patches.push_back({.from = support.from(), .to = support.to()});
    }
  }
  if (lists.boxes() > 0 && !network) {
    throw InputError{"option -support_box is not allowed without -structure_type network"};
  }
  if (network) {
    std::ranges::move(lists.faces(*network), std::back_inserter(input.supports));
  }
  if (ground.any()) {
    input.supports.push_back(ground.support(comm, lists.law(lists.count() + lists.boxes())));
  }
  return input;
}

}  // namespace udar::app
