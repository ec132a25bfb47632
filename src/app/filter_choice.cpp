#include "udar/app/filter_choice.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "udar/filter/rigid_shapes.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::app {
namespace {

/// Two frequencies this close are one, with any shapes in between.
constexpr double kSame = 1e-6;

/// The least number of six digits that is not below; equal on any number of ranks, on which modes differ by round-off.
double rounded_up(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 5.0);
  constexpr double kRoundOff = 1e-9;  // modes are right to less
  return std::ceil(value / unit * (1.0 - kRoundOff)) * unit;
}

[[noreturn]] void refuse_count(const char* option, PetscInt asked, std::size_t found) {
  throw InputError{std::string{"option "} + option + ": " + std::to_string(asked) +
                   " is not allowed, expected at most " + std::to_string(found) +
                   ", the flexible modes that this structure has"};
}

/// So many of the lowest modes; of a beam on a mesh that is fine enough for them.
using LowestModes = std::function<std::vector<Mode>(PetscInt)>;

/// Modes up to the band's end, all there are if that is above them.
std::vector<Mode> modes_in_band(const LowestModes& lowest, const FilterInput& filter) {
  constexpr PetscInt kMost = 64;  // more than anybody reads
  std::vector<Mode> modes;
  for (PetscInt count = 4; count <= kMost; count *= 2) {
    modes = lowest(count);
    if (static_cast<PetscInt>(modes.size()) < count || modes.back().frequency > filter.band) {
      break;
    }
  }
  std::erase_if(modes, [&filter](const Mode& mode) { return mode.frequency > filter.band; });
  return modes;
}

/// The lowest modes: six for the view, else three. They do not depend on a fine mesh: they are taken from a coarser one
/// where the line has more elements than that needs.
std::vector<Mode> modes_to_show(const Case& input, FilteredStructure& line) {
  constexpr PetscInt kEchoed = 3;
  const MPI_Comm comm = line.points().comm();
  if (input.modal && !input.is_beam()) {  // there is no filter frequency near these modes
    return exact_modes(line.structure(), input.filter, input.view ? 6 : kEchoed);
  }
  const bool fine = input.view || !input.is_beam();
  const auto coarse = fine ? std::nullopt : coarser(comm, input.beam, kEchoed);
  if (!coarse && line.points().of_nodes_alone()) {
    return lowest_modes(line, input.view ? 6 : kEchoed);
  }
  if (!coarse) {
    FilteredStructure unstruck{line.structure().elastic(), input.filter};
    return lowest_modes(unstruck, input.view ? 6 : kEchoed);
  }
  const BeamChain coarse_beam{comm, *coarse};
  FilteredStructure coarse_line{coarse_beam, input.filter};
  return lowest_modes(coarse_line, kEchoed);
}

}  // namespace

std::optional<BeamParameters> coarser(MPI_Comm comm, const BeamParameters& beam, PetscInt modes) {
  constexpr PetscInt kElements = 2000;
  constexpr PetscInt kPerMode = 200;
  const double enough = static_cast<double>(std::max(kElements, kPerMode * modes));
  int size = 1;
  MPI_Comm_size(comm, &size);
  double all = 0.0;
  for (const BeamSegment& segment : beam.segments) {
    all += static_cast<double>(segment.elements);
  }
  BeamParameters coarse = beam;
  coarse.mass_patches.clear();  // may be finer than this mesh
  PetscInt elements = 0;
  for (BeamSegment& segment : coarse.segments) {
    segment.elements =
        std::max<PetscInt>(1, static_cast<PetscInt>(static_cast<double>(segment.elements) / all * enough));
    elements += segment.elements;
  }
  if (all <= enough || (elements + 1) / 2 < static_cast<PetscInt>(size)) {
    return std::nullopt;
  }
  return coarse;
}

