#pragma once
/// @file
/// The observers that write a run's files, one for each kind of content. They share results.h5: each joins it, and
/// whoever finishes last closes it.

#include <memory>
#include <string>
#include <utility>

#include "udar/io/layout.hpp"
#include "udar/io/peaks.hpp"
#include "udar/io/results_file.hpp"
#include "udar/io/support_forces.hpp"
#include "udar/motion/observer.hpp"

namespace udar::io {

constexpr const char* kResults = "results.h5";

/// @brief One writer's part in results.h5.
class SharedResults {
 public:
  explicit SharedResults(std::shared_ptr<ResultsFile> file) : file_{std::move(file)} { file_->join(); }
  ResultsFile* operator->() const noexcept { return file_.get(); }
  /// Nothing more comes. @note Collective; as `ResultsFile::close`.
  void leave() const { file_->leave(); }

 private:
  std::shared_ptr<ResultsFile> file_;
};

/// @brief Looks for peaks of forces between rows. @param interval between samples [s]
[[nodiscard]] std::unique_ptr<Observer> make_force_sampler(SupportForces& forces, double interval);

/// @name Each makes the writer of some files; `folder` ends with a slash, `interval` is between rows [s]
/// @{
/// gauges.csv.
[[nodiscard]] std::unique_ptr<Observer> make_gauge_writer(const RunLayout& layout, const std::string& folder,
                                                          double interval);
/// strikers.csv.
[[nodiscard]] std::unique_ptr<Observer> make_striker_writer(const RunLayout& layout, const std::string& folder,
                                                            double interval);
/// places.csv.
[[nodiscard]] std::unique_ptr<Observer> make_place_writer(const RunLayout& layout, const std::string& folder,
                                                          double interval);
/// axles.csv, of those with masses.
[[nodiscard]] std::unique_ptr<Observer> make_axle_writer(const RunLayout& layout, const std::string& folder,
                                                         double interval);
/// energy.csv and /energy.
[[nodiscard]] std::unique_ptr<Observer> make_energy_writer(const RunLayout& layout, const std::string& folder,
                                                           const std::shared_ptr<ResultsFile>& results,
                                                           double interval);
/// impacts.csv, rests.csv, /impacts and /rests.
[[nodiscard]] std::unique_ptr<Observer> make_event_writer(const RunLayout& layout, const std::string& folder,
                                                          const std::shared_ptr<ResultsFile>& results, double interval);
/// contact.csv, /contact and /supports.
[[nodiscard]] std::unique_ptr<Observer> make_contact_writer(const RunLayout& layout, const std::string& folder,
                                                            const std::shared_ptr<ResultsFile>& results,
                                                            double interval, SupportForces& forces);
/// envelope.csv and /envelope. @param[out] peaks known after `finish`; may be null
[[nodiscard]] std::unique_ptr<Observer> make_envelope_writer(const RunLayout& layout, const std::string& folder,
                                                             const std::shared_ptr<ResultsFile>& results,
                                                             double interval, Peaks* peaks);
/// /fields, results.xdmf, results.vtkhdf, paraview-state.py and supports.vtp.
[[nodiscard]] std::unique_ptr<Observer> make_field_writer(const RunLayout& layout, const std::string& folder,
                                                          const std::shared_ptr<ResultsFile>& results, double interval);
/// @}

}  // namespace udar::io
