#pragma once
/// @file
/// A case as Python gives it, and what every call into udar has around it.

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "python/handles.hpp"
#include "udar/app/case.hpp"
#include "udar/petsc/option_set.hpp"
#include "udar/petsc/session.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::python {

/// @brief A case that has been read and checked, with the options that its model is going to read.
class GivenCase {
 public:
  /// @param source a case file, a mapping of options, or None @param options win over them
  /// @note Collective. @throws as `app::read_case`
  GivenCase(const py::object& source, const py::object& comm, const py::dict& options);

  [[nodiscard]] const Communicator& comm() const noexcept { return comm_; }
  [[nodiscard]] const app::Case& input() const noexcept { return input_; }
  /// Those in force, files included, as text.
  [[nodiscard]] py::dict options();

  /// @brief Runs `body`, which is udar's own, with the options of this case in force; warnings become Python's, on rank
  /// 0. @throws what `body` does; pybind11::error_already_set where a warning is an error, or within another such call
  template <class Body>
  std::invoke_result_t<Body> within(const Body& body) {
    if constexpr (std::is_void_v<std::invoke_result_t<Body>>) {
      {
        const Scope scope{*this};
        body();
      }
      tell_warnings();
    } else {
      decltype(auto) result = [&]() -> std::invoke_result_t<Body> {
        const Scope scope{*this};
        return body();
      }();
      tell_warnings();
      return result;
    }
  }

 private:
  /// One at a time: udar is for one thread, and not for what its own solvers call.
  class Alone {
   public:
    Alone();
    Alone(const Alone&) = delete;
    Alone& operator=(const Alone&) = delete;
    ~Alone();
  };
  class Scope {
   public:
    explicit Scope(GivenCase& given);

   private:
    Alone alone_;
    petsc::RecordedErrors errors_;
    petsc::QuietText text_;
    petsc::OptionSet::InForce options_;
  };

  void read(const py::object& source, const py::dict& options);
  void tell_warnings() const;

  Communicator comm_;
  petsc::OptionSet options_;
  app::Case input_;
};

/// Adds the class `Case`.
void add_case(py::module_& module);

}  // namespace udar::python