FilterParameters choose_filter(MPI_Comm comm, const ModelParameters& model, const FilterInput& filter) {
  if (!filter.automatic) {
    return filter.parameters;
  }
  const std::unique_ptr<const Structure> given = model.is_beam() ? nullptr : make_structure(comm, model);
  const LowestModes lowest = [&](PetscInt count) {
    return given ? exact_modes(*given, filter.parameters, count)
                 : exact_modes(BeamChain{comm, coarser(comm, model.beam, count).value_or(model.beam)},
                               filter.parameters, count);
  };
  double highest = filter.band;
  std::vector<Mode> modes;
  if (highest > 0.0) {
    modes = modes_in_band(lowest, filter);
  } else {
    modes = lowest(filter.modes);
    if (static_cast<PetscInt>(modes.size()) < filter.modes) {
      refuse_count("-filter_modes", filter.modes, modes.size());
    }
    highest = modes.back().frequency;
  }
  const double wf = rounded_up(filter_frequency_for(highest, filter.accuracy));
  petsc::say(comm, "udar: filter frequency wf %.6g rad/s: frequencies up to %.6g rad/s are right to %.6g %%\n", wf,
             highest, 100.0 * filter.accuracy);
  petsc::say(comm, "  mode   w [rad/s]   filtered [rad/s]   error\n");
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const double filtered = filtered_frequency(modes[i].frequency, wf);
    petsc::say(comm, "  %4zu %11.6g %18.6g %8.4f %%\n", i + 1, modes[i].frequency, filtered,
               100.0 * (filtered / modes[i].frequency - 1.0));
  }
  FilterParameters chosen = filter.parameters;
  chosen.filter_frequency = wf;
  return chosen;
}

std::vector<PetscInt> correct_modes(FilteredStructure& line, const ModeChoice& exact, bool rigid) {
  const MPI_Comm comm = line.points().comm();
  const double wf = line.filter_frequency();
  const PetscInt last_named = exact.named.empty() ? 0 : std::ranges::max(exact.named);
  const PetscInt last = std::max(exact.lowest, last_named);
  if (last == 0) {
    return {};
  }
  std::vector<Mode> modes = exact_modes(line.structure(), line.parameters(), last + 2);
  if (static_cast<PetscInt>(modes.size()) < last) {
    refuse_count(last == last_named ? "-filter_correct_mode" : "-filter_correct_modes", last, modes.size());
  }
  for (PetscInt number = 1; number <= last; ++number) {
    Mode& mode = modes[static_cast<std::size_t>(number - 1)];
    const bool named = std::ranges::find(exact.named, number) != exact.named.end();
    mode.corrected = named || (number <= exact.lowest && mode.frequency <= wf);
    if (!mode.corrected && number <= exact.lowest) {
      petsc::say(comm,
                 "udar: mode %d, %.10g rad/s, is above wf %.6g rad/s and left uncorrected; "
                 "-filter_correct_mode %d would correct it\n",
                 static_cast<int>(number), mode.frequency, wf, static_cast<int>(number));
    }
  }
  for (std::size_t i = 0; i + 1 < modes.size(); ++i) {
    if (modes[i].corrected != modes[i + 1].corrected &&
        modes[i + 1].frequency - modes[i].frequency < kSame * modes[i].frequency) {
      throw InputError{"option -filter_correct_mode: modes " + std::to_string(i + 1) + " and " + std::to_string(i + 2) +
                       " have the same frequency and no shapes of their own, correct both or none"};
    }
  }
  std::vector<PetscInt> numbers;
  std::vector<CorrectedMode> corrected;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (modes[i].corrected) {
      petsc::say(comm, "udar: mode %zu: filtered %.10g rad/s, corrected to %.10g rad/s\n", i + 1, modes[i].filtered,
                 modes[i].frequency);
      numbers.push_back(static_cast<PetscInt>(i + 1));
      corrected.push_back({.frequency = modes[i].frequency, .shape = std::move(modes[i].shape)});
    }
  }
  for (auto& shape : rigid && !corrected.empty() ? rigid_shapes(line) : std::vector<std::vector<double>>{}) {
    corrected.push_back({.frequency = 0.0, .shape = std::move(shape)});
  }
  if (!corrected.empty()) {
    const auto largest = [&line] { return largest_frequency(line).value_or(line.frequency_bound()); };
    const double before = largest();
    line.correct(std::move(corrected));
    petsc::say(comm,
               "udar: largest frequency %.10g rad/s before, %.10g rad/s with %zu corrected modes, at most "
               "%.10g rad/s; they cost %zu dot products and axpys a line solve and %zu bytes a node\n",
               before, largest(), numbers.size(), line.frequency_bound(), numbers.size(),
               numbers.size() * sizeof(double));
  }
  return numbers;
}

std::vector<Mode> settle_modes(FilteredStructure& line, const Case& input) {
  std::vector<Mode> modes = modes_to_show(input, line);
  for (const PetscInt number : correct_modes(line, input.exact, input.contact.surface == ContactSurface::line)) {
    if (number <= static_cast<PetscInt>(modes.size())) {
      modes[static_cast<std::size_t>(number - 1)].corrected = true;
    }
  }
  return modes;
}

}  // namespace udar::app
