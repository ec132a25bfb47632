#include "udar/integrators/configure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "udar/integrators/located_steps.hpp"
#include "udar/integrators/problem_integrator.hpp"
#include "udar/integrators/ts_chebyshev.hpp"
#include "udar/integrators/ts_impact.hpp"
#include "udar/integrators/ts_modal.hpp"
#include "udar/integrators/ts_moreau.hpp"
#include "udar/petsc/compat.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// Every type there is; the default is the first that knows what is needed and serves so many contact nodes.
constexpr std::array kTypes{kMoreauType, kChebyshevType,           kImpactType, kRungeKuttaType,
                            kEulerType,  kStabilityPreservingType, kModalType};

/// What a user calls a feature.
struct FeatureName {
  Feature feature;
  const char* quantity;
  const char* words;
  const char* without;  // how to do without it
};
constexpr std::array<FeatureName, 19> kFeatureNames{{
    {Feature::filtered, "filter frequency", "the filtered beam", "none"},
    {Feature::unfiltered, "filter frequency", "the unfiltered beam (`filter frequency` none)", "a number > 0 [rad/s]"},
    {Feature::line_contact, "contact surface", "a line that supports hold (`contact surface` line)", "mass"},
    {Feature::moving_supports, "support motion", "supports that move (`support motion`)", "none"},
    {Feature::elastic_supports, "support stiffness", "supports that give way (`support stiffness`)", "inf [N/m]"},
    {Feature::elastic_line, "support stiffness", "supports that give way (`support stiffness`)", "inf [N/m]"},
    {Feature::many_points, "contact surface", "more than 8 contact points on the line (`support width`)", "mass"},
    {Feature::mass_damping, "damping mass", "damping of the masses (`damping mass`)", "0 [1/s]"},
    {Feature::stiffness_damping, "damping stiffness", "damping of the line (`damping stiffness`)", "0 [s]"},
    {Feature::modal_damping, "damping ratio", "damping of each mode (`damping ratio`)", "none"},
    {Feature::friction, "support friction", "supports that rub (`support friction`)", "0"},
    {Feature::contact_laws, "contact law", "supports with a law of contact (`contact law`)", "none"},
    {Feature::laws_of_line, "contact law", "supports with a law of contact (`contact law`)", "none"},
    {Feature::strikers, "striker mass",
     "masses that strike the structure (`striker mass`), nodes that touch each other (`pair normal`)", "none"},
    {Feature::riders, "load axles", "masses that travel along the beam (`load axles`)", "forces alone"},
    {Feature::laws_of_strikers, "striker law",
     "strikers or pairs of nodes with a law of contact (`striker law`, `pair law`)", "none"},
    {Feature::yielding_held, "contact surface", "plastic hinges in a line that supports hold (`contact surface` line)",
     "mass"},
    {Feature::yielding, "beam yield moment", "a beam that yields (`beam yield moment`)", "inf [N m]"},
    {Feature::many_hinges, "beam hinge position", "more than 8 plastic hinges (`beam hinge position`)",
     "up to 8 places [m]"},
}};

/// "a, b or c".
std::string listed(const std::vector<std::string>& words, const char* last_link) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == words.size() ? last_link : ", ") + words[i];
  }
  return text;
}

std::vector<std::string> types_for(Features needed) {
  std::vector<std::string> names;
  for (const IntegratorType& type : kTypes) {
    if (type.can.covers(needed)) {
      names.emplace_back(type.name);
    }
  }
  return names;
}

const IntegratorType* type_of(std::string_view name) {
  const auto* const found =
      std::ranges::find(kTypes, name, [](const IntegratorType& type) { return std::string_view{type.name}; });
  return found != kTypes.end() ? found : nullptr;
}

/// How many nodes of the whole structure masses touch something at. @note Collective.
std::int64_t contact_nodes(const ImpactProblem& problem) {
  std::int64_t nodes = 0;
  for (const ContactSet& set : problem.contact->sets()) {
    nodes += static_cast<std::int64_t>(set.last - set.first);
  }
  MPI_Allreduce(MPI_IN_PLACE, &nodes, 1, MPI_INT64_T, MPI_SUM, problem.equations->points().comm());
  return nodes;
}

