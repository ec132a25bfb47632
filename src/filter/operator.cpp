#include "udar/filter/operator.hpp"

#include "udar/filter/assembled.hpp"
#include "udar/filter/hermite_line.hpp"
#include "udar/filter/mixed_line.hpp"
#include "udar/filter/network_operator.hpp"
#include "udar/filter/pc_chain.hpp"
#include "udar/filter/struck_operator.hpp"
#include "udar/petsc/error.hpp"

namespace udar {

const char* FilterOperator::solver_type() const { return kPcChain; }

std::unique_ptr<FilterOperator> make_operator(const Structure& structure, const FilterParameters& parameters) {
  if (&structure.elastic() != &structure) {
    return std::make_unique<StruckOperator>(make_operator(structure.elastic(), parameters), structure.points(),
                                            parameters.shift());
  }
  const BeamChain* chain = structure.chain();
  if (chain == nullptr) {
    if (const Network* network = structure.network(); network != nullptr) {
      return std::make_unique<NetworkOperator>(*network, parameters.shift());
    }
    if (!parameters.filtered()) {
      throw InputError{
          "filter frequency: none is for beams and networks; imported matrices, whose unknowns without mass nothing "
          "finds for given points, need a number > 0 [rad/s]"};
    }
    return std::make_unique<AssembledOperator>(structure.stiffness(), structure.points(), parameters.shift());
  }
  const BeamChain& beam = *chain;
  if (parameters.formulation == Formulation::mixed) {
    return std::make_unique<MixedLine>(beam, parameters.shift());
  }
  if (!parameters.filtered()) {
    throw InputError{"beam formulation: `filter frequency` none needs mixed, which has the moments of a given line"};
  }
  return std::make_unique<HermiteLine>(beam, parameters.shift());
}

}  // namespace udar
