/// \file  Reads and checks what workers submit.
#pragma once
#include <string_view>

#include "enfilade/graph/graph_set.h"
#include "enfilade/service/collecting/tasks.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::service::collecting {

/// {"instruction", "seconds", "flags"}, as openapi.json has it.
/// \throws InvalidInput with its faults (up to 1000) and their JSON paths; for a body beyond
/// detail::kWorkLimits
SubmittedWork read_instruction(std::string_view body);

/// {"steps": [{"viewpoint", "heading", "elevation", "seconds"}], "camera"}: a trajectory that an
/// agent could have made, from the item's start along edges of its graph. The content is the list
/// of steps.
/// \throws InvalidInput; no message gives away more of the item's path than its start
SubmittedWork read_walk(std::string_view body, const Item& item, const graph::GraphSet& graphs);

/// {"steps", "camera", "point": {"heading", "elevation"}}: a trajectory, and the direction of its
/// worker's answer at its end.
/// \param objects candidates of the answer; null: only the item's outlines
/// \throws as read_walk()
SubmittedWork read_find(std::string_view body, const Item& item, const graph::GraphSet& graphs,
                        const tasks::ObjectBoxes* objects);

/// {"instruction", "words": [{"word", "start", "end"}], "steps", "spoken", "seconds", "flags"}: the
/// spoken words along the item's path, one by one, and the steps. Words are those of the
/// instruction between blanks; they begin one after another. Steps may go back and forth on the
/// path, but must reach its end.
/// \throws as read_walk()
SubmittedWork read_guide(std::string_view body, const Item& item, const graph::GraphSet& graphs);

/// 10 to 2000 characters, three words at least. \throws InvalidInput; where: JSON path
void check_instruction(std::string_view instruction, const char* where);

}  // namespace enfilade::service::collecting
