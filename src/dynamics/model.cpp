#include "udar/dynamics/model.hpp"

#include <memory>
#include <utility>

#include "udar/petsc/error.hpp"
#include "udar/structure/network_place.hpp"

namespace udar {
namespace {

/// Without filter masses and line are one, and contact is resolved on the line.
ContactParameters resolved(ContactParameters contact, const FilterParameters& filter) {
  contact.surface = filter.filtered() ? contact.surface : ContactSurface::line;
  return contact;
}

InitialState checked(const MassPoints& points, InitialState initial) {
  refuse_shape(points, initial);
  refuse_torn(points, initial);
  return initial;
}

FilteredStructure& prepared(FilteredStructure& line, const std::function<void(FilteredStructure&)>& prepare) {
  if (prepare) {
    prepare(line);
  }
  return line;
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
  if (!parameters.strikers.empty() || !parameters.pairs.empty()) {
    structure = std::make_unique<StruckStructure>(std::move(structure), parameters.strikers, parameters.pairs);
  }
  return structure;
}

Model::Model(MPI_Comm comm, const ModelParameters& parameters, const std::function<void(FilteredStructure&)>& prepare)
    : structure{make_structure(comm, parameters)},
      line{*structure, parameters.filter},
      loads{structure->points(), parameters.gravity, parameters.loads, parameters.base_motion,
            parameters.travelling_loads},
      initial{checked(structure->points(), parameters.initial)},
      contacts{find_contacts(structure->points(), parameters.supports)},
      contact{resolved(parameters.contact, parameters.filter)},
      equations{prepared(line, prepare),
                loads,
                initial,
                parameters.damping,
                line_contact(line, contacts, contact),
                parameters.damping_ratio,
                yields(parameters)} {}

}  // namespace udar
