/// \file  Targets at the end of a path.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::service::collecting::kinds {

/// A goal, as Item has it.
struct Target {
  std::optional<std::int64_t> object;
  std::string name;                 ///< its name for people
  std::vector<std::string> region;  ///< viewpoints of the graph; sorted, not empty
  std::string outlines;             ///< outlines_json()
};

/// Sources of object boxes. Both outlive it.
struct KnownObjects {
  const tasks::ObjectBoxes* boxes = nullptr;  ///< null: the data set has none
  const graph::GraphSet& graphs;
};

/// Targets of a path: the object or the region of its annotation. If there is none, the objects
/// that its last viewpoint shows largest, one of each name.
/// \param most of the latter
/// \returns none if no object with a box is there
std::vector<Target> targets_of(const tasks::PathAnnotation& path, const KnownObjects& known,
                               std::size_t most);

/// Annotations of REVERIE or CVDN, if their first entry looks like it, else of R2R.
/// \throws InvalidInput as tasks::parse_annotations()
tasks::Annotations parse_any(std::string_view json, const std::string& file,
                             const std::string& split);

}  // namespace enfilade::service::collecting::kinds
