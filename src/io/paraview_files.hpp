#pragma once
/// @file
/// paraview-state.py and supports.vtp: a run as ParaView shows it at once.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/support_faces.hpp"
#include "udar/io/layout.hpp"
#include "udar/motion/observer.hpp"

namespace udar {
struct MotionState;
}

namespace udar::io {

/// @brief A state of ParaView in Python that shows the rows of the fields, and a VTK file with supports and strikers.
///
/// At the head of the state stand what one may want otherwise: by how much displacements and radii are exaggerated,
/// what the structure is coloured by, which time comes first; chosen by what was seen of the rows so far.
/// @note All calls are collective; rank 0 writes. Files appear whole or not at all.
/// @see docs/output.md
class ParaViewFiles {
 public:
  /// @param[in] folder ends with a slash
  ParaViewFiles(const RunLayout& layout, std::string folder);

  /// Sees a row of the fields. @note Two reductions of a few numbers.
  void see(const Snapshot& state);
  /// @param[in] times of the first rows [s]
  /// @throws FileError on all ranks
  void write(std::span<const double> times) const;
  /// What it has seen, for who goes on.
  void save(MotionState& state) const;

 private:
  /// What the structure may be coloured by.
  struct Shown {
    FileField field;
    double largest = 0.0;  ///< size of any row seen
  };

  [[nodiscard]] double size_in(const Snapshot& state, const FileField& field) const;
  [[nodiscard]] double weight(const FileField& field) const;
  [[nodiscard]] std::string favourite() const;
  [[nodiscard]] std::string head() const;
  [[nodiscard]] std::string state() const;
  [[nodiscard]] std::string supports(std::span<const double> times) const;

  MPI_Comm comm_;
  std::string folder_;
  const MassPoints* points_;
  std::shared_ptr<const FileRows> rows_;
  Scene scene_;
  SupportFaces faces_;
  bool tubes_;
  double thinnest_ = 0.0;  ///< radius of the thinnest tube [m]; 0: there are none
  FileField moved_;        ///< tells where the structure is
  std::string contact_;    ///< sum of the flags
  std::vector<Shown> shown_;
  std::vector<std::vector<PointShare>> tips_;  ///< what makes the height of each striker's tip
  std::vector<double> tip_start_;              ///< height of the place it has in pictures [m]
  std::vector<double> tip_rows_;               ///< height above that [m], of each row seen those of all strikers
  double farthest_ = 0.0;                      ///< largest displacement seen [m]
  double best_ = 0.0;                          ///< largest weighted size in the row to be shown first
  double time_ = 0.0;                          ///< of that row [s]
};

}  // namespace udar::io
