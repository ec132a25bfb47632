#pragma once
/// @file
/// What a case is made of, as named values: for whoever must tell two cases apart, or show one.

#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace udar {

/// @brief One named value, as text.
struct Parameter {
  std::string name;  ///< with its unit in brackets if it has one: "gravity [m/s^2]"
  std::string value;

  bool operator==(const Parameter&) const = default;
};

/// @brief A list of named values. Numbers have the fewest digits that read back to the same double; a list too long to
/// read is its number of values and their 64-bit FNV-1a hash, the same on every machine.
///
/// Each parameter struct has one `describe`, which takes it apart by a structured binding: a member added to the struct
/// does not compile until it is described, or named as one that does not shape the motion.
class Description {
 public:
  void add(std::string_view name, std::string value) { parameters_.emplace_back(std::string{name}, std::move(value)); }
  void add(std::string_view name, const char* value) { add(name, std::string{value}); }
  void add(std::string_view name, double value);
  void add(std::string_view name, std::span<const double> values);
  /// One value of each of many things.
  template <class Things, class Value>
  void add_each(std::string_view name, const Things& things, const Value& value) {
    std::vector<double> values;
    values.reserve(std::size(things));
    for (const auto& thing : things) {
      values.push_back(static_cast<double>(value(thing)));
    }
    add(name, values);
  }
  /// All values of many things, each thing's number of values before them.
  template <class Things, class Values>
  void add_all(std::string_view name, const Things& things, const Values& of) {
    std::vector<double> values;
    for (const auto& thing : things) {
      const std::span<const double> own = of(thing);
      values.push_back(static_cast<double>(own.size()));
      values.insert(values.end(), own.begin(), own.end());
    }
    add(name, values);
  }

  [[nodiscard]] const std::vector<Parameter>& parameters() const noexcept { return parameters_; }

 private:
  std::vector<Parameter> parameters_;
};

/// @brief What differs between two descriptions, "gravity [m/s^2]: 9.81 there, 1 here", joined by "; "; empty: nothing.
[[nodiscard]] std::string differences(std::span<const Parameter> there, std::span<const Parameter> here);

}  // namespace udar
