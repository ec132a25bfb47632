#pragma once
/// @file
/// From parameters to what moves: the only assembly there is.

#include <mpi.h>

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "udar/contact/support.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/equations.hpp"
#include "udar/structure/base_motion.hpp"
#include "udar/structure/beam_chain.hpp"
#include "udar/structure/held_motion.hpp"
#include "udar/structure/imported.hpp"
#include "udar/structure/initial_state.hpp"
#include "udar/structure/load.hpp"
#include "udar/structure/network.hpp"
#include "udar/structure/striker.hpp"

namespace udar {

/// @brief What a model is made of; plain values.
struct ModelParameters {
  BeamParameters beam{};
  std::optional<ImportParameters> imported{};  ///< in place of the beam
  std::optional<NetworkParameters> network{};  ///< the same
  FilterParameters filter{};
  double gravity = 9.81;  ///< [m/s^2]
  std::vector<NodalLoad> loads{};
  std::vector<TravellingLoad> travelling_loads{};
  std::vector<BaseMotion> base_motion{};  ///< added up; everything is told in the frame of the base
  std::vector<HeldMotion> held_motion{};  ///< of places that hold the structure, relative to the base
  Damping damping{};
  std::vector<double> damping_ratio{};  ///< as `Equations`
  InitialState initial{};
  /// Masses that strike it, and nodes of it that touch each other; each needs a `Support` that is its face, whose
  /// `strike` counts strikers first.
  std::vector<Striker> strikers{};
  std::vector<NodePair> pairs{};
  std::vector<Support> supports{};
  ContactParameters contact{};

  [[nodiscard]] bool is_beam() const noexcept { return !imported && !network; }
};

/// @brief What is simulated. @note Collective. @throws as `BeamChain`, `ImportedStructure`, `Network`,
/// `StruckStructure`
[[nodiscard]] std::unique_ptr<const Structure> make_structure(MPI_Comm comm, const ModelParameters& parameters);

/// @brief Structure, line, loads and equations, in the order in which they need each other, and what `ImpactDynamics`
/// runs them with. They refer to each other and stay where they are.
struct Model {
  std::unique_ptr<const Structure> structure;
  FilteredStructure line;
  std::vector<HeldMove> moves;
  Loads loads;
  InitialState initial;
  Contacts contacts;
  ContactParameters contact;  ///< the line touches where masses and line are one
  Equations equations;

  /// @param prepare what is done to the line before anything relies on it; empty: nothing
  /// @note Collective. @throws InputError naming what cannot be used, its value, range and unit
  Model(MPI_Comm comm, const ModelParameters& parameters, const std::function<void(FilteredStructure&)>& prepare = {});
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;
  ~Model() = default;
};

}  // namespace udar