/// Where nothing knows all that is needed, the one that knows the beam: the refusal speaks of it.
TSType default_type(const ImpactProblem& problem, Features needed) {
  const std::int64_t nodes = contact_nodes(problem);
  Features beam;
  beam.add(needed.has(Feature::unfiltered) ? Feature::unfiltered : Feature::filtered);
  for (const Features must : {needed, beam}) {
    for (const IntegratorType& type : kTypes) {
      if (type.can.covers(must) && nodes <= type.default_up_to && !needed.meets(type.default_without)) {
        return type.name;
      }
    }
  }
  return kImpactType.name;
}

/// The only place where an integrator is refused what it does not know.
void require_features(const std::string& name, Features can, Features needed) {
  if (can.covers(needed)) {
    return;
  }
  std::vector<std::string> missing;
  std::vector<std::string> there;
  const char* quantity = "";  // of what is missing first, and how to do without it
  const char* without = "";
  for (const FeatureName& feature : kFeatureNames) {
    if (!needed.has(feature.feature)) {
      continue;
    }
    if (can.has(feature.feature)) {
      there.emplace_back(feature.words);
      continue;
    }
    if (missing.empty()) {
      quantity = feature.quantity;
      without = feature.without;
    }
    missing.emplace_back(feature.words);
  }
  const IntegratorType* type = type_of(name);
  const std::string knows = type != nullptr ? std::string{": "} + type->knows : std::string{};
  const std::vector<std::string> others = types_for(needed);
  if (others.empty()) {
    throw InputError{std::string{quantity} + ": " + listed(missing, " and ") + " not allowed with " +
                     listed(there, " and ") + ", expected " + without + "; no integrator knows both. -ts_type " + name +
                     knows};
  }
  throw InputError{"ts type: " + name + " is not allowed with " + listed(missing, " and ") + ", expected " +
                   listed(others, " or ") + knows};
}

PetscBool is_given(const char* option) {
  PetscBool given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, option, &given));
  return given;
}

/// What options change, with udar's defaults. @param fastest no frequency of the masses is higher [rad/s]
void set_options(TS ts, TSType type, double fastest) {
  UDAR_CALL(TSSetType(ts, type));
  // -ts_rk_type alone asks for rk, and rk is 5dp here, not PETSc's 3bs.
  std::array<char, 32> asked{};
  PetscBool type_given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsGetString(nullptr, nullptr, "-ts_type", asked.data(), asked.size(), &type_given));
  const bool by_default = std::string_view{type} == TSRK || is_given("-ts_rk_type") == PETSC_TRUE;
  if (std::string_view{asked.data()} == TSRK || (type_given == PETSC_FALSE && by_default)) {
    UDAR_CALL(TSSetType(ts, TSRK));
    UDAR_CALL(TSRKSetType(ts, TSRK5DP));
  }
  UDAR_CALL(TSSetMaxSteps(ts, std::numeric_limits<PetscInt>::max()));
  UDAR_CALL(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  UDAR_CALL(TSSetMaxTime(ts, 1.0));
  UDAR_CALL(TSSetTimeStep(ts, 0.1 / fastest));
  UDAR_CALL(TSSetTolerances(ts, 1e-8, nullptr, 1e-8, nullptr));
  UDAR_CALL(TSSetErrorIfStepFails(ts, PETSC_FALSE));
  // 5dp is stable on the imaginary axis up to wf h = 1. In free flight nothing tells the error control so, and longer
  // steps would blow up round-off to the tolerance: symmetry would be lost there.
  TSAdapt adapt = nullptr;
  UDAR_CALL(TSGetAdapt(ts, &adapt));
  petsc::use_largest_error(adapt);
  UDAR_CALL(TSAdaptSetStepLimits(adapt, PETSC_DEFAULT, 1.0 / fastest));
  UDAR_CALL(TSSetFromOptions(ts));
}

double end_time_of(TS ts) {
  double end = 0.0;
  UDAR_CALL(TSGetMaxTime(ts, &end));
  if (!(end > 0.0) || !std::isfinite(end)) {
    throw InputError{"ts max time: " + std::to_string(end) + " is not allowed, expected a number > 0 [s]"};
  }
  return end;
}

}  // namespace

void register_integrators() {
  for (const IntegratorType& type : kTypes) {
    if (type.enroll != nullptr) {
      UDAR_CALL(type.enroll());
    }
  }
}

