#pragma once
/// @file
/// A run as its writers see it.

#include <vector>

#include "udar/app/case.hpp"
#include "udar/contact/support.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/io/layout.hpp"
#include "udar/io/point_order.hpp"

namespace udar::app {

/// @brief A quarter of the shortest time in which the model knows a force or a moment to come and go, pi / wf; a step
/// of the unfiltered beam, which knows nothing in between [s].
[[nodiscard]] double longest_sample(const Case& input);

/// @brief What the writers of a run are told. @param fields of the snapshots, in their order. It borrows the masses of
/// `line`. @note Collective.
[[nodiscard]] io::RunLayout make_layout(const Case& input, const FilteredStructure& line, const Contacts& contacts,
                                        std::vector<FieldInfo> fields);

}  // namespace udar::app
