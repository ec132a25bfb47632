#include "udar/integrators/sweep_tally.hpp"

#include "udar/petsc/log.hpp"

namespace udar {
namespace {

// NOLINTNEXTLINE(readability-non-const-parameter): MPI_User_function
void combine(void* from, void* into, int* length, MPI_Datatype* /*type*/) {
  for (int i = 0; i < *length; ++i) {
    const Tally& a = static_cast<const Tally*>(from)[i];
    Tally& b = static_cast<Tally*>(into)[i];
    for (std::size_t k = 0; k < Tally::maxima; ++k) {
      b.most[k] = std::max(a.most[k], b.most[k]);
    }
    for (std::size_t k = 0; k < kBins; ++k) {
      b.kick[k] += a.kick[k];
      b.first[k] = std::min(a.first[k], b.first[k]);
    }
  }
}

}  // namespace

TallyReduction::TallyReduction() {
  MPI_Type_contiguous(static_cast<int>(sizeof(Tally)), MPI_BYTE, &type_);
  MPI_Type_commit(&type_);
  MPI_Op_create(combine, 1, &op_);
}

TallyReduction::~TallyReduction() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized == 0) {
    MPI_Op_free(&op_);
    MPI_Type_free(&type_);
  }
}

void TallyReduction::operator()(Tally& tally, MPI_Comm comm) const {
  const petsc::LogScope reduction{petsc::log_events().reduction};
  MPI_Allreduce(MPI_IN_PLACE, &tally, 1, type_, op_, comm);
}

}  // namespace udar
