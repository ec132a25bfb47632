#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {

using petsc::OptionGroup;

namespace {

enum class LoadKind : std::uint8_t { table, harmonic, random, friedlander };

constexpr std::array kLoadKinds{
    Names<LoadKind>{"table", LoadKind::table}, Names<LoadKind>{"harmonic", LoadKind::harmonic},
    Names<LoadKind>{"random", LoadKind::random}, Names<LoadKind>{"friedlander", LoadKind::friedlander}};
constexpr const char* kPerLoad = "one per load: -load_position, -load_place, -load_junction";

/// Where loads are, and which way they act.
class LoadPlaces {
 public:
  void read(OptionGroup& group) {
    group.reals("-load_position", position_, "m", petsc::non_negative(),
                "where forces act, x; between two nodes of a beam on both, with force and moment kept; of others at "
                "the nearest node");
    group.reals("-load_place", place_, "m", petsc::any(),
                "for a structure in space: where more forces act, x,y,z of the first, then of the second, ...: the "
                "nearest node");
    group.strings("-load_junction", junction_, "for a network: where more forces act, names of junctions");
    direction_given_ = group.reals("-load_direction", direction_, "-", petsc::any(),
                                   "for networks: which way a force of 1 N acts, x,y,z, three numbers of any length "
                                   "per load or three for all");
  }

  [[nodiscard]] std::vector<NodalLoad> loads(const std::optional<NetworkParameters>& network) const {
    std::vector<NodalLoad> loads;
    for (const double x : position_) {
      loads.push_back({.position = x, .width = 0.0, .table = nullptr});
    }
    if (place_.size() % 3 != 0) {
      throw InputError{"option -load_place: " + std::to_string(place_.size()) +
                       " values given, expected three for each load: x,y,z [m]"};
    }
    for (std::size_t i = 0; i < place_.size(); i += 3) {
      loads.push_back(at({.x = place_[i], .y = place_[i + 1], .z = place_[i + 2]}));
    }
    for (const std::string& name : junction_) {
      loads.push_back(at(junction_place("-load_junction", name, network)));
    }
    set_directions(loads);
    return loads;
  }

 private:
  [[nodiscard]] static NodalLoad at(const Place& place) {
    return {.position = place.x, .width = 0.0, .table = nullptr, .breadth = 0.0, .y = place.y, .z = place.z};
  }
  void set_directions(std::vector<NodalLoad>& loads) const {
    if (!direction_given_) {
      return;
    }
    if (loads.empty()) {
      throw InputError{"option -load_direction is not allowed without a load"};
    }
    if (direction_.size() != 3 && direction_.size() != 3 * loads.size()) {
      throw InputError{"option -load_direction: " + std::to_string(direction_.size()) +
                       " values given, expected 3, or 3 per load: x,y,z"};
    }
    for (std::size_t i = 0; i < loads.size(); ++i) {
      const std::size_t first = direction_.size() == 3 ? 0 : 3 * i;
      const double size = std::hypot(direction_[first], direction_[first + 1], direction_[first + 2]);
      if (!(size > 0.0) || !std::isfinite(size)) {
        throw InputError{"option -load_direction: 0,0,0 is not allowed, expected three numbers of which one is not 0"};
      }
      loads[i].direction = {
          .x = direction_[first] / size, .y = direction_[first + 1] / size, .z = direction_[first + 2] / size};
    }
  }

  Numbers position_;
  Numbers place_;
  Strings junction_;
  Numbers direction_{0.0, 1.0, 0.0};
  bool direction_given_ = false;
};

constexpr double kUnset = 0.0;

void require_given(const NumberList& list, double value, const char* law) {
  if (value == kUnset) {
    throw InputError{std::string{"option "} + list.key + " is needed with -load_law " + law};
  }
}

/// Spectra of random forces.
struct SpectrumLists {
  NumberList density{"-load_density", {0.0}};
  Numbers band{};
  bool band_given = false;
  Strings file{"none"};
  bool file_given = false;
  NumberList period{"-load_period", {0.0}};
  std::vector<PetscInt> seed{1};
  bool seed_given = false;

