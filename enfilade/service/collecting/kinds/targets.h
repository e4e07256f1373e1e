/// \file  Objects as targets: their outlines in panoramas, the one in a direction, and those at the
/// end of a path.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/goal.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::service::collecting::kinds {

/// A box of a view as directions from its viewpoint: left top, right top, right bottom, left
/// bottom. Its edges are parts of great circles.
using Outline = std::array<tasks::Direction, 4>;

/// \param view MatterSim's viewIndex, 0 to 35  \param box x, y, width, height in its picture of
/// 640 x 480 pixels and 60 degrees
Outline outline_of(std::uint8_t view, const std::array<std::int32_t, 4>& box);
/// Whether a direction lies in an outline, its edges included.
bool contains(const Outline& outline, const tasks::Direction& direction);

/// The outlines of an object by the viewpoints that see it, the largest first. For a wide object
/// each view has a part.
using Outlines = std::map<std::string, std::vector<Outline>, std::less<>>;
/// {"viewpoint": [[[heading, elevation], four times], ...]}, radians
std::string outlines_json(const Outlines& outlines);
/// Parses a text of outlines_json(). \pre the text is one of those
Outlines parse_outlines(const std::string& json);

/// The object around a viewpoint that a direction points at: of several the one with the smallest
/// box. None if no box has it.
std::optional<std::int64_t> object_at(const tasks::ObjectBoxes& objects, const std::string& scan,
                                      const std::string& viewpoint,
                                      const tasks::Direction& direction);

/// A goal, as WorkItem has it.
struct PathTarget {
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
std::vector<PathTarget> targets_of(const tasks::PathAnnotation& path, const KnownObjects& known,
                                   std::size_t most);

/// Annotations of REVERIE or CVDN, if their first entry looks like it, else of R2R.
/// \throws InvalidInput as tasks::parse_annotations()
tasks::Annotations parse_any(std::string_view json, const std::string& file,
                             const std::string& split);

}  // namespace enfilade::service::collecting::kinds
