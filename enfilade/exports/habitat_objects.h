/// \file  Episodes of ObjectNav for habitat-lab: objects, from where they are in view, and starts.
/// Points are in our world frame here, and in Habitat's in files.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "enfilade/continuous/habitat_scene_floor.h"
#include "enfilade/exports/habitat_episodes.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/mesh/house.h"
#include "enfilade/mesh/ray_tracer.h"
#include "enfilade/mesh/walkable.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::exports {

/// The body of ObjectNav on Matterport3D, in habitat-lab's settings; its eyes are as high as it is.
inline constexpr mesh::Body kObjectNavBody{
    .radius = 0.18, .height = 0.88, .step = 0.2, .slope = 45};

/// A place from which an object is well in view.
struct ObjectView {
  Vec3f at;                       ///< on the floor
  tasks::StartRotation rotation;  ///< towards the object's middle
  /// Intersection over union of the object's pixels and the middle of an image that shows the
  /// object's middle, (0, 1].
  double iou = 0;
};
/// An object that can be found.
struct ObjectGoal {
  std::size_t object = 0;  ///< its number in the .house file
  std::string name, category;
  Vec3f middle;                   ///< of its box
  std::vector<ObjectView> views;  ///< one at least; the best first
};
/// An episode of ObjectNav.
struct ObjectGoalEpisode {
  std::string category;
  Vec3f start;
  tasks::StartRotation rotation;
  double geodesic_distance = 0;   ///< to the nearest view of any object of the category, metres
  double euclidean_distance = 0;  ///< to the same place
  std::size_t closest = 0;        ///< number of the object that it is a view of
};
/// ObjectNav in one scene.
struct ObjectGoalScene {
  std::string scan;
  std::vector<ObjectGoal> goals;
  std::vector<ObjectGoalEpisode> episodes;
};
/// Finds the objects of ObjectNav's 21 categories and the places within 1 m of them from which they
/// are in view, and draws starts. All places are on both islands: that of the scene's .navmesh and
/// that of ObjectNav's own body. So each tool finds a path, whichever floor it uses.
/// \param own  the floor for kObjectNavBody; lengths are those of its paths
/// \param tracer  of the scene's mesh, whose objects are those of `house`
/// The same arguments give the same result.
ObjectGoalScene draw_object_goals(const std::string& scan, const HabitatIsland& island,
                                  const HabitatIsland& own, const mesh::RayTracer& tracer,
                                  const mesh::House& house, const HabitatDraws& draws);
/// The text of a file that habitat-lab reads as `ObjectNav-v1`.
std::string object_goals_json(std::span<const ObjectGoalScene> scenes);

}  // namespace enfilade::exports
