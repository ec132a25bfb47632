#include "python/motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/run_layout.hpp"
#include "udar/app/echo.hpp"
#include "udar/app/filter_choice.hpp"
#include "udar/app/filter_warnings.hpp"
#include "udar/app/places.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::python {

Motion::Motion(std::shared_ptr<GivenCase> given)
    : given_{std::move(given)},
      model_{given_->comm().get(), given_->input(),
             [this](FilteredStructure& line) { modes_ = app::settle_modes(line, given_->input()); }},
      dynamics_{model_},
      own_references_{references()} {
  const app::Case& input = given_->input();
  petsc::check_unknown_options(comm());
  app::warn_of_implausible(input, *model_.structure);
  app::print_warnings(input, model_.line, modes_, app::support_springs(model_.line, input));
  app::warn_of_places(input, *model_.structure);
  dynamics_.set_guard(input.guard);
  dynamics_.set_stop_request([this] {
    if (interrupt_ == nullptr && PyErr_CheckSignals() != 0) {
      interrupt_ = std::make_exception_ptr(py::error_already_set());
    }
    return interrupt_ != nullptr;
  });
}

PC Motion::preconditioner() const {
  PC preconditioner = nullptr;
  UDAR_CALL(KSPGetPC(solver(), &preconditioner));
  return preconditioner;
}

std::array<PetscInt, 3> Motion::references() const {
  std::array<PetscInt, 3> counts{};
  UDAR_CALL(PetscObjectGetReference(reinterpret_cast<PetscObject>(solver()), counts.data()));
  UDAR_CALL(PetscObjectGetReference(reinterpret_cast<PetscObject>(preconditioner()), counts.data() + 1));
  UDAR_CALL(PetscObjectGetReference(reinterpret_cast<PetscObject>(op()), counts.data() + 2));
  return counts;
}

template <class Body>
void Motion::interruptibly(const Body& body) {
  begun_ = true;
  body();
  int interrupted = interrupt_ != nullptr ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &interrupted, 1, MPI_INT, MPI_MAX, comm());
  if (interrupt_ != nullptr) {
    std::rethrow_exception(std::exchange(interrupt_, nullptr));
  }
  if (interrupted != 0) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }
}

void Motion::advance(double until) {
  interruptibly([&] { dynamics_.advance(until); });
}

void Motion::step() {
  interruptibly([&] { dynamics_.step(); });
}

std::vector<double> Motion::line_position() { return dynamics_.line_position(); }

io::Recording& Motion::record(double interval, const std::vector<std::string>& fields) {
  if (begun_) {
    throw InputError{"a recording begins before the first step"};
  }
  if (!(interval > 0.0) || !std::isfinite(interval)) {
    throw InputError{"interval: " + std::to_string(interval) + " is not allowed, expected a number > 0 [s]"};
  }
  const app::Case& input = given_->input();
  auto recording =
      std::make_unique<io::Recording>(app::make_layout(input, model_.line, model_.contacts, dynamics_.fields()),
                                      interval, input.output.force_window, fields);
  dynamics_.add_observer(*recording);
  if (recording->sampler() != nullptr) {
    dynamics_.add_observer(*recording->sampler());
  }
  return *recordings_.emplace_back(std::move(recording));
}

void let_go(std::shared_ptr<Motion> motion) {
  // Never destroyed: what is left when Python ends has nothing to be destroyed by.
  static auto& waiting = *new std::vector<std::shared_ptr<Motion>>;
  if (motion != nullptr) {
    waiting.push_back(std::move(motion));
  }
  std::erase_if(waiting, [&](const std::shared_ptr<Motion>& one) {
    const auto here = std::ranges::count(waiting, one);
    return one.use_count() > here || !one->held_elsewhere();
  });
}

}  // namespace udar::python
