#include "io/paraview_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>

#include "io/text_file.hpp"
#include "structure/place_algebra.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar_paraview_state.hpp"

namespace udar::io {
namespace {

constexpr const char* kSeen = "pictures";
constexpr double kSmallest = std::numeric_limits<double>::min();  // nothing has moved yet
constexpr const char* kTips = "pictures of strikers";

/// The largest of 1, 2, 5, 10, ... that is not above a number; 1 at least.
double round_factor(double value) {
  if (!(value > 1.0) || !std::isfinite(value)) {
    return 1.0;
  }
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  const double digit = value / power;
  return power * (digit >= 5.0 ? 5.0 : digit >= 2.0 ? 2.0 : 1.0);
}

std::string python_number(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

bool is_moment(const FileField& field) { return field.name.starts_with("moment"); }

/// What tells where the line is.
FileField position_of(std::span<const FileField> fields) {
  const auto moves = [](const FileField& field) {
    return field.body == Body::line && (field.form == FileField::Form::displacement || field.position);
  };
  auto found = std::ranges::find_if(
      fields, [&](const FileField& field) { return moves(field) && field.form == FileField::Form::displacement; });
  if (found == fields.end()) {
    found = std::ranges::find_if(fields, moves);
  }
  return found != fields.end() ? *found : FileField{};
}

/// An array of a VTK file.
template <class Values>
void add_vtk_array(std::string& text, const char* type, const char* name, std::size_t components,
                   const Values& values) {
  text += std::string{"<DataArray type=\""} + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
          std::to_string(components) + "\" NumberOfTuples=\"" + std::to_string(std::size(values) / components) +
          "\" format=\"ascii\">";
  for (const auto value : values) {
    text += ' ';
    append_number(text, value);
  }
  text += "</DataArray>\n";
}

template <class Vector>
std::vector<double> vectors_of(std::span<const SupportFaces::Point> points, const Vector& vector) {
  std::vector<double> values;
  values.reserve(3 * points.size());
  for (const SupportFaces::Point& point : points) {
    std::ranges::copy(values_of(vector(point)), std::back_inserter(values));
  }
  return values;
}

/// Cells of one kind, each with as many corners.
void add_vtk_cells(std::string& text, const char* kind, const std::vector<std::int64_t>& corners,
                   std::int64_t of_each) {
  std::vector<std::int64_t> ends;
  for (std::int64_t end = of_each; end <= static_cast<std::int64_t>(corners.size()); end += of_each) {
    ends.push_back(end);
  }
  text += std::string{"<"} + kind + ">\n";
  add_vtk_array(text, "Int64", "connectivity", 1, corners);
  add_vtk_array(text, "Int64", "offsets", 1, ends);
  text += std::string{"</"} + kind + ">\n";
}

}  // namespace

ParaViewFiles::ParaViewFiles(const RunLayout& layout, std::string folder)
    : comm_{layout.comm()},
      folder_{std::move(folder)},
      points_{layout.points},
      rows_{layout.rows},
      scene_{layout},
      faces_{layout, scene_},
      tubes_{layout.tubes} {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double thinnest = kNone;
  for (const double radius : layout.topology.radius) {
    thinnest = radius > 0.0 ? std::min(thinnest, radius) : thinnest;
  }
  MPI_Allreduce(MPI_IN_PLACE, &thinnest, 1, MPI_DOUBLE, MPI_MIN, comm_);
  thinnest_ = thinnest < kNone ? thinnest : 0.0;
  const std::vector<FileField> fields = layout.fields_in_pictures();
  moved_ = position_of(fields);
  for (const FileField& field : fields) {
    if (!field.flag && !field.position &&
        (field.form == FileField::Form::given || field.form == FileField::Form::vectors)) {
      shown_.push_back({field});
    }
    contact_ += field.flag ? (contact_.empty() ? "" : "+") + std::string{field.name} : "";
  }
  contact_ = contact_.empty() ? "0" : contact_;
  for (const Strike& strike : points_->strikes()) {
    tips_.push_back(points_->height_of(strike.gap));
  }
  for (const SupportFaces::Tip& tip : faces_.tips) {
    tip_start_.push_back(faces_.points[tip.point].at.y);
  }
  if (layout.earlier == nullptr) {
    return;
  }
  const auto& tables = layout.earlier->tables;
  if (const auto seen = tables.find(kSeen); seen != tables.end() && seen->second.size() == 3 + shown_.size()) {
    farthest_ = seen->second[0];
    best_ = seen->second[1];
    time_ = seen->second[2];
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      shown_[i].largest = seen->second[3 + i];
    }
  }
  if (const auto tips = tables.find(kTips); tips != tables.end()) {
    tip_rows_ = tips->second;
  }
}

void ParaViewFiles::save(MotionState& state) const {
  std::vector<double>& seen = state.tables[kSeen];
  seen = {farthest_, best_, time_};
  std::ranges::transform(shown_, std::back_inserter(seen), &Shown::largest);
  if (!tips_.empty()) {
    state.tables[kTips] = tip_rows_;
  }
}

/// The largest size of a value of this rank, of vectors their length.
double ParaViewFiles::size_in(const Snapshot& state, const FileField& field) const {
  const std::span<const double> given = state.fields[field.source].numbers();
  std::vector<double> made;
  std::span<const double> values = given;
  if (!rows_->as_shown(field)) {
    made = rows_->numbers(field, given);
    values = made;
  } else {
    values = given.first(static_cast<std::size_t>(rows_->order_of(field.where).range().count()) *
                         static_cast<std::size_t>(field.components));
  }
  double largest = 0.0;
  const auto components = static_cast<std::size_t>(field.components);
  for (std::size_t i = 0; i + components <= values.size(); i += components) {
    double square = 0.0;
    for (const double value : values.subspan(i, components)) {
      square += value * value;
    }
    largest = square > largest ? square : largest;  // not what is no number
  }
  return std::sqrt(largest);
}

void ParaViewFiles::see(const Snapshot& state) {
  std::vector<double> sizes{moved_.name.empty() ? 0.0 : size_in(state, moved_)};
  for (const Shown& shown : shown_) {
    sizes.push_back(size_in(state, shown.field));
  }
  MPI_Allreduce(MPI_IN_PLACE, sizes.data(), static_cast<int>(sizes.size()), MPI_DOUBLE, MPI_MAX, comm_);
  farthest_ = std::max(farthest_, sizes[0]);
  double best = 0.0;
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    shown_[i].largest = std::max(shown_[i].largest, sizes[i + 1]);
    best = std::max(best, weight(shown_[i].field) * sizes[i + 1]);
  }
  if (best > best_) {
    best_ = best;
    time_ = state.time;
  }
  if (tips_.empty()) {
    return;
  }
  std::vector<double> tips(tips_.size(), 0.0);
  const auto positions = std::ranges::find(state.fields, std::string_view{"mass_position"}, &Field::name);
  for (std::size_t i = 0; i < tips_.size(); ++i) {
    for (const auto& [point, share] : tips_[i]) {
      if (points_->owns(point)) {
        tips[i] += share * positions->numbers()[static_cast<std::size_t>(point - points_->begin())];
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, tips.data(), static_cast<int>(tips.size()), MPI_DOUBLE, MPI_SUM, comm_);
  std::ranges::transform(tips, tip_start_, std::back_inserter(tip_rows_), std::minus{});
}

void ParaViewFiles::write(std::span<const double> times) const {
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  if (!faces_.points.empty()) {
    replace_text(comm_, folder_ + "supports.vtp", rank == 0 ? supports(times) : "", false);
  }
  replace_text(comm_, folder_ + "paraview-state.py", rank == 0 ? state() : "", false);
}

std::string ParaViewFiles::state() const {
  constexpr std::string_view kRun = "# What a run is: io/paraview_files.cpp\n";
  std::string text{kParaViewState};
  return text.replace(text.find(kRun), kRun.size(), head());
}

/// Of moments and axial forces: what a size comes to as a bending moment on the thinnest tube, by the stress in its
/// outermost fibre if that is a round bar. Where there are no moments the first field alone has one.
double ParaViewFiles::weight(const FileField& field) const {
  if (is_moment(field)) {
    return 1.0;
  }
  if (std::ranges::any_of(shown_, [](const Shown& shown) { return is_moment(shown.field); })) {
    return field.name == "axial_force" ? 0.25 * thinnest_ : 0.0;
  }
  return field.name == shown_.front().field.name ? 1.0 : 0.0;
}

std::string ParaViewFiles::favourite() const {
  if (shown_.empty()) {
    return "contact";
  }
  const auto size = [this](const Shown& shown) { return weight(shown.field) * (shown.largest + kSmallest); };
  const FileField& field = std::ranges::max_element(shown_, {}, size)->field;
  return is_moment(field) && field.where == Where::cells ? "moment" : std::string{field.name};
}

std::string ParaViewFiles::head() const {
  constexpr double kSeenMotion = 0.1;     // of the size of the structure
  constexpr double kSeenRadius = 0.0025;  // the same
  constexpr double kBall = 0.005;         // the same
  std::string fields;
  for (const auto& [field, largest] : shown_) {
    const std::string name{field.name};
    std::string label{field.label.empty() ? field.name : field.label};
    std::ranges::replace(label, '_', ' ');
    const double most = largest > 0.0 ? largest : 1.0;
    fields += "        \"" + name + "\": (\"" + (field.where == Where::points ? "POINTS" : "CELLS") + "\", \"" + label +
              "\", \"" + std::string{field.unit} + "\", " + python_number(field.components == 1 ? -most : 0.0) + ", " +
              python_number(most) + "),\n";
  }
  const auto line = [](const std::string& name, const std::string& value, const char* comment) {
    return name + value + comment + "\n";
  };
  const auto entry = [&](const char* name, const std::string& value, const char* comment = "") {
    return line(std::string{"    \""} + name + "\": ", value + ",", comment);
  };
  const auto yes = [](bool value) { return std::string{value ? "True" : "False"}; };
  const double motion = round_factor(kSeenMotion * scene_.size / farthest_);
  const double radius = thinnest_ > 0.0 ? round_factor(kSeenRadius * scene_.size / thinnest_) : 1.0;
  return line("EXAGGERATION = ", python_number(motion),
              "  # displacements are drawn so many times larger; 1: as they are") +
         line("THICKNESS = ", python_number(radius), "  # tubes are drawn so many times thicker; 1: as they are") +
         line("COLOUR = \"", favourite(),
              "\"  # of the structure: one of `fields`, contact, or of a network moment, about both axes") +
         line("TIME = ", python_number(time_), "  # [s] first shown; the nearest row is taken") +
         "\nRUN = {  # what is in the files\n" +
         entry("upright", yes(rows_->upright()), "  # all of it moves along y") +
         entry("flat", yes(scene_.around.from.z == scene_.around.to.z), "  # it stands in a plane") +
         entry("tubes", yes(tubes_)) + entry("supports", yes(!faces_.faces.empty())) +
         entry("contact", "\"" + contact_ + "\"") + entry("strikers", std::to_string(faces_.tips.size())) +
         entry("moving", yes(!faces_.lifts.empty() || !faces_.tips.empty()), "  # some support or striker") +
         entry("size", python_number(scene_.size), "  # [m]") +
         entry("ball", python_number(kBall * scene_.size), "  # radius of a point where there are no tubes [m]") +
         "    \"fields\": {  # where, label, unit, least and most\n" + fields + "    },\n}\n";
}

std::string ParaViewFiles::supports(std::span<const double> times) const {
  const std::span<const SupportFaces::Point> points{faces_.points};
  std::vector<std::int64_t> movers;
  std::ranges::transform(points, std::back_inserter(movers),
                         [](const SupportFaces::Point& point) { return std::int64_t{point.mover}; });
  std::vector<std::int64_t> tips;
  std::vector<std::int64_t> corners;
  std::vector<std::int64_t> support;
  for (const auto& [point, number] : faces_.tips) {
    tips.push_back(static_cast<std::int64_t>(point));
    support.push_back(number);
  }
  for (const SupportFaces::Face& face : faces_.faces) {
    std::ranges::transform(face.corners, std::back_inserter(corners),
                           [](std::size_t corner) { return static_cast<std::int64_t>(corner); });
    support.push_back(face.support);
  }
  std::vector<std::int64_t> striker(faces_.tips.size(), 1);
  striker.resize(support.size(), 0);
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "<PolyData>\n";
  const std::size_t strikers = tips_.size();
  const std::size_t columns = faces_.lifts.size() + strikers;
  const std::size_t rows = strikers == 0 ? times.size() : std::min(times.size(), tip_rows_.size() / strikers);
  if (columns > 0) {
    const std::span<const double> last = times.last(rows);
    std::vector<double> motion;
    motion.reserve(rows * columns);
    for (std::size_t row = 0; row < rows; ++row) {
      for (const auto& lift : faces_.lifts) {
        motion.push_back(lift(last[row]));
      }
      motion.insert(motion.end(), tip_rows_.begin() + static_cast<std::ptrdiff_t>(row * strikers),
                    tip_rows_.begin() + static_cast<std::ptrdiff_t>((row + 1) * strikers));
    }
    text += "<FieldData>\n";
    add_vtk_array(text, "Float64", "time", 1, last);
    add_vtk_array(text, "Float64", "motion", columns, motion);
    text += "</FieldData>\n";
  }
  text += "<Piece NumberOfPoints=\"" + std::to_string(points.size()) + "\" NumberOfVerts=\"" +
          std::to_string(tips.size()) + "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
          std::to_string(faces_.faces.size()) + "\">\n<PointData>\n";
  using Point = SupportFaces::Point;
  add_vtk_array(text, "Float64", "displacement", 3,
                vectors_of(points, [](const Point& point) { return point.displacement; }));
  add_vtk_array(text, "Float64", "normal", 3, vectors_of(points, [](const Point& point) { return point.normal; }));
  add_vtk_array(text, "Float64", "away", 3, vectors_of(points, [](const Point& point) { return point.away; }));
  add_vtk_array(text, "Int64", "mover", 1, movers);
  text += "</PointData>\n<CellData>\n";
  add_vtk_array(text, "Int64", "support", 1, support);
  add_vtk_array(text, "Int64", "striker", 1, striker);
  text += "</CellData>\n<Points>\n";
  add_vtk_array(text, "Float64", "Points", 3, vectors_of(points, [](const Point& point) { return point.at; }));
  text += "</Points>\n";
  add_vtk_cells(text, "Verts", tips, 1);
  add_vtk_cells(text, "Polys", corners, 4);
  return text + "</Piece>\n</PolyData>\n</VTKFile>\n";
}

}  // namespace udar::io
