/// \file  Bodies of Habitat-Sim: poses and the actions that change them, in float32.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "enfilade/continuous/habitat/path_finder.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::continuous::habitat {

/// A rotation as Habitat's scene graph keeps it.
struct Rotation {
  float x = 0, y = 0, z = 0, w = 1;
  friend bool operator==(const Rotation&, const Rotation&) = default;
};

/// Place and direction of a body, or of a sensor in its body's frame. It looks along -z.
struct Pose {
  Vec3f position;
  Rotation rotation;
  friend bool operator==(const Pose&, const Pose&) = default;
};

/// Habitat's actions without noise.
enum class Motion : std::uint8_t {
  kMoveForward,
  kMoveBackward,
  kMoveLeft,
  kMoveRight,
  kMoveUp,
  kMoveDown,
  kTurnLeft,  ///< a body about its y axis
  kTurnRight,
  kLookUp,  ///< a sensor about its x axis
  kLookDown,
  kLookLeft,  ///< a sensor about its y axis
  kLookRight,
  kRotateSensorClockwise,  ///< a sensor about its z axis
  kRotateSensorAntiClockwise,
};
constexpr std::array<std::string_view, 14> names_of(Motion /*enum*/) {
  return {"move_forward",
          "move_backward",
          "move_left",
          "move_right",
          "move_up",
          "move_down",
          "turn_left",
          "turn_right",
          "look_up",
          "look_down",
          "look_left",
          "look_right",
          "rotate_sensor_clockwise",
          "rotate_sensor_anti_clockwise"};
}
/// Whether it moves the body, not its sensors alone. Then the floor's filter follows it.
bool moves_body(Motion motion) noexcept;

/// Where bodies may go; null: anywhere.
struct Ground {
  const PathFinder* floor = nullptr;
  Moves moves = Moves::kSlide;
};

/// The radians of an action's degrees: multiplied by pi and divided by 180 in double, then rounded
/// to float, as Habitat's angles are. In float alone, 10 degrees would be another angle.
float radians_of_turn(double degrees);
/// Ends a move: `asked` becomes the place that a body reaches. \pre ground.floor is not null
/// \returns whether the body was stopped by a wall
bool filter_move(Vec3f& asked, Vec3f from, const Ground& ground);

/// Does one action. \param amount  metres, or degrees
/// \returns whether the body was stopped by a wall
bool act(Pose& pose, Motion motion, double amount, const Ground& ground);

/// A step ahead as Habitat's follower tries it. It copies the pose as a matrix, which changes the
/// last bits. \returns whether the body was stopped by a wall
bool try_ahead(Pose& pose, double metres, const Ground& ground);

/// The pose of a sensor in the world.
Pose in_world(const Pose& body, const Pose& sensor);

}  // namespace enfilade::continuous::habitat
