#pragma once
/// @file
/// A case turned into what moves.

#include <mpi.h>

#include <functional>

#include "udar/app/case.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/motion/equations.hpp"
#include "udar/structure/beam_chain.hpp"
#include "udar/structure/load.hpp"

namespace udar::app {

/// @brief Beam, line, loads and equations of a case, the same for every program that moves one. They refer to each
/// other and stay where they are.
struct Model {
  BeamChain beam;
  FilteredStructure line;
  Loads loads;
  Equations equations;

  /// @param input   with its filter frequency chosen; must outlive this object
  /// @param prepare what is done to the line before anything relies on it; empty: nothing
  /// @note Collective. @throws InputError naming option, value, range and unit
  Model(MPI_Comm comm, const Case& input, const std::function<void(FilteredStructure&)>& prepare = {});
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;
  ~Model() = default;

  /// The motion of the case from its start.
  [[nodiscard]] ImpactDynamics motion() { return {equations, input_->supports, input_->initial, input_->contact}; }

 private:
  const Case* input_;
};

}  // namespace udar::app
