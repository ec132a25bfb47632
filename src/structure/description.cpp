#include "udar/structure/description.hpp"

#include <array>
#include <charconv>
#include <cstdint>
#include <map>

namespace udar {
namespace {

/// A longer list is told by its hash.
constexpr std::size_t kReadable = 120;

void append(std::string& text, double value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(text.empty() ? "" : " ").append(digits.data(), end);
}

std::string hash(std::string_view text) {
  constexpr std::uint64_t kBasis = 14695981039346656037U;
  constexpr std::uint64_t kPrime = 1099511628211U;
  std::uint64_t sum = kBasis;
  for (const char letter : text) {
    sum = (sum ^ static_cast<unsigned char>(letter)) * kPrime;
  }
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), sum, 16).ptr};
}

}  // namespace

void Description::add(std::string_view name, double value) {
  std::string digits;
  append(digits, value);
  add(name, std::move(digits));
}

void Description::add(std::string_view name, std::span<const double> values) {
  std::string all;
  for (const double value : values) {
    append(all, value);
  }
  add(name, all.empty()               ? std::string{"none"}
            : all.size() <= kReadable ? all
                                      : std::to_string(values.size()) + " values with hash " + hash(all));
}

std::string differences(std::span<const Parameter> there, std::span<const Parameter> here) {
  std::map<std::string_view, std::string_view> now;
  for (const Parameter& parameter : here) {
    now.emplace(parameter.name, parameter.value);
  }
  std::string text;
  const auto add = [&text](std::string_view name, std::string_view before, std::string_view after) {
    text.append(text.empty() ? "" : "; ").append(name).append(": ").append(before);
    text.append(" there, ").append(after).append(" here");
  };
  for (const auto& [name, value] : there) {
    const auto found = now.find(name);
    const std::string_view after = found != now.end() ? found->second : "none";
    if (after != value) {
      add(name, value, after);
    }
    now.erase(name);
  }
  for (const auto& [name, value] : now) {
    add(name, "none", value);
  }
  return text;
}

}  // namespace udar
