/// \file  The objects of a labelled mesh in the 36 views of a viewpoint: the content of REVERIE's
/// files of boxes, and the outlines that SOON needs.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/geometry/vec.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/mesh/ray_tracer.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/tasks/goal.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::capture {

/// Selection of objects, and sampling.
struct ObjectBoxOptions {
  /// Limit of the nearest point in view, metres from the eye. REVERIE has boxes within 3 m.
  double farthest = 3.0;
  /// In a picture of 640 x 480 pixels: an object with fewer is not in that view.
  double least_pixels = 50;
  /// Rays around the horizon, shared by all views: a whole number of at least 36. Boxes and
  /// outlines are exact to 360 degrees / this number. That is 1500 pixels / it in the middle of a
  /// picture and up to twice that in its corners. 0: a ray through the centre of each pixel of each
  /// view, some 100 times the time of 720.
  std::uint32_t around = 720;
  /// Categories of mpcat40 that do not count as objects.
  std::vector<std::uint16_t> left_out{mesh::Mpcat40::kVoid,      mesh::Mpcat40::kWall,
                                      mesh::Mpcat40::kFloor,     mesh::Mpcat40::kCeiling,
                                      mesh::Mpcat40::kUnlabeled, mesh::Mpcat40::kMisc};
  int threads = 0;  ///< 0: all cores; never changes a result
};

/// An object as it is seen from a point.
struct ObjectInView {
  std::uint32_t object = 0;  ///< its place in mesh.objects
  double distance = 0;       ///< metres, of its nearest point in view
  double share = 0;          ///< share of all directions that its visible part covers.
  /// Its outline in world headings and elevations, radians. From `left` clockwise to `right`, which
  /// may be the smaller number if it lies across heading 0; `bottom` to `top`.
  double left = 0, right = 0, bottom = 0, top = 0;
  tasks::Direction middle;  ///< the mean direction of its part in view
  /// As tasks::ViewedObject: the views that show it, ascending, and its box in each.
  std::vector<std::uint8_t> views;
  std::vector<std::array<std::int32_t, 4>> boxes;
};

/// The objects in view from a point, in the order of mesh.objects; elevations from -60 to 60
/// degrees, as the 36 views have them. Views are MatterSim's: 12 headings from 0 for each of the
/// elevations -30, 0 and 30 degrees, 640 x 480 pixels, 60 degrees from top to bottom. Runs in the
/// calling thread.
/// \throws ArgumentError for options out of range, a point that is not finite
std::vector<ObjectInView> objects_in_view(const mesh::RayTracer& tracer, Vec3f eye,
                                          const ObjectBoxOptions& options = {});

/// objects_in_view() of all included viewpoints of a scan, as REVERIE's files have it: ids are
/// places in mesh.objects, names are theirs. Viewpoints around which there is no object are there,
/// too, with an empty list.
/// \throws ArgumentError as above; for a mesh without objects; for a viewpoint that stands there
/// twice
tasks::ObjectBoxes compute_object_boxes(const mesh::RayTracer& tracer,
                                        const scan::Connectivity& connectivity,
                                        const ObjectBoxOptions& options = {});

}  // namespace enfilade::capture
