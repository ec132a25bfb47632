#pragma once
/// @file
/// Work and precision of every method that answers what happens when a beam lands on its supports.

#include <mpi.h>
#include <petscsys.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "udar/petsc/options.hpp"

namespace udar::bench {

/// How contact is computed.
enum class ContactMethod : std::uint8_t {
  masses_rk,
  masses_chebyshev,
  masses_impact,
  line_impact,
  line_chebyshev,
  unfiltered,
  modal,
};

/// What the tables list.
struct ContactLists {
  std::vector<ContactMethod> methods{ContactMethod::masses_rk,      ContactMethod::masses_chebyshev,
                                     ContactMethod::masses_impact,  ContactMethod::line_impact,
                                     ContactMethod::line_chebyshev, ContactMethod::unfiltered,
                                     ContactMethod::modal};
  std::vector<double> stiffness{std::numeric_limits<double>::infinity(), 2e9};  ///< of each support, a table each [N/m]
  std::vector<double> frequencies{400.0, 800.0, 1600.0};                        ///< of the filter [rad/s]
  std::vector<double> steps{4e-4, 1e-4, 2.5e-5};                                ///< of the unfiltered beam [s]
  std::vector<PetscInt> modes{16, 24, 32, 48};
  std::vector<PetscInt> reference{96, 104, 112, 120};  ///< modes whose mean counts as true
  PetscInt neighbours = 0;  ///< runs beside each: by 2 % finer frequencies and steps each, two modes more

  /// Reads them.
  void read(petsc::OptionGroup& group);
};

/// Prints a table for each stiffness and writes all of it into contact.csv and contact.json in `directory`.
///
/// The case is that of the options, with the steel beam of example 02 for what they leave open.
/// @note Collective. @throws InputError for an option that a list stands for; FileError
void contact(MPI_Comm comm, const ContactLists& lists, const std::string& directory, long repeats);

}  // namespace udar::bench