  void read(OptionGroup& group) {
    density.read(group, "N^2/Hz", petsc::positive(),
                 "of random: one-sided power spectral density that is even over -load_band");
    band_given = group.reals("-load_band", band, "Hz", petsc::non_negative(),
                             "of random: lowest and highest frequency of -load_density, two numbers for all");
    file_given = group.strings(
        "-load_spectrum", file,
        "of random, in place of a density: CSV files frequency [Hz], one-sided power spectral density [N^2/Hz], linear "
        "between rows, none outside; one per load or one for all; none");
    period.read(group, "s", petsc::positive(),
                "of random: after which the force repeats itself, its lines 1 / period apart; as a rule no less than "
                "the run");
    seed_given = group.integers("-load_seed", seed, petsc::at_least(0.0),
                                "of random: another seed, another force; one per load or one for all");
  }
  void settle(std::size_t loads) {
    density.spread(loads, kPerLoad);
    period.spread(loads, kPerLoad);
    file = petsc::one_per("-load_spectrum", file, loads, kPerLoad);
    seed = petsc::one_per("-load_seed", seed, loads, kPerLoad);
  }
  void give(MPI_Comm comm, std::size_t i, TimeLaw& law) const;
};

/// What forces do over time: each follows a table or a law.
class LoadCourses {
 public:
  void read(OptionGroup& group) {
    given_ = group.choices<LoadKind>(
        "-load_law", kind_, kLoadKinds,
        "what forces do over time, one per load or one for all: table, -load_table; harmonic, A sin(2 pi f t + phase); "
        "random, of a spectrum; friedlander, a pressure pulse A (1 - t/T) exp(-b t/T); t from -load_start on");
    table_given_ =
        group.strings("-load_table", table_,
                      "of table: CSV files time [s], force [N, up], one per load or one for all; linear between rows, "
                      "a jump between two rows of one time, constant outside; none");
    start_.read(group, "s", petsc::non_negative(), "of laws: no force before, a jump if the law begins with one");
    until_.read(group, "s", petsc::positive_or_infinite(),
                "of laws: no force after, a jump likewise; of friedlander the end of the positive phase unless given");
    amplitude_.read(group, "N", petsc::any(), "of harmonic; the peak of friedlander");
    frequency_.read(group, "Hz", petsc::positive(), "of harmonic: f");
    last_frequency_.read(group, "Hz", petsc::positive(),
                         "of harmonic: what f goes to evenly, from -load_start to -load_until: a sweep");
    phase_.read(group, "rad", petsc::any(), "of harmonic");
    duration_.read(group, "s", petsc::positive(), "of friedlander: T of the positive phase");
    decay_.read(group, "-", petsc::non_negative(), "of friedlander: b");
    spectra_.read(group);
    accuracy_.read(
        group, "-", petsc::between(1e-9, 0.1),
        "of laws: how far the table that stands for a law, linear between rows, may be off, of the "
        "amplitude or root mean square; a hundredth of it is ten times as many rows, and steps no longer than "
        "they are apart");
  }

  /// One entry per load in each list.
  void settle(std::size_t loads) {
    if (loads == 0) {
      throw InputError{std::string{"option "} + (table_given_ ? "-load_table" : "-load_law") +
                       " has nothing to apply to: " + kPerLoad};
    }
    kind_ = petsc::one_per("-load_law", kind_, loads, kPerLoad);
    table_ = petsc::one_per("-load_table", table_, loads, kPerLoad);
    spectra_.settle(loads);
    for (NumberList* list :
         {&start_, &until_, &amplitude_, &frequency_, &last_frequency_, &phase_, &duration_, &decay_, &accuracy_}) {
      list->spread(loads, kPerLoad);
    }
  }
  void refuse_idle() const;
  /// Whether there must be a load for what was given.
  [[nodiscard]] bool given() const { return given_ || table_given_; }

  void give(MPI_Comm comm, std::size_t i, NodalLoad& load) {
    if (kind_[i] != LoadKind::table) {
      load.law = law(comm, i);
      return;
    }
    if (table_[i] == "none") {
      throw InputError{"option -load_table is needed with -load_law table: a file time [s], force [N]"};
    }
    std::shared_ptr<const TimeTable>& shared = tables_[table_[i]];
    if (!shared) {
      const io::Table table = io::read_table(comm, "load table", table_[i], {.names = {"time [s]", "force [N]"}});
      require_ascending("-load_table", table_[i], column(table, 0), "times [s]", true);
      shared = time_table(column(table, 0), column(table, 1));
    }
    load.table = shared;
  }

 private:
  [[nodiscard]] TimeLaw law(MPI_Comm comm, std::size_t i) const;

