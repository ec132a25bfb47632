#include "udar/dynamics/model.hpp"

#include <memory>

namespace udar {
namespace {

/// Without filter masses and line are one, and contact is resolved on the line.
ContactParameters resolved(ContactParameters contact, const FilterParameters& filter) {
  contact.surface = filter.unfiltered ? ContactSurface::line : contact.surface;
  return contact;
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
  return std::make_unique<LineContact>(line, contacts, static_cast<std::size_t>(contact.line_dense_max));
}

}  // namespace

Model::Model(MPI_Comm comm, const ModelParameters& parameters, const std::function<void(FilteredStructure&)>& prepare)
    : beam{comm, parameters.beam},
      line{beam, parameters.filter},
      loads{beam.points(), parameters.gravity, parameters.loads},
      initial{parameters.initial},
      contacts{find_contacts(beam.points(), parameters.supports)},
      contact{resolved(parameters.contact, parameters.filter)},
      equations{prepared(line, prepare), loads, initial, parameters.damping, line_contact(line, contacts, contact)} {}

}  // namespace udar
