/// \file  An episode's instruction as lines for people: its text, or the turns of its dialogue;
/// language; pieces with their viewpoints.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"

namespace enfilade::draw {

/// The text after the last `<TAR>` of CVDN's texts, without blanks around it; may be empty.
std::string target_of(std::string_view text);

/// Lines of UTF-8, not wrapped, for the parts that the instruction has:
/// - "Language: hi-IN"
/// - a turn of the dialogue, "Navigator, after 3 steps: ..."
/// - "Looking for: plant" if the text ends in a target; else the text in quotation marks
/// - a piece, "1. walk to the door (viewpoints 1 to 2)", its viewpoints counted from 1
/// - a named part, "region: ..."
std::vector<std::string> episode_lines(const tasks::Episode& episode);

}  // namespace enfilade::draw
