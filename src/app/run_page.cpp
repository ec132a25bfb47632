#include "app/run_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iomanip>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "udar/app/places.hpp"
#include "udar/structure/network.hpp"

namespace udar::app {
namespace {

std::string four_digits(double value) {
  std::ostringstream text;
  text << std::setprecision(4) << value;
  return text.str();
}

std::string clock_time(const std::optional<double>& time) { return time ? four_digits(*time) + " s" : "never"; }

/// How a support is told from the others.
std::string support_words(const Case& input, std::size_t index) {
  const Support& support = input.supports[index];
  if (const auto striker = input.striker_of(support)) {
    return "striker at " + words_of(input.strikers[*striker].place);
  }
  if (const auto pair = input.pair_of(support)) {
    return "pair " + std::to_string(*pair) + " of nodes";
  }
  if (support.boxed()) {
    return "box";
  }
  return std::isinf(support.width) ? "all along" : "x = " + four_digits(support.position) + " m";
}

/// The supports with the largest forces, in their order.
std::vector<std::size_t> hardest_hit(const io::SummaryContact& contact, std::size_t most) {
  std::vector<std::size_t> all(contact.peak_support_force.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto force = [&](std::size_t index) { return std::abs(contact.peak_support_force[index]); };
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(std::min(most, all.size()));
  std::ranges::partial_sort(
      all, middle, [&](std::size_t a, std::size_t b) { return force(a) != force(b) ? force(a) > force(b) : a < b; });
  std::sort(all.begin(), middle);
  return {all.begin(), middle};
}

void add_supports(const Case& input, const io::SummaryContact& contact, std::ostringstream& page) {
  constexpr std::size_t kMost = 6;
  const std::vector<std::size_t> shown = hardest_hit(contact, kMost);
  if (shown.empty()) {
    return;
  }
  page << std::left << std::setw(32) << "support" << std::right << std::setw(14) << "largest force" << std::setw(16)
       << "impulse" << std::setw(16) << "first contact" << std::setw(16) << "last contact" << '\n';
  for (const std::size_t index : shown) {
    page << std::setw(3) << index << "  " << std::left << std::setw(27) << support_words(input, index) << std::right
         << std::setw(14) << with_unit(contact.peak_support_force[index], "N") << std::setw(16)
         << with_unit(contact.support_impulse[index], "N s") << std::setw(16)
         << clock_time(contact.support_first_contact[index]) << std::setw(16)
         << clock_time(contact.support_last_contact[index]) << '\n';
  }
  if (contact.support_impulse.size() > shown.size()) {
    page << "     " << contact.support_impulse.size() - shown.size() << " more with smaller forces, in summary.json\n";
  }
  page << "     forces are means over " << with_unit(*contact.peak_force_window, "s") << '\n';
}

std::string where_and_when(const io::Peak& peak, const Structure& structure) {
  std::ostringstream text;
  text << std::setprecision(4);
  if (peak.member >= 0) {
    text << "in member " << peak.member;
  } else if (structure.chain() != nullptr) {
    text << "at x = " << peak.x << " m";
  } else {
    text << "at (" << peak.x << ", " << peak.y << ", " << peak.z << ") m";
  }
  text << ", t = " << peak.time << " s";
  return text.str();
}

/// What is shown of the largest values: key in summary.json, words, unit; empty: a share of 1.
struct Shown {
  const char* key;
  const char* words;
  const char* unit;
};

constexpr std::array kShown{Shown{"max_moment", "moment", "N m"},
                            Shown{"max_shear", "shear", "N"},
                            Shown{"max_axial_force", "axial force", "N"},
                            Shown{"max_shear_y", "shear along y", "N"},
                            Shown{"max_shear_z", "shear along z", "N"},
                            Shown{"max_torque", "torque", "N m"},
                            Shown{"max_moment_y", "moment about y", "N m"},
                            Shown{"max_moment_z", "moment about z", "N m"},
                            Shown{"max_elastic_force", "elastic force", "N"},
                            Shown{"max_bending_stress", "stress", "Pa"},
                            Shown{"max_utilisation", "utilisation", ""},
                            Shown{"plastic_rotation", "left in a hinge", "rad"},
                            Shown{"max_deflection", "deflection", "m"},
                            Shown{"max_displacement", "displacement", "m"}};

void add_line(std::ostringstream& page, const char* words, const std::string& text) {
  page << std::left << std::setw(16) << words << text << '\n';
}

/// Of those of one unit what is no more than rounding beside the largest is left out.
void add_peaks(const Structure& structure, const io::Summary& summary, std::ostringstream& page) {
  constexpr double kRounding = 1e-9;
  std::map<std::string, double> largest;
  std::vector<std::pair<Shown, io::Peak>> known;
  for (const Shown& shown : kShown) {
    const auto found = std::ranges::find(summary.peaks, shown.key, &decltype(summary.peaks)::value_type::first);
    if (found != summary.peaks.end() && found->second) {
      known.emplace_back(shown, *found->second);
      largest[shown.unit] = std::max(largest[shown.unit], found->second->value);
    }
  }
  for (const auto& [shown, peak] : known) {
    if (peak.value > kRounding * largest.at(shown.unit)) {
      const std::string value =
          *shown.unit != '\0' ? with_unit(peak.value, shown.unit) : four_digits(100.0 * peak.value) + " %";
      add_line(page, shown.words, value + " " + where_and_when(peak, structure));
    }
  }
}

/// @param extent of the structure [m]
void add_contact(const Case& input, double extent, const io::Summary& summary, std::ostringstream& page) {
  constexpr double kRounding = 1e-9;
  const io::SummaryContact& contact = summary.contact;
  const bool faces = std::ranges::any_of(input.supports, [](const Support& support) { return support.strike < 0; });
  if (faces && contact.first_contact_time && contact.min_line_gap && *contact.min_line_gap < -kRounding * extent) {
    add_line(page, "penetration",
             with_unit(-*contact.min_line_gap, "m") + " at x = " + four_digits(*contact.min_line_gap_x) +
                 " m, t = " + four_digits(*contact.min_line_gap_time) + " s");
  }
  if (contact.impact_velocity) {
    add_line(page, "rebound",
             (contact.rebound_velocity ? four_digits(*contact.rebound_velocity) + " m/s" : std::string{"none"}) +
                 " of the centre of mass, which came with " + four_digits(*contact.impact_velocity) + " m/s");
  }
}

/// What was brought in since the start, and where it is now, each in joules; parts that are nothing are left out.
void add_energies(const io::Summary& summary, std::ostringstream& page) {
  const EnergyLedger& energy = summary.energy;
  struct Part {
    const char* words;
    double value;
  };
  const auto text_of = [&energy](std::initializer_list<Part> parts) {
    std::ostringstream text;
    for (const auto& [words, value] : parts) {
      if (std::abs(value) > 1e-9 * energy.scale) {
        text << (text.tellp() > 0 ? ", " : "") << words << ' ' << with_unit(value, "J");
      }
    }
    return text.tellp() > 0 ? text.str() : std::string{"nothing"};
  };
  add_line(page, "energy now",
           text_of({{"motion", energy.kinetic},
                    {"strain", energy.line_strain},
                    {"filter springs", energy.fictitious_springs},
                    {"springs of supports", energy.support_springs},
                    {"lost in impacts", energy.lost_in_impacts},
                    {"lost in dampers", energy.lost_in_dampers},
                    {"lost in hinges", energy.lost_in_hinges},
                    {"radiated", energy.radiated}}));
  add_line(page, "brought in",
           text_of({{"by gravity and loads", energy.load_work - (energy.load_potential - energy.initial_potential)},
                    {"by supports that move", energy.support_work},
                    {"by the base", energy.base_work}}) +
               "; balance off by " + four_digits(100.0 * summary.energy.drift()) + " %");
}

/// The first of them, as far as there is room.
void add_warnings(const io::Summary& summary, std::ostringstream& page) {
  constexpr std::size_t kMost = 3;
  constexpr std::size_t kWidth = 120 - 16;
  const std::size_t shown = std::min(kMost, summary.warnings.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const std::string& text = summary.warnings[i];
    add_line(page, i == 0 ? "warnings" : "", text.size() <= kWidth ? text : text.substr(0, kWidth - 4) + " ...");
  }
  if (summary.warnings.size() > shown) {
    add_line(page, "", std::to_string(summary.warnings.size() - shown) + " more, in summary.json");
  }
}

}  // namespace

std::string with_unit(double value, const std::string& unit) {
  struct Prefix {
    double factor;
    const char* name;
  };
  constexpr std::array kPrefixes{Prefix{1e9, "G"}, Prefix{1e6, "M"}, Prefix{1e3, "k"}, Prefix{1.0, ""}};
  // Of a number that four digits round up to the next prefix, that prefix.
  constexpr double kRounded = 0.99995;
  const double size = std::abs(value);
  for (const auto& [factor, name] : kPrefixes) {
    if (size >= kRounded * factor && std::isfinite(value)) {
      return four_digits(value / factor) + " " + name + unit;
    }
  }
  return size > 0.0 && std::isfinite(value) ? four_digits(1e3 * value) + " m" + unit : four_digits(value) + " " + unit;
}

std::string run_page(const Case& input, const Structure& structure, const io::Summary& summary) {
  std::ostringstream page;
  add_supports(input, summary.contact, page);
  add_peaks(structure, summary, page);
  add_contact(input, structure.points().largest_extent(), summary, page);
  add_energies(summary, page);
  add_warnings(summary, page);
  return page.str();
}

}  // namespace udar::app
