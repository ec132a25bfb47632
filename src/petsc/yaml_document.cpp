#include "petsc/yaml_document.hpp"

#include <string_view>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"

namespace udar::petsc {
namespace {

/// How many bytes the UTF-8 character at `at` has; 0: none starts there, or a control character.
std::size_t character_length(std::string_view text, std::size_t at) {
  const auto byte = [text](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(at);
  if (first < 0x80U) {
    return first >= 0x20U || first == '\t' || first == '\n' || first == '\r' ? 1 : 0;
  }
  const std::size_t length = first >= 0xf0U ? 4 : first >= 0xe0U ? 3 : 2;
  bool valid = first >= 0xc2U && first <= 0xf4U;
  for (std::size_t i = 1; i < length; ++i) {
    valid = valid && (byte(at + i) & 0xc0U) == 0x80U;
  }
  return valid ? length : 0;
}

}  // namespace

YamlDocument::YamlDocument(std::string title, const std::string& text, const std::string& example)
    : title_{std::move(title)} {
  refuse_other_encodings(text);
  std::vector<YAML::Node> documents;
  try {
    documents = YAML::LoadAll(text);
  } catch (const YAML::Exception& failure) {
    refuse(failure.mark, "is not valid YAML: " + failure.msg);
  }
  if (documents.size() > 1) {
    refuse(documents[1].Mark(), "holds several YAML documents, expected one");
  }
  if (documents.empty()) {
    return;
  }
  map_ = documents.front();
  if (!map_.IsNull() && !map_.IsMap()) {
    refuse(map_.Mark(), "is no list of keys, expected lines like '" + example + "'");
  }
}

void YamlDocument::refuse(const YAML::Mark& mark, const std::string& what) const {
  const std::string place =
      mark.is_null() ? "" : " line " + std::to_string(mark.line + 1) + " column " + std::to_string(mark.column + 1);
  throw InputError{title_ + place + " " + what};
}

void YamlDocument::refuse_other_encodings(const std::string& text) const {
  int line = 1;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = character_length(text, at);
    if (length == 0) {
      throw InputError{title_ + " line " + std::to_string(line) + " is no text in UTF-8, as YAML is"};
    }
    line += text[at] == '\n' ? 1 : 0;
    at += length;
  }
}

}  // namespace udar::petsc
