#include "app/citations.hpp"

#include <petscsys.h>
#include <yaml-cpp/yaml.h>

#include <string>

#include "udar/petsc/error.hpp"
#include "udar_citation.hpp"

namespace udar::app {
namespace {

/// Authors as BibTeX separates them; a name that is none of a person stays in one piece.
std::string authors_of(const YAML::Node& entry) {
  std::string all;
  for (const YAML::Node& author : entry["authors"]) {
    const YAML::Node whole = author["name"];
    all += all.empty() ? "" : " and ";
    all += whole ? "{" + whole.as<std::string>() + "}"
                 : author["family-names"].as<std::string>() + ", " + author["given-names"].as<std::string>();
  }
  return all;
}

/// An entry of CITATION.cff, or one of its references, in BibTeX.
std::string bibtex(const std::string& key, const YAML::Node& entry) {
  std::string text = "@Misc{" + key + ",\n  author = {" + authors_of(entry) + "},\n  title  = {{" +
                     entry["title"].as<std::string>() + "}},\n";
  if (const YAML::Node version = entry["version"]) {
    text += "  note   = {version " + version.as<std::string>() + "},\n";
  }
  return text + "}\n";
}

}  // namespace

void cite(bool filtered) {
  static PetscBool udar_cited = PETSC_FALSE;
  static PetscBool filter_cited = PETSC_FALSE;
  const YAML::Node citation = YAML::Load(kCitation);
  UDAR_CALL(PetscCitationsRegister(bibtex("udar", citation).c_str(), &udar_cited));
  if (filtered) {
    UDAR_CALL(PetscCitationsRegister(bibtex("udar-filter-method", citation["references"][0]).c_str(), &filter_cited));
  }
}

}  // namespace udar::app
