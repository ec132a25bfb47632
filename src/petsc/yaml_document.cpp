#include "petsc/yaml_document.hpp"

#include <yaml-cpp/eventhandler.h>

#include <sstream>
#include <string_view>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar::petsc {
namespace {

/// Counts documents: yaml-cpp finds one after the other, without end, where something is left that begins none, such as
/// a comma.
class Documents : public YAML::EventHandler {
 public:
  [[nodiscard]] int count() const noexcept { return count_; }
  [[nodiscard]] const YAML::Mark& last() const noexcept { return last_; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    ++count_;
    last_ = mark;
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnAlias(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                const std::string& /*value*/) override {}
  void OnSequenceStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {}
  void OnMapEnd() override {}

 private:
  int count_ = 0;
  YAML::Mark last_;
};

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
  Documents documents;
  try {
    std::istringstream stream{text};
    YAML::Parser parser{stream};
    while (documents.count() < 2 && parser.HandleNextDocument(documents)) {
    }
    map_ = documents.count() == 1 ? YAML::Load(text) : YAML::Node{};
  } catch (const YAML::Exception& failure) {
    refuse(failure.mark, "is not valid YAML: " + failure.msg);
  }
  if (documents.count() > 1) {
    refuse(documents.last(), "holds several YAML documents, expected one");
  }
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
