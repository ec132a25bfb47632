#include "petsc/yaml_options.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <utility>

#include "petsc/option_keys.hpp"
#include "petsc/yaml_document.hpp"

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

class Reader {
 public:
  Reader(const std::string& text, const std::string& name)
      : document_{"option -options_file: '" + name + "'", text, "beam_length: 10"} {}

  std::vector<GivenOption> read() {
    if (!document_.map().IsNull()) {
      read_map(document_.map(), "");
    }
    return std::move(options_);
  }

 private:
  [[nodiscard]] std::string key_of(const YAML::Node& key, const std::string& prefix) const {
    const std::string name = key.IsScalar() ? key.Scalar() : "";
    if (!is_name(name)) {
      const std::string bare = name.substr(std::min(name.size(), name.find_first_not_of("- ")));
      document_.refuse(key.Mark(), name.empty() ? "has a key that is no word"
                                   : is_name(bare)
                                       ? "has the key '" + name + "', expected it without dash: " + bare
                                       : "has the key '" + name + "', expected a word of letters, digits and _");
    }
    const std::string full = prefix.empty() ? name : prefix + "_" + name;
    if (full.starts_with("options_file") || full.starts_with("options_string")) {
      document_.refuse(key.Mark(), "names further files: give them on the command line, after -options_file each");
    }
    return full;
  }

  void add(const YAML::Mark& mark, const std::string& key, std::optional<std::string> value) {
    const int line = mark.line + 1;
    const auto [first, added] = first_line_.emplace(lower(key), line);
    if (!added) {
      document_.refuse(mark, "gives '" + key + "' again, after line " + std::to_string(first->second));
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
      document_.refuse(list.Mark(), "gives '" + key + "' an empty list; leave the key out");
    }
    if (std::ranges::any_of(list, [](const YAML::Node& entry) { return entry.IsMap(); })) {
      read_objects(key, list);
      return;
    }
    std::string words;
    for (const YAML::Node& entry : list) {
      if (!entry.IsScalar()) {
        document_.refuse(entry.Mark(), "has a list within the list '" + key +
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
        document_.refuse(object.Mark(), "has a plain value among the objects of '" + group +
                                            "', expected all of one kind: " + group +
                                            ": [{position: 2}, {position: 8}]");
      }
      for (const auto& entry : object) {
        const std::string key = key_of(entry.first, group);
        if (!entry.second.IsScalar()) {
          document_.refuse(entry.first.Mark(), "gives '" + key + "' in one of several objects more than a plain value");
        }
        auto column = std::ranges::find(columns, key, &Column::key);
        if (column == columns.end()) {
          column = columns.insert(columns.end(), {.key = key, .mark = entry.first.Mark(), .words = {}});
        }
        if (column->words.size() > row) {
          document_.refuse(entry.first.Mark(), "gives '" + key + "' twice in one object");
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

  YamlDocument document_;
  std::vector<GivenOption> options_;
  std::map<std::string, int> first_line_;  ///< of each key, in lower case: PETSc does not tell them apart
};

}  // namespace

std::vector<GivenOption> read_yaml(const std::string& text, const std::string& name) {
  return Reader{text, name}.read();
}

}  // namespace udar::petsc
