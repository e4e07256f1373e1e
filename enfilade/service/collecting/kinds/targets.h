/// \file  Objects as targets: their outlines in panoramas, the one in a direction, and those at the
/// end of a path.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/regions.h"
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

/// The objects of a data set. What it refers to outlives it. An object of this class belongs to one
/// thread.
class KnownObjects {
 public:
  /// \param boxes null: the data set has none
  /// \param rooms null: the data set does not name them; then what one viewpoint sees is a room
  KnownObjects(const tasks::ObjectBoxes* boxes, const graph::GraphSet& graphs,
               const scan::RegionMap* rooms)
      : boxes_(boxes), graphs_(graphs), rooms_(rooms) {}

  bool has_boxes() const { return boxes_ != nullptr; }
  /// Targets of a path: the object or the region of its annotation. If there is none, the objects
  /// that its last viewpoint shows largest. Those are objects that people would ask for
  /// (tasks::can_be_asked_for()), and the only ones of their names in the room: "the chest of
  /// drawers".
  /// \param most of the latter
  /// \returns none if no such object with a box is there
  std::vector<PathTarget> targets_of(const tasks::PathAnnotation& path, std::size_t most);

 private:
  using Names = std::set<std::string, std::less<>>;
  std::optional<PathTarget> target_of(const std::string& scan,
                                      const tasks::ViewedObject& object) const;
  std::optional<PathTarget> named_target(const std::string& scan, std::int64_t object) const;
  const Names& single_names(const std::string& scan, const std::string& viewpoint);

  const tasks::ObjectBoxes* boxes_;
  const graph::GraphSet& graphs_;
  const scan::RegionMap* rooms_;
  /// By scan and room (or viewpoint): the names that one object of it has.
  std::map<std::pair<std::string, std::string>, Names> single_names_;
};

/// Annotations of REVERIE or CVDN, if their first entry looks like it, else of R2R.
/// \throws InvalidInput as tasks::parse_annotations()
tasks::Annotations parse_any(std::string_view json, const std::string& file,
                             const std::string& split);

}  // namespace enfilade::service::collecting::kinds
