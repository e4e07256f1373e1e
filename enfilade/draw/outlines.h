/// \file  Where an object is around a viewpoint: closed lines on the sphere of directions, and how
/// they are drawn in views. Signs in pictures that a text can refer to ("set of
/// marks"; Yang et al. 2023).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/image/image.h"
#include "enfilade/tasks/goal.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::draw {

/// A closed line around an object, as seen from a viewpoint.
struct Outline {
  /// Unit vectors in the world frame, in order; the last joins the first. Each is at most a few
  /// degrees from the next, so that straight lines between them will do.
  std::vector<Vec3d> rim;
  std::string label;  ///< "plant", ASCII; may be empty
};

/// Number of a viewpoint's views by MatterSim's viewIndex, and their directions: 12 headings from
/// north on, three rows (30 degrees down, level, up).
/// \pre view < kViews
inline constexpr std::size_t kViews = 36;
tasks::Direction direction_of_view(std::uint8_t view);

/// The unit vector of a direction, world frame; and back: heading in [0, 2 pi).
Vec3d unit_vector(const tasks::Direction& direction);
tasks::Direction direction_of(Vec3d vector);

/// The outline of a box in one of the 36 pictures of 640 x 480 pixels and 60 degrees: x, y of the
/// left top corner, width, height, pixels.
/// \pre view < kViews
Outline outline_of_box(std::uint8_t view, const std::array<std::int32_t, 4>& box);
/// The outline of SOON's quadrilateral, whose sides are straight in heading and elevation. Each
/// goes the shorter way round, also across heading 0.
Outline outline_of_corners(const std::array<tasks::Direction, 4>& corners);

/// Index of the object's box to show. It touches the fewest edges of its picture, so that most of
/// the object is in it. Among several, with a direction, that of the picture nearest to it;
/// without, the one nearest to the middle of its picture.
/// \pre object.visible()
std::size_t best_box(const tasks::ViewedObject& object,
                     const std::optional<tasks::Direction>& towards = {});

/// The outlines of a goal's object around a viewpoint: REVERIE's box of the object, all SOON's
/// boxes there. Empty for other goals, and if nothing is seen.
/// \param objects boxes by viewpoint; null: unknown
/// \param towards as in best_box()
std::vector<Outline> goal_outlines(const graph::NavGraph& graph, const tasks::Goal& goal,
                                   ViewpointIndex viewpoint, const tasks::ObjectBoxes* objects,
                                   const std::optional<tasks::Direction>& towards = {});

/// The middle of an outline. \pre it has a rim
tasks::Direction centre_of(const Outline& outline);

/// Draws a line of yellow with a dark edge, and the label above it, on a view. Parts behind or
/// beside the view are left out.
/// \param vertical_field_of_view in (0, pi)
/// \throws ArgumentError unless the picture has 3 channels
void draw_outline(image::Image8& picture, const Outline& outline, const tasks::Direction& look,
                  Radians vertical_field_of_view);
/// A sign: its middle, in pixels from the left top corner, and one to four letters, ASCII.
struct Mark {
  double x = 0, y = 0;
  std::string text;
};

/// Draws each as light letters on a dark plate with a light rim, in the order of the list. Plates
/// that would cross the edge of the picture are moved inside. One whose middle is outside of the
/// picture is left out.
/// \pre 3 channels
void draw_marks(image::Image8& picture, std::span<const Mark> marks);

}  // namespace enfilade::draw
