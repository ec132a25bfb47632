#include <vector>

#include "io/paraview_files.hpp"
#include "io/writers.hpp"
#include "udar/io/vtkhdf.hpp"
#include "udar/io/xdmf.hpp"

namespace udar::io {
namespace {

class FieldWriter final : public Observer {
 public:
  FieldWriter(const RunLayout& layout, const std::string& folder, const std::shared_ptr<ResultsFile>& results,
              double interval)
      : results_{results}, interval_{interval}, times_{results->field_times()} {
    if (interval_ > 0.0 || !times_.empty()) {
      xdmf_ = std::make_unique<XdmfFile>(layout, folder + "results.xdmf", kResults, "results.vtkhdf:/VTKHDF/Points");
      rows_shown_ = static_cast<std::size_t>(xdmf_->rows());
      vtkhdf_ = std::make_unique<VtkHdfFile>(layout, folder + "results.vtkhdf", kResults);
      paraview_ = std::make_unique<ParaViewFiles>(layout, folder);
    }
  }

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override {
    results_->append_fields(state);
    times_.push_back(state.time);
    paraview_->see(state);
    show_rows();
    if (rows_shown_ >= 2 * rows_in_pictures_) {  // written anew each time
      write_pictures();
    }
  }

  void flush() override {
    results_->flush();
    show_rows();
    if (xdmf_) {
      xdmf_->sync();
    }
  }

  void save(MotionState& state) const override {
    results_->save(state);
    if (xdmf_) {
      xdmf_->save(state);
      paraview_->save(state);
    }
  }

  void finish() override {
    flush();
    write_pictures();
    results_.leave();
  }

 private:
  /// Shows ParaView the rows that results.h5 has on the disk.
  void show_rows() {
    for (; rows_shown_ < results_->field_rows_on_disk(); ++rows_shown_) {
      xdmf_->append(times_[rows_shown_]);
    }
  }

  void write_pictures() {
    if (rows_shown_ > 0) {
      vtkhdf_->write(std::span{times_}.first(rows_shown_));
      paraview_->write(std::span{times_}.first(rows_shown_));
    }
    rows_in_pictures_ = rows_shown_;
  }

  SharedResults results_;
  double interval_;
  std::unique_ptr<XdmfFile> xdmf_;      ///< null without fields, as the next
  std::unique_ptr<VtkHdfFile> vtkhdf_;  ///< the same rows for other readers
  std::unique_ptr<ParaViewFiles> paraview_;
  std::vector<double> times_;  ///< of the rows [s]
  std::size_t rows_shown_ = 0;
  std::size_t rows_in_pictures_ = 0;  ///< of those that are written anew
};

}  // namespace

std::unique_ptr<Observer> make_field_writer(const RunLayout& layout, const std::string& folder,
                                            const std::shared_ptr<ResultsFile>& results, double interval) {
  return std::make_unique<FieldWriter>(layout, folder, results, interval);
}

}  // namespace udar::io