std::string Stepping::name() const {
  TSType type = nullptr;
  UDAR_CALL(TSGetType(ts, &type));
  return type;
}

/// PETSc's own types keep what is around them, whichever it is.
bool Stepping::goes_on_from(std::string_view writer) const {
  const IntegratorType* type = type_of(writer);
  return writer.empty() || writer == name() || (around != nullptr && type != nullptr && type->enroll == nullptr);
}

Features needed_features(const ImpactProblem& problem) {
  const Equations& equations = *problem.equations;
  Features needed{equations.filtered() ? Feature::filtered : Feature::unfiltered};
  const LineContact* const line = equations.line_contact();
  const bool on_line = line != nullptr;
  needed.add(Feature::line_contact, on_line);
  needed.add(Feature::many_points, on_line && (!line->dense() || line->points().size() > kFewPoints));
  needed.add(Feature::mass_damping, equations.damping().mass != 0.0);
  needed.add(Feature::stiffness_damping, equations.damping().stiffness != 0.0);
  needed.add(Feature::modal_damping, !equations.damping_ratio().empty());
  const HingedLine* const hinges = equations.hinges();
  needed.add(Feature::yielding, hinges != nullptr);
  needed.add(Feature::many_hinges, hinges != nullptr && hinges->hinges().size() > kFewPoints);
  needed.add(Feature::yielding_held, hinges != nullptr && on_line);
  needed.add(Feature::strikers, !equations.points().strikes().empty());
  needed.add(Feature::riders, !equations.points().riders().empty());
  for (const Support& support : problem.contact->supports()) {
    needed.add(Feature::moving_supports, support.motion != nullptr);
    needed.add(Feature::friction, support.friction > 0.0);
    const bool law = support.contact_law != nullptr;
    needed.add(on_line               ? Feature::laws_of_line
               : support.strike >= 0 ? Feature::laws_of_strikers
                                     : Feature::contact_laws,
               law);
    needed.add(on_line ? Feature::elastic_line : Feature::elastic_supports, support.elastic() && !law);
  }
  return needed;
}

Stepping configure_stepping(const ImpactProblem& problem, Vec state) {
  const Features needed = needed_features(problem);
  Stepping stepping;
  UDAR_CALL(TSCreate(problem.equations->points().comm(), stepping.ts.put()));
  const TS ts = stepping.ts;
  UDAR_CALL(TSSetProblemType(ts, TS_NONLINEAR));
  register_integrators();
  compose_problem(ts, problem);
  set_options(ts, default_type(problem, needed), problem.equations->frequency_bound());
  UDAR_CALL(TSSetSolution(ts, state));
  stepping.end_time = end_time_of(ts);
  stepping.tolerance = step_tolerance(ts, problem.scale);
  for (const Support& support : problem.contact->supports()) {
    if (support.motion) {
      support.motion->require_smooth(stepping.end_time);
    }
  }
  TSType name = nullptr;
  UDAR_CALL(TSGetType(ts, &name));
  stepping.integrator = integrator_inside(ts);
  if (stepping.integrator != nullptr) {
    require_features(name, stepping.integrator->can(), needed);
    UDAR_CALL(TSSetUp(ts));
    return stepping;
  }
  if (type_of(name) == nullptr) {
    throw InputError{"ts type: '" + std::string{name} + "' is not allowed, expected " +
                     listed(types_for(needed), " or ") +
                     "; the filtered motion is an explicit system Y' = f(t, Y) without Jacobian or splitting, which "
                     "this integrator would need"};
  }
  require_features(name, LocatedSteps::kCan, needed);
  stepping.around = std::make_unique<LocatedSteps>(ts, problem, is_given("-ts_atol") == PETSC_FALSE);
  stepping.integrator = stepping.around.get();
  return stepping;
}

double asked_end_time() {
  double end = 1.0;
  UDAR_CALL(PetscOptionsGetReal(nullptr, nullptr, "-ts_max_time", &end, nullptr));
  return end;
}

double step_tolerance(TS stepper, const MotionScale& scale) {
  double atol = 0.0;
  double rtol = 0.0;
  UDAR_CALL(TSGetTolerances(stepper, &atol, nullptr, &rtol, nullptr));
  return rtol + (is_given("-ts_atol") == PETSC_TRUE ? atol / std::max(scale.length, scale.velocity) : 0.0);
}

}  // namespace udar
