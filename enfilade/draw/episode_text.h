/// \file  What an episode's instruction says, as lines for people: its text, or the turns of its
/// dialogue; language; pieces with their places.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"

namespace enfilade::draw {

/// What stands after the last `<TAR>` of CVDN's texts, without blanks around it; empty if there is
/// none.
std::string target_of(std::string_view text);

/// One line for each of these that there are, UTF-8, not wrapped: "Language: hi-IN"; a turn of the
/// dialogue, "Navigator, after 3 steps: ..."; "Looking for: plant" where the text ends in a target;
/// else the text in quotation marks; a piece, "1. walk to the door (viewpoints 1 to 2)", its places
/// counted from 1; a named part, "region: ...".
std::vector<std::string> episode_lines(const tasks::Episode& episode);

}  // namespace enfilade::draw
