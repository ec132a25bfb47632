#pragma once
/// @file
/// A model and its motion in memory, as Python has them.

#include <pybind11/pybind11.h>

#include <array>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "python/given_case.hpp"
#include "python/handles.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/filter/modes.hpp"
#include "udar/io/recording.hpp"

namespace udar::python {

/// @brief What is simulated and where it stands. PETSc objects that Python holds may outlive what Python has of it: it
/// stays until they are gone (`let_go`).
class Motion {
 public:
  /// @note Collective. @throws as `Model` and `ImpactDynamics`; InputError for options that nobody knows
  explicit Motion(std::shared_ptr<GivenCase> given);

  [[nodiscard]] GivenCase& given() const noexcept { return *given_; }
  [[nodiscard]] const Model& model() const noexcept { return model_; }
  [[nodiscard]] const ImpactDynamics& dynamics() const noexcept { return dynamics_; }
  [[nodiscard]] FilteredStructure& line() noexcept { return model_.line; }
  [[nodiscard]] const MassPoints& points() const noexcept { return model_.structure->points(); }
  [[nodiscard]] MPI_Comm comm() const noexcept { return given_->comm().get(); }

  /// @brief Up to the first step that reaches a time [s], infinite: the end. @note Collective.
  /// @throws as `ImpactDynamics::solve`; KeyboardInterrupt on all ranks where one was interrupted
  void advance(double until);
  /// One step. @throws as `advance`
  void step();
  /// Line positions now [m]. @note Collective.
  [[nodiscard]] std::vector<double> line_position();
  /// @brief Listens from the first step on. @note Collective. @throws InputError if that has been; as `io::Recording`
  io::Recording& record(double interval, const std::vector<std::string>& fields);

  /// @name The filter's, borrowed
  /// @{
  [[nodiscard]] KSP solver() const noexcept { return model_.line.solver(); }
  [[nodiscard]] PC preconditioner() const;
  [[nodiscard]] Mat op() const noexcept { return model_.line.op(); }
  /// @}
  /// Whether somebody else has a reference to one of them.
  [[nodiscard]] bool held_elsewhere() const { return references() != own_references_; }

 private:
  [[nodiscard]] std::array<PetscInt, 3> references() const;
  template <class Body>
  void interruptibly(const Body& body);

  std::shared_ptr<GivenCase> given_;
  std::vector<Mode> modes_;  // the lowest
  Model model_;
  ImpactDynamics dynamics_;
  std::vector<std::unique_ptr<io::Recording>> recordings_;
  std::exception_ptr interrupt_;  // Python's, on this rank
  bool begun_ = false;
  std::array<PetscInt, 3> own_references_{};
};

/// @brief Gives a motion up; it goes at once, or, where Python still holds its solver or matrix, with the next one that
/// is given up after these.
void let_go(std::shared_ptr<Motion> motion);

/// Adds the class `Model`.
void add_model(py::module_& module);

/// Adds the class `Recording`.
void add_recording(py::module_& module);

/// @brief A recording with the motion that it listens to.
struct RecordingOfMotion {
  RecordingOfMotion(std::shared_ptr<Motion> of, io::Recording& made) : motion{std::move(of)}, recording{&made} {}
  RecordingOfMotion(const RecordingOfMotion&) = delete;
  RecordingOfMotion& operator=(const RecordingOfMotion&) = delete;
  ~RecordingOfMotion() { let_go(std::move(motion)); }

  std::shared_ptr<Motion> motion;
  io::Recording* recording;
};

}  // namespace udar::python
