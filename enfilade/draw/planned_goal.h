/// \file  An episode for people: its instruction as lines, its goal as a floor plan marks it.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::draw {

/// The viewpoints that a goal is about, other than the end of the reference path.
struct PlannedGoal {
  /// How the goal is marked.
  enum class GoalMark : std::uint8_t {
    kTurningPoint,  ///< R2R-Back: a diamond, with the success distance around it
    kObject,        ///< REVERIE: squares on the viewpoints that see the object
    kRegion,        ///< CVDN: its viewpoints stand on a yellow floor
    kBoxes,         ///< SOON: squares on the viewpoints that have a box of the object
  };
  GoalMark kind = GoalMark::kTurningPoint;
  std::vector<ViewpointIndex> viewpoints;  ///< ascending, each once; may be empty
  std::string label;                       ///< for the legend: "sees the plant (3 viewpoints)"
};

/// The mark of a path's goal. No value for goals that are the end of the path, and hidden ones.
/// \param what  the object's name, for the legend: "plant"; may be empty
std::optional<PlannedGoal> planned_goal(const tasks::ReferencePath& path,
                                        std::string_view what = {});

/// The name of a goal's object or region, without details after a number sign. REVERIE: as in the
/// boxes. CVDN: the instruction's end (`<TAR> plant`). SOON: the first name that a box has, else
/// the instruction's `obj_name`; "The vase." without article and full stop. Empty without a name.
std::string name_of_goal(const tasks::EpisodeSet& episodes, const tasks::Episode& episode,
                         const tasks::ObjectBoxes* objects);

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
