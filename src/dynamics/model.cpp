#include "udar/dynamics/model.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"
#include "udar/structure/network_place.hpp"

namespace udar {
namespace {

/// Without filter masses and line are one, and contact is resolved on the line.
ContactParameters resolved(ContactParameters contact, const FilterParameters& filter) {
  contact.surface = filter.filtered() ? contact.surface : ContactSurface::line;
  return contact;
}

InitialState checked(const MassPoints& points, InitialState initial, std::span<const HeldMove> moves) {
  refuse_shape(points, initial);
  refuse_torn(points, initial);
  for (const HeldMove& move : moves) {
    for (const MovedPoint& moved : move.points) {
      if (moved.held() && moved.here()) {
        const auto [displacement, velocity] = move.table->at(0.0);
        initial.held.push_back(
            {.point = moved.point, .displacement = moved.share * displacement, .velocity = moved.share * velocity});
      }
    }
  }
  return initial;
}

std::unique_ptr<LineContact> line_contact(FilteredStructure& line, const Contacts& contacts,
                                          const ContactParameters& contact) {
  if (contact.surface != ContactSurface::line || contacts.supports.empty()) {
    return nullptr;
  }
  if (!line.points().strikes().empty()) {
    throw InputError{
        "contact surface: line is not allowed with strikers (`striker mass`) and pairs of nodes (`pair normal`), "
        "expected "
        "mass"};
  }
  return std::make_unique<LineContact>(line, contacts, static_cast<std::size_t>(contact.line_dense_max));
}

bool yields(const ModelParameters& parameters) { return parameters.is_beam() && parameters.beam.yields(); }

/// What the line does when what holds it moves, by a line that is free there, which is needed no more.
MovedPoints moved_points(MPI_Comm comm, ModelParameters parameters, std::span<const std::size_t> points) {
  if (parameters.is_beam()) {
    parameters.beam = released(std::move(parameters.beam), parameters.held_motion);
  }
  if (parameters.network) {
    parameters.network = released(std::move(*parameters.network), parameters.held_motion);
  }
  const std::unique_ptr<const Structure> structure = make_structure(comm, parameters);
  FilteredStructure line{*structure, parameters.filter};
  return {line, points};
}

FilteredStructure& prepared(MPI_Comm comm, FilteredStructure& line, const ModelParameters& parameters,
                            std::span<const HeldMove> moves, const std::function<void(FilteredStructure&)>& prepare) {
  if (prepare) {
    prepare(line);
  }
  const std::vector<std::size_t> held = held_points(moves);
  if (held.empty()) {
    return line;
  }
  const auto refuse = [](bool whether, const char* with) {
    if (whether) {
      throw InputError{std::string{"base motion place: a place that holds the structure rigidly is not allowed with "} +
                       with + ", expected a spring or base"};
    }
  };
  refuse(!parameters.filter.filtered(), "`filter frequency` none or `ts type` modal");
  refuse(!line.corrected_modes().empty(), "corrected modes (`filter correct modes`)");
  refuse(yields(parameters), "a beam that yields (`beam yield moment`)");
  refuse(parameters.contact.surface == ContactSurface::line && !parameters.supports.empty(),
         "contact on the line (`contact surface` line)");
  line.move(moved_points(comm, parameters, held));
  return line;
}

std::unique_ptr<const Structure> make_elastic(MPI_Comm comm, const ModelParameters& parameters) {
  if (parameters.imported) {
    return std::make_unique<ImportedStructure>(comm, *parameters.imported);
  }
  if (parameters.network) {
    NetworkParameters network = *parameters.network;
    network.together = paired_nodes(network, parameters.pairs);
    return std::make_unique<Network>(comm, std::move(network));
  }
  return std::make_unique<BeamChain>(comm, parameters.beam);
}

}  // namespace

std::unique_ptr<const Structure> make_structure(MPI_Comm comm, const ModelParameters& parameters) {
  std::unique_ptr<const Structure> structure = make_elastic(comm, parameters);
  const auto carries = [](const TravellingLoad& load) {
    return std::ranges::any_of(load.mass, [](double mass) { return mass != 0.0; });
  };
  if (!parameters.strikers.empty() || !parameters.pairs.empty() ||
      std::ranges::any_of(parameters.travelling_loads, carries)) {
    structure = std::make_unique<StruckStructure>(std::move(structure), parameters.strikers, parameters.pairs,
                                                  parameters.travelling_loads);
  }
  return structure;
}

Model::Model(MPI_Comm comm, const ModelParameters& parameters, const std::function<void(FilteredStructure&)>& prepare)
    : structure{make_structure(comm, parameters)},
      line{*structure, parameters.filter},
      moves{held_moves(*structure, parameters.held_motion)},
      loads{structure->points(),    parameters.gravity,          parameters.loads,
            parameters.base_motion, parameters.travelling_loads, moves},
      initial{checked(structure->points(), parameters.initial, moves)},
      contacts{find_contacts(structure->points(), parameters.supports)},
      contact{resolved(parameters.contact, parameters.filter)},
      equations{prepared(comm, line, parameters, moves, prepare),
                loads,
                initial,
                parameters.damping,
                line_contact(line, contacts, contact),
                parameters.damping_ratio,
                yields(parameters),
                moves} {}

}  // namespace udar
