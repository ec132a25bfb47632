#pragma once
/// @file
/// How a structure leaves its first contact.

#include <deque>
#include <optional>
#include <vector>

namespace udar::app {

/// @brief How the structure leaves its first contact.
struct Rebound {
  std::optional<double>
      impact;  ///< velocity with which the centre of mass came [m/s], y up; empty: it lay there, or did not
  std::optional<double> velocity;      ///< [m/s]; empty if it does not leave
  std::optional<double> contact_time;  ///< from the first contact to the row at which that velocity is reached [s]
};

/// @brief Finds the speed with which the centre of mass passes the height of its first contact on the way back, from
/// rows: v^2 + 2 g y does not change in flight, so that neither the end of the contact nor the rows must be met
/// exactly.
class ReboundSearch {
 public:
  /// @brief The centre of mass.
  struct Row {
    double time = 0.0;      ///< [s]
    double height = 0.0;    ///< [m]
    double velocity = 0.0;  ///< [m/s], y up
  };

  /// @param gravity downward [m/s^2]
  explicit ReboundSearch(double gravity) : gravity_{gravity} {}

  /// @param row later than the last @param first_contact [s]; empty: none up to this row
  void add(const Row& row, std::optional<double> first_contact);
  [[nodiscard]] Rebound found() const;

  /// @name For a restart, in any number of values
  /// @{
  [[nodiscard]] std::vector<double> saved() const;
  /// @throws InputError if these are none of `saved`
  void restore(const std::vector<double>& saved);
  /// @}

 private:
  [[nodiscard]] double speed(const Row& row) const;
  void begin(double first_contact);

  /// A row whose speed was, to rounding, the largest up to it.
  struct Fast {
    double time;
    double speed;
  };

  double gravity_;
  std::optional<Row> before_;  // the last without contact
  std::optional<Row> impact_;  // as it meets what it hits
  bool turned_ = false;
  bool over_ = false;
  double best_ = 0.0;
  std::deque<Fast> fast_;
};

}  // namespace udar::app
