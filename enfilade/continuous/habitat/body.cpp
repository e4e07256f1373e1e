#include "enfilade/continuous/habitat/body.h"

#include <cmath>
#include <cstddef>

#include "enfilade/geometry/angle.h"

namespace enfilade::continuous::habitat {
namespace {

// The order of each sum below is that of Habitat's scene graph: the last bits depend on it.

// A move with less than this is not all of it: squared metres, added in double.
constexpr double kCollisionSlack = 1e-5;

enum Axis : std::size_t { kX, kY, kZ };

// What a motion does: along an axis of the pose, or about it.
struct MotionKind {
  bool turns;
  Axis axis;
  float sign;
  bool body;
};
constexpr std::array<MotionKind, names_of(Motion{}).size()> kMotionKinds{{
    {false, kZ, -1, true},   // forward
    {false, kZ, 1, true},    // backward
    {false, kX, -1, true},   // left
    {false, kX, 1, true},    // right
    {false, kY, 1, false},   // up: the filter would take a body back
    {false, kY, -1, false},  // down
    {true, kY, 1, true},     // turn left
    {true, kY, -1, true},    // turn right
    {true, kX, 1, false},    // look up
    {true, kX, -1, false},   // look down
    {true, kY, 1, false},    // look left
    {true, kY, -1, false},   // look right
    {true, kZ, 1, false},    // clockwise, of the picture: Habitat turns the sensor the other way
    {true, kZ, -1, false},   // anticlockwise
}};

const MotionKind& kind_of(Motion motion) { return kMotionKinds[static_cast<std::size_t>(motion)]; }

float square_of_length(Vec3f v) { return v.x * v.x + v.y * v.y + v.z * v.z; }

// First b, then a.
Rotation product_of(const Rotation& a, const Rotation& b) {
  return {a.w * b.x + b.w * a.x + (a.y * b.z - a.z * b.y),
          a.w * b.y + b.w * a.y + (a.z * b.x - a.x * b.z),
          a.w * b.z + b.w * a.z + (a.x * b.y - a.y * b.x),
          a.w * b.w - (a.x * b.x + a.y * b.y + a.z * b.z)};
}

Rotation with_length_1(const Rotation& q) {
  const float norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {q.x / norm, q.y / norm, q.z / norm, q.w / norm};
}

Rotation turn_about(Axis axis, float radians) {
  const float sine = std::sin(radians / 2);
  return {axis == kX ? sine : 0, axis == kY ? sine : 0, axis == kZ ? sine : 0,
          std::cos(radians / 2)};
}

// Where an axis points after a rotation.
Vec3f turned_axis(const Rotation& q, Axis axis) {
  const float xx = 2 * q.x * q.x;
  const float yy = 2 * q.y * q.y;
  const float zz = 2 * q.z * q.z;
  const float xy = 2 * q.x * q.y;
  const float xz = 2 * q.x * q.z;
  const float yz = 2 * q.y * q.z;
  const float xw = 2 * q.x * q.w;
  const float yw = 2 * q.y * q.w;
  const float zw = 2 * q.z * q.w;
  if (axis == kX) return {1 - yy - zz, xy + zw, xz - yw};
  if (axis == kY) return {xy - zw, 1 - xx - zz, yz + xw};
  return {xz + yw, yz - xw, 1 - xx - yy};
}

using Axes = std::array<Vec3f, 3>;

// The rotation that turns axes so.
Rotation rotation_of(const Axes& m) {
  const float trace = m[0].x + m[1].y + m[2].z;
  if (trace > 0) {
    const float root = std::sqrt(trace + 1);
    const float part = 0.5F / root;
    return {(m[1].z - m[2].y) * part, (m[2].x - m[0].z) * part, (m[0].y - m[1].x) * part,
            root * 0.5F};
  }
  const auto at = [&m](std::size_t column, std::size_t row) {
    return row == kX ? m[column].x : row == kY ? m[column].y : m[column].z;
  };
  std::size_t i = at(kY, kY) > at(kX, kX) ? kY : kX;
  if (at(kZ, kZ) > at(i, i)) i = kZ;
  const std::size_t j = (i + 1) % 3;
  const std::size_t k = (i + 2) % 3;
  const float root = std::sqrt(at(i, i) - at(j, j) - at(k, k) + 1);
  const float part = root == 0 ? 0 : 0.5F / root;
  std::array<float, 3> vector{};
  vector[i] = root * 0.5F;
  vector[j] = (at(i, j) + at(j, i)) * part;
  vector[k] = (at(i, k) + at(k, i)) * part;
  return {vector[kX], vector[kY], vector[kZ], (at(j, k) - at(k, j)) * part};
}

// Where z points after a rotation that was taken out of a matrix again, with the lengths of its
// axes, which are 1 but for rounding.
Vec3f z_axis_out_of_matrix(const Rotation& q) {
  Axes axes{turned_axis(q, kX), turned_axis(q, kY), turned_axis(q, kZ)};
  const float length = std::sqrt(square_of_length(axes[kZ]));
  for (Vec3f& axis : axes) axis = (1 / std::sqrt(square_of_length(axis))) * axis;
  return length * turned_axis(rotation_of(axes), kZ);
}

}  // namespace

bool moves_body(Motion motion) noexcept { return kind_of(motion).body; }

float radians_of_turn(double degrees) { return static_cast<float>(degrees * kPi / 180); }

bool filter_move(Vec3f& asked, Vec3f from, const Ground& ground) {
  const Vec3f wanted = asked;
  const Vec3f reached = ground.floor->step(from, wanted, ground.moves);
  asked = (reached - wanted) + wanted;  // not always `reached`: Habitat adds the difference
  return square_of_length(reached - from) + kCollisionSlack < square_of_length(wanted - from);
}

bool act(Pose& pose, Motion motion, double amount, const Ground& ground) {
  const MotionKind& kind = kind_of(motion);
  const Vec3f from = pose.position;
  if (kind.turns) {
    const float angle = kind.sign * radians_of_turn(amount);
    pose.rotation = with_length_1(product_of(pose.rotation, turn_about(kind.axis, angle)));
  } else {
    const float metres = kind.sign * static_cast<float>(amount);
    pose.position = from + metres * turned_axis(pose.rotation, kind.axis);
  }
  // A turn is filtered, too: it puts a body onto the floor.
  return kind.body && ground.floor != nullptr && filter_move(pose.position, from, ground);
}

bool try_ahead(Pose& pose, double metres, const Ground& ground) {
  const Vec3f from = pose.position;
  pose.position = from + -static_cast<float>(metres) * z_axis_out_of_matrix(pose.rotation);
  return ground.floor != nullptr && filter_move(pose.position, from, ground);
}

Pose in_world(const Pose& body, const Pose& sensor) {
  const Vec3f at = sensor.position;
  const Vec3f turned = at.x * turned_axis(body.rotation, kX) +
                       at.y * turned_axis(body.rotation, kY) +
                       at.z * turned_axis(body.rotation, kZ);
  return {turned + body.position, product_of(body.rotation, sensor.rotation)};
}

}  // namespace enfilade::continuous::habitat
