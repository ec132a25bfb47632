#include "io/yaml_thing.hpp"

#include <charconv>
#include <limits>
#include <string_view>
#include <system_error>

namespace udar::io {
namespace {

std::string with_unit(const char* unit) { return std::string_view{unit} == "-" ? "" : std::string{" ["} + unit + "]"; }

}  // namespace

YamlThing::YamlThing(const petsc::YamlDocument& document, const YAML::Node& map, std::string what)
    : document_{&document}, mark_{map.Mark()}, what_{std::move(what)} {
  if (map.IsNull()) {
    return;
  }
  if (!map.IsMap()) {
    refuse(mark_, "is no map of keys, expected such as {name: a, ...}");
  }
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) {
      refuse(entry.first.Mark(), "has a key that is no word");
    }
    const std::string& key = entry.first.Scalar();
    if (!entries_.emplace(key, std::pair{entry.first.Mark(), entry.second}).second) {
      refuse(entry.first.Mark(), "gives '" + key + "' again");
    }
  }
}

void YamlThing::refuse(const YAML::Mark& mark, const std::string& what) const {
  document_->refuse(mark, "in " + what_ + ": " + what);
}

void YamlThing::refuse_value(const YAML::Node& value, const char* key, const std::string& expected) const {
  const std::string shown = value.IsScalar()     ? "'" + value.Scalar() + "'"
                            : value.IsSequence() ? "a list of " + std::to_string(value.size())
                            : value.IsMap()      ? "a map"
                                                 : "nothing";
  refuse(value.Mark(), std::string{key} + ": " + shown + " is not allowed, expected " + expected);
}

std::optional<YAML::Node> YamlThing::take(const char* key) {
  asked_.emplace_back(key);
  auto found = entries_.extract(key);
  return found.empty() ? std::nullopt : std::optional{found.mapped().second};
}

double YamlThing::number_of(const YAML::Node& value, const char* key, const std::string& expected,
                            petsc::Range range) const {
  double number = 0.0;
  const std::string_view word = value.IsScalar() ? std::string_view{value.Scalar()} : std::string_view{};
  if (word == ".inf" || word == "inf") {
    number = std::numeric_limits<double>::infinity();
  } else {
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (digits.empty() || status != std::errc{} || end != digits.data() + digits.size()) {
      refuse_value(value, key, expected);
    }
  }
  if (!range.contains(number)) {
    refuse_value(value, key, expected);
  }
  return number;
}

std::optional<Given<std::string>> YamlThing::text(const char* key) {
  const auto value = take(key);
  if (!value) {
    return std::nullopt;
  }
  if (!value->IsScalar() || value->Scalar().empty()) {
    refuse_value(*value, key, "a word");
  }
  return Given<std::string>{value->Scalar(), value->Mark()};
}

Given<std::string> YamlThing::name() {
  const auto given = text("name");
  if (!given) {
    miss("name");
  }
  call(given->value);
  return *given;
}

std::optional<Given<double>> YamlThing::number(const char* key, const char* unit, petsc::Range range) {
  const auto value = take(key);
  if (!value) {
    return std::nullopt;
  }
  return Given<double>{number_of(*value, key, "a number " + range.text() + with_unit(unit), range), value->Mark()};
}

std::optional<Given<std::size_t>> YamlThing::count(const char* key) {
  const auto value = take(key);
  if (!value) {
    return std::nullopt;
  }
  std::size_t count = 0;
  const std::string_view word = value->IsScalar() ? std::string_view{value->Scalar()} : std::string_view{};
  const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (word.empty() || status != std::errc{} || end != word.data() + word.size() || count < 1) {
    refuse_value(*value, key, "a whole number >= 1");
  }
  return Given<std::size_t>{count, value->Mark()};
}

std::optional<Given<std::vector<double>>> YamlThing::numbers(const char* key, const char* unit, petsc::Range range,
                                                             std::size_t size) {
  const auto value = take(key);
  if (!value) {
    return std::nullopt;
  }
  const std::string expected =
      "a list of " + (size > 0 ? std::to_string(size) + " " : "") + "numbers, each " + range.text() + with_unit(unit);
  if (!value->IsSequence() || value->size() == 0 || (size > 0 && value->size() != size)) {
    refuse_value(*value, key, expected);
  }
  Given<std::vector<double>> given{{}, value->Mark()};
  for (const YAML::Node& entry : *value) {
    given.value.push_back(number_of(entry, key, expected, range));
  }
  return given;
}

std::optional<std::vector<Given<std::string>>> YamlThing::words(const char* key) {
  const auto value = take(key);
  if (!value) {
    return std::nullopt;
  }
  std::vector<Given<std::string>> words;
  const auto add = [&](const YAML::Node& entry) {
    if (!entry.IsScalar() || entry.Scalar().empty()) {
      refuse_value(entry, key, "a word, or a list of words");
    }
    words.push_back({entry.Scalar(), entry.Mark()});
  };
  if (!value->IsSequence()) {
    add(*value);
    return words;
  }
  for (const YAML::Node& entry : *value) {
    add(entry);
  }
  return words;
}

std::vector<YamlThing> YamlThing::things(const char* key, const char* each) {
  std::vector<YamlThing> things;
  const auto value = take(key);
  if (value && !value->IsSequence()) {
    refuse_value(*value, key, std::string{"a list of maps, one for each "} + each);
  }
  for (std::size_t i = 0; value && i < value->size(); ++i) {
    things.emplace_back(*document_, (*value)[i], each);
  }
  return things;
}

void YamlThing::finish() const {
  if (entries_.empty()) {
    return;
  }
  std::string expected;
  for (const std::string& key : asked_) {
    expected += (expected.empty() ? "" : ", ") + key;
  }
  const auto& [key, entry] = *entries_.begin();
  refuse(entry.first, "unknown key '" + key + "', expected one of " + expected);
}

}  // namespace udar::io
