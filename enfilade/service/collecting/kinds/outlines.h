/// \file  Outlines of objects in panoramas, and the object in a direction.
#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

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
/// \param viewpoints the searched ones
Outlines outlines_of(const tasks::ObjectBoxes& objects, const std::string& scan,
                     const std::vector<std::string>& viewpoints, std::int64_t object);
/// {"viewpoint": [[[heading, elevation], four times], ...]}, radians
std::string outlines_json(const Outlines& outlines);
/// Parses a text of outlines_json(). \pre the text is one of those
Outlines parse_outlines(const std::string& json);

/// The object around a viewpoint that a direction points at: of several the one with the smallest
/// box. None if no box has it.
std::optional<std::int64_t> object_at(const tasks::ObjectBoxes& objects, const std::string& scan,
                                      const std::string& viewpoint,
                                      const tasks::Direction& direction);

/// "plant" of "plant#pot": what people call it.
std::string category_of(const std::string& name);

}  // namespace enfilade::service::collecting::kinds
