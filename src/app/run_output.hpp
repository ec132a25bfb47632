#pragma once
/// @file
/// The listeners of a run: all of its files, and the line on the terminal.

#include <memory>
#include <optional>
#include <vector>

#include "app/body_motion.hpp"
#include "app/checkpoint_writer.hpp"
#include "app/edge_errors.hpp"
#include "app/field_errors.hpp"
#include "app/support_contacts.hpp"
#include "udar/app/case.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/dynamics/model.hpp"
#include "udar/io/layout.hpp"
#include "udar/io/peaks.hpp"
#include "udar/io/run_directory.hpp"
#include "udar/io/support_forces.hpp"

namespace udar::app {

/// @brief Opens the files of a run and has them written. It must outlive the run.
class RunOutput {
 public:
  /// @param layout what `make_layout` gave @param earlier the state to go on from, in its files if
  /// `input.restart.in_place`; null: the run starts at t = 0
  /// @note Collective. @throws FileError on all ranks
  RunOutput(const Case& input, const Model& model, ImpactDynamics& dynamics, io::RunLayout layout,
            const MotionState* earlier);

  /// Keeps the last good step, and everything before it, of a run that failed. @note Collective.
  void keep_last_step();
  /// @throws FileError on all ranks if somebody took files away meanwhile @note Collective.
  void require_present() const { files_->require_present(); }
  [[nodiscard]] const io::SupportForces& forces() const noexcept { return forces_; }
  [[nodiscard]] const io::Peaks& peaks() const noexcept { return peaks_; }
  [[nodiscard]] const BodyMotion& body_motion() const noexcept { return *body_motion_; }
  [[nodiscard]] const SupportContacts& support_contacts() const noexcept { return *support_contacts_; }
  /// Null without height fields.
  [[nodiscard]] const FieldErrors* field_errors() const noexcept { return field_errors_; }
  /// Null where no support has edges that a mass can leave.
  [[nodiscard]] const EdgeErrors* edge_errors() const noexcept { return edge_errors_; }

 private:
  CheckpointWriter checkpoint_;
  io::SupportForces forces_;
  io::Peaks peaks_;
  std::vector<std::unique_ptr<Observer>> observers_;
  std::optional<io::RunFiles> files_;
  const BodyMotion* body_motion_ = nullptr;
  const SupportContacts* support_contacts_ = nullptr;
  const FieldErrors* field_errors_ = nullptr;
  const EdgeErrors* edge_errors_ = nullptr;
};

}  // namespace udar::app
