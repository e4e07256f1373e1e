/// \file  Reads and checks what workers submit.
#pragma once
#include <string_view>

#include "enfilade/graph/graph_set.h"
#include "enfilade/service/collecting/tasks.h"

namespace enfilade::service::collecting {

/// {"instruction", "seconds", "flags"}, as openapi.json has it.
/// \throws InvalidInput with its faults (up to 1000) and their JSON paths; for a body beyond
/// detail::kWorkLimits
SubmittedWork read_instruction(std::string_view body);

/// {"steps": [{"viewpoint", "heading", "elevation", "seconds"}], "camera"}: a walk that an agent
/// could have made, from the item's start along edges of its graph. The content is the list of
/// steps. \throws as above; no message tells more of the item's path than its start
SubmittedWork read_walk(std::string_view body, const Item& item, const graph::GraphSet& graphs);

/// 10 to 2000 characters, three words at least. \throws InvalidInput; where: JSON path
void check_instruction(std::string_view instruction, const char* where);

}  // namespace enfilade::service::collecting
