/// \file  What the generator of homes itself knows of free ways, to check navigation graphs by.
#pragma once
#include "enfilade/homes/home.h"

namespace enfilade::tests {

/// Can a body (graph::EdgeOptions' width, lowest, highest) move straight from above floor point `a`
/// to above floor point `b`, by the generator's own knowledge of walls, doors, furniture and
/// stairs? `slack` metres are taken off (positive) or added to the body on all sides.
bool passage_is_free(const homes::Home& home, Vec3d a, Vec3d b, double width, double lowest,
                     double highest, double slack = 0);

}  // namespace enfilade::tests