  std::vector<LoadKind> kind_{LoadKind::table};
  bool given_ = false;
  Strings table_{"none"};
  bool table_given_ = false;
  NumberList start_{"-load_start", {0.0}};
  NumberList until_{"-load_until", {TimeLaw::kNever}};
  NumberList amplitude_{"-load_amplitude", {kUnset}};
  NumberList frequency_{"-load_frequency", {kUnset}};
  NumberList last_frequency_{"-load_last_frequency", {kUnset}};
  NumberList phase_{"-load_phase", {0.0}};
  NumberList duration_{"-load_duration", {kUnset}};
  NumberList decay_{"-load_decay", {0.0}};
  SpectrumLists spectra_;
  NumberList accuracy_{"-load_accuracy", {TimeLaw{}.accuracy}};
  std::map<std::string, std::shared_ptr<const TimeTable>> tables_;  // places that name one file share its table
};

/// Nothing that is given is to be ignored.
void LoadCourses::refuse_idle() const {
  using enum LoadKind;
  struct Use {
    const char* key;
    bool given;
    std::vector<LoadKind> by;
    const char* words;
  };
  const std::vector<LoadKind> laws{harmonic, random, friedlander};
  const std::array<Use, 15> uses{
      {{"-load_table", table_given_, {table}, "table"},
       {start_.key, start_.given, laws, "harmonic, random or friedlander"},
       {until_.key, until_.given, laws, "harmonic, random or friedlander"},
       {accuracy_.key, accuracy_.given, laws, "harmonic, random or friedlander"},
       {amplitude_.key, amplitude_.given, {harmonic, friedlander}, "harmonic or friedlander"},
       {frequency_.key, frequency_.given, {harmonic}, "harmonic"},
       {last_frequency_.key, last_frequency_.given, {harmonic}, "harmonic"},
       {phase_.key, phase_.given, {harmonic}, "harmonic"},
       {duration_.key, duration_.given, {friedlander}, "friedlander"},
       {decay_.key, decay_.given, {friedlander}, "friedlander"},
       {spectra_.density.key, spectra_.density.given, {random}, "random"},
       {"-load_band", spectra_.band_given, {random}, "random"},
       {"-load_spectrum", spectra_.file_given, {random}, "random"},
       {spectra_.period.key, spectra_.period.given, {random}, "random"},
       {"-load_seed", spectra_.seed_given, {random}, "random"}}};
  for (const Use& use : uses) {
    const bool used =
        std::ranges::any_of(kind_, [&](LoadKind kind) { return std::ranges::find(use.by, kind) != use.by.end(); });
    if (use.given && !used) {
      throw InputError{std::string{"option "} + use.key + " is not allowed without -load_law " + use.words +
                       " of some load"};
    }
  }
}

void SpectrumLists::give(MPI_Comm comm, std::size_t i, TimeLaw& law) const {
  law.course = Course::random;
  law.seed = static_cast<std::uint64_t>(seed[i]);
  law.period = period[i];
  require_given(period, law.period, "random");
  const bool from_file = file[i] != "none";
  if (from_file == (density[i] != kUnset)) {
    throw InputError{
        "options -load_density and -load_spectrum: one of them is needed with -load_law random, the power spectral "
        "density [N^2/Hz]"};
  }
  if (!from_file) {
    if (band.size() != 2 || !(band[0] < band[1])) {
      throw InputError{
          "option -load_band: the lowest and the highest frequency of -load_density are needed, two numbers, ascending "
          "[Hz]"};
    }
    law.at = band;
    law.density = {density[i], density[i]};
    return;
  }
  const io::Table table =
      io::read_table(comm, "load spectrum", file[i], {.names = {"frequency [Hz]", "density [N^2/Hz]"}});
  require_ascending("-load_spectrum", file[i], column(table, 0), "frequencies [Hz]");
  law.at = column(table, 0);
  law.density = column(table, 1);
}

TimeLaw LoadCourses::law(MPI_Comm comm, std::size_t i) const {
  TimeLaw law{.start = start_[i], .until = until_[i], .accuracy = accuracy_[i]};
  switch (kind_[i]) {
    case LoadKind::random:
      spectra_.give(comm, i, law);
      return law;
    case LoadKind::friedlander:
      law.course = Course::friedlander;
      law.amplitude = amplitude_[i];
      law.duration = duration_[i];
      law.decay = decay_[i];
      require_given(duration_, law.duration, "friedlander");
      law.until = std::isinf(law.until) ? law.start + law.duration : law.until;
      break;
    default:
      law.amplitude = amplitude_[i];
      law.frequency = frequency_[i];
      law.last_frequency = last_frequency_[i];
      law.phase = phase_[i];
      require_given(frequency_, law.frequency, "harmonic");
  }
  require_given(amplitude_, law.amplitude, kind_[i] == LoadKind::harmonic ? "harmonic" : "friedlander");
  return law;
}

}  // namespace

std::vector<NodalLoad> read_loads(MPI_Comm comm, const std::optional<NetworkParameters>& network) {
  OptionGroup group{comm, "Loads"};
  LoadPlaces places;
  NumberList width{.key = "-load_width", .values = {0.0}};
  NumberList breadth{.key = "-load_breadth", .values = {0.0}};
  LoadCourses courses;
  places.read(group);
  width.read(group, "m", petsc::non_negative_or_infinite(),
             "length about -load_position over which a force is spread evenly; 0: none; inf: all of the beam; one per "
             "load or one for all");
  breadth.read(group, "m", petsc::non_negative(),
               "with -load_width: forces of table or law are pressures [Pa] on this breadth; 1: they are [N/m]; 0: "
               "they are [N]; one per load or one for all");
  courses.read(group);
  std::vector<NodalLoad> loads = places.loads(network);
  for (const NumberList& list : {width, breadth}) {
    if (list.given && loads.empty()) {
      throw InputError{std::string{"option "} + list.key + " is not allowed without -load_position"};
    }
  }
  courses.refuse_idle();
  if (loads.empty() && !courses.given()) {
    return loads;
  }
  courses.settle(loads.size());
  width.spread(loads.size(), kPerLoad);
  breadth.spread(loads.size(), kPerLoad);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    loads[i].width = width[i];
    loads[i].breadth = breadth[i];
    courses.give(comm, i, loads[i]);
  }
  return loads;
}

}  // namespace udar::app
