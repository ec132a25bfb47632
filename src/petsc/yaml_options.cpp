#include "petsc/yaml_options.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <string_view>
#include <utility>

#include "petsc/option_keys.hpp"
#include "udar/petsc/error.hpp"

namespace udar::petsc {
namespace {

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_name(const std::string& key) {
  const auto part_of_name = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  return !key.empty() && std::isalpha(static_cast<unsigned char>(key.front())) != 0 &&
         std::ranges::all_of(key, part_of_name);
}

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

class Reader {
 public:
  explicit Reader(std::string name) : name_{std::move(name)} {}

  std::vector<GivenOption> read(const std::string& text) {
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
    if (!documents.empty() && !documents.front().IsNull()) {
      if (!documents.front().IsMap()) {
        refuse(documents.front().Mark(), "is no list of keys, expected lines like 'beam_length: 10'");
      }
      read_map(documents.front(), "");
    }
    return std::move(options_);
  }

 private:
  [[noreturn]] void refuse(const YAML::Mark& mark, const std::string& what) const {
    const std::string place =
        mark.is_null() ? "" : " line " + std::to_string(mark.line + 1) + " column " + std::to_string(mark.column + 1);
    throw InputError{"option -options_file: '" + name_ + "'" + place + " " + what};
  }

  void refuse_other_encodings(const std::string& text) const {
    int line = 1;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t length = character_length(text, at);
      if (length == 0) {
        throw InputError{"option -options_file: '" + name_ + "' line " + std::to_string(line) +
                         " is no text in UTF-8, as YAML is"};
      }
      line += text[at] == '\n' ? 1 : 0;
      at += length;
    }
  }

  [[nodiscard]] std::string key_of(const YAML::Node& key, const std::string& prefix) const {
    const std::string name = key.IsScalar() ? key.Scalar() : "";
    if (!is_name(name)) {
      const std::string bare = name.substr(std::min(name.size(), name.find_first_not_of("- ")));
      refuse(key.Mark(), name.empty()    ? "has a key that is no word"
                         : is_name(bare) ? "has the key '" + name + "', expected it without dash: " + bare
                                         : "has the key '" + name + "', expected a word of letters, digits and _");
    }
    const std::string full = prefix.empty() ? name : prefix + "_" + name;
    if (full.starts_with("options_file") || full.starts_with("options_string")) {
      refuse(key.Mark(), "names further files: give them on the command line, after -options_file each");
    }
    return full;
  }

  void add(const YAML::Mark& mark, const std::string& key, std::optional<std::string> value) {
    const int line = mark.line + 1;
    const auto [first, added] = first_line_.emplace(lower(key), line);
    if (!added) {
      refuse(mark, "gives '" + key + "' again, after line " + std::to_string(first->second));
    }
    options_.push_back({.key = "-" + key, .value = std::move(value), .line = line});
  }

  void read_map(const YAML::Node& map, const std::string& prefix) {
    for (const auto& entry : map) {
      const std::string key = key_of(entry.first, prefix);
      const YAML::Node& value = entry.second;
      if (value.IsMap()) {
        read_map(value, key);
      } else if (value.IsSequence()) {
        read_list(entry.first.Mark(), key, value);
      } else {
        add(entry.first.Mark(), key, value.IsNull() ? std::nullopt : std::optional{value.Scalar()});
      }
    }
  }

  void read_list(const YAML::Mark& mark, const std::string& key, const YAML::Node& list) {
    if (list.size() == 0) {
      refuse(list.Mark(), "gives '" + key + "' an empty list; leave the key out");
    }
    if (std::ranges::any_of(list, [](const YAML::Node& entry) { return entry.IsMap(); })) {
      read_objects(key, list);
      return;
    }
    std::string words;
    for (const YAML::Node& entry : list) {
      if (!entry.IsScalar()) {
        refuse(entry.Mark(), "has a list within the list '" + key +
                                 "', or an empty entry, expected plain values: " + key + ": [2, 8]");
      }
      words += (words.empty() ? "" : ",") + entry.Scalar();
    }
    add(mark, key, words);
  }

  /// `support: [{position: 2, width: 0.5}, {position: 8}]` as -support_position 2,8 -support_width 0.5,default.
  void read_objects(const std::string& group, const YAML::Node& objects) {
    struct Column {
      std::string key;
      YAML::Mark mark;
      std::vector<std::string> words;
    };
    std::vector<Column> columns;
    std::size_t row = 0;
    for (const YAML::Node& object : objects) {
      if (!object.IsMap()) {
        refuse(object.Mark(), "has a plain value among the objects of '" + group +
                                  "', expected all of one kind: " + group + ": [{position: 2}, {position: 8}]");
      }
      for (const auto& entry : object) {
        const std::string key = key_of(entry.first, group);
        if (!entry.second.IsScalar()) {
          refuse(entry.first.Mark(), "gives '" + key + "' in one of several objects more than a plain value");
        }
        auto column = std::ranges::find(columns, key, &Column::key);
        if (column == columns.end()) {
          column = columns.insert(columns.end(), {.key = key, .mark = entry.first.Mark(), .words = {}});
        }
        if (column->words.size() > row) {
          refuse(entry.first.Mark(), "gives '" + key + "' twice in one object");
        }
        column->words.resize(row, kDefaultWord);
        column->words.push_back(entry.second.Scalar());
      }
      ++row;
    }
    for (Column& column : columns) {
      column.words.resize(row, kDefaultWord);
      std::string words;
      for (const std::string& word : column.words) {
        words += (words.empty() ? "" : ",") + word;
      }
      add(column.mark, column.key, words);
    }
  }

  std::string name_;
  std::vector<GivenOption> options_;
  std::map<std::string, int> first_line_;  ///< of each key, in lower case: PETSc does not tell them apart
};

}  // namespace

std::vector<GivenOption> read_yaml(const std::string& text, const std::string& name) { return Reader{name}.read(text); }

}  // namespace udar::petsc
