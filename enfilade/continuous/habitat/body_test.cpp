#include "enfilade/continuous/habitat/body.h"

#include <gtest/gtest.h>

#include <cmath>

#include "enfilade/geometry/angle.h"
#include "tests/support/flat_floor.h"

namespace enfilade::continuous::habitat {
namespace EN_UNIT {

using testing::flat_floor;

constexpr Ground kAnywhere;

float norm(const Rotation& q) { return std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w); }

// 6 x 6 m; bodies keep 0.1 m and one cell away from its rim.
PathFinder square() { return flat_floor({{-3, -3, 3, 3}}); }
constexpr float kEdge = 2.85F;

Pose facing(Vec3f position, double degrees) {
  const double half = degrees * kPi / 360;
  return {position, {0, static_cast<float>(std::sin(half)), 0, static_cast<float>(std::cos(half))}};
}

Vec3f moved(Motion motion, Pose pose) {
  const Vec3f from = pose.position;
  EXPECT_FALSE(act(pose, motion, 0.5F, kAnywhere));
  return pose.position - from;
}

void expect_near(Vec3f a, Vec3f b, float most = 1e-6F) {
  EXPECT_NEAR(a.x, b.x, most);
  EXPECT_NEAR(a.y, b.y, most);
  EXPECT_NEAR(a.z, b.z, most);
}

TEST(HabitatBody, TurnsAreExact) {
  for (const float by : {15.0F, 30.0F, 10.0F, 22.5F, 0.7F}) {
    const auto half = static_cast<float>(static_cast<double>(by) * kPi / 360);
    Pose pose = facing({1, 2, 3}, 20);
    // The sum of two angles about one axis: a complex number.
    float sine = pose.rotation.y;
    float cosine = pose.rotation.w;
    for (int turn = 0; turn < 50; ++turn) {
      const bool left = turn % 7 < 4;
      const float s = left ? std::sin(half) : -std::sin(half);
      const float y = sine * std::cos(half) + cosine * s;
      const float w = cosine * std::cos(half) - sine * s;
      sine = y / std::sqrt(y * y + w * w);
      cosine = w / std::sqrt(y * y + w * w);
      EXPECT_FALSE(act(pose, left ? Motion::kTurnLeft : Motion::kTurnRight, by, kAnywhere));
      ASSERT_EQ(pose.rotation, (Rotation{0, sine, 0, cosine})) << by << ", turn " << turn;
      ASSERT_NEAR(norm(pose.rotation), 1, 2e-7);
    }
    EXPECT_EQ(pose.position, (Vec3f{1, 2, 3}));
  }
}

// In float alone 10 degrees would be 0.17453294, and 7.2, which are no float, 0.12566370.
TEST(HabitatBody, DegreesBecomeRadiansInDoubleAndThenFloat) {
  EXPECT_EQ(radians_of_turn(10), 0.17453292F);
  EXPECT_EQ(radians_of_turn(12.5), 0.21816616F);
  EXPECT_EQ(radians_of_turn(22.5), 0.39269909F);
  EXPECT_EQ(radians_of_turn(7.7), 0.13439035F);
  EXPECT_EQ(radians_of_turn(-7.7), -0.13439035F);
  EXPECT_NE(radians_of_turn(7.2), radians_of_turn(static_cast<double>(7.2F)));
  int rounded = 0;  // angles that degrees in float would change
  for (int tenths = 1; tenths < 3600; ++tenths) {
    const double by = tenths / 10.0;
    const auto exact = static_cast<float>(by * kPi / 180);
    ASSERT_EQ(radians_of_turn(by), exact) << by;
    Pose pose;
    act(pose, Motion::kTurnLeft, by, kAnywhere);
    const float sine = std::sin(exact / 2);
    const float cosine = std::cos(exact / 2);
    const float norm = std::sqrt(sine * sine + cosine * cosine);
    ASSERT_EQ(pose.rotation, (Rotation{0, sine / norm, 0, cosine / norm})) << by;
    rounded += radians_of_turn(static_cast<float>(by)) != exact ? 1 : 0;
  }
  EXPECT_GT(rounded, 500);
}

TEST(HabitatBody, ErrorsOfTurnsGrow) {
  Pose pose;
  for (int turn = 0; turn < 24; ++turn) act(pose, Motion::kTurnLeft, 15, kAnywhere);
  EXPECT_NE(pose.rotation.y, 0);
  // 24 roundings of float32.
  EXPECT_NEAR(std::abs(pose.rotation.w), 1, 1e-5);
  EXPECT_NEAR(pose.rotation.y, 0, 1e-5);
}

TEST(HabitatBody, MovesAlongItsOwnAxes) {
  const Pose ahead = facing({7, -2, 5}, 0);
  EXPECT_EQ(moved(Motion::kMoveForward, ahead), (Vec3f{0, 0, -0.5F}));
  EXPECT_EQ(moved(Motion::kMoveBackward, ahead), (Vec3f{0, 0, 0.5F}));
  EXPECT_EQ(moved(Motion::kMoveLeft, ahead), (Vec3f{-0.5F, 0, 0}));
  EXPECT_EQ(moved(Motion::kMoveRight, ahead), (Vec3f{0.5F, 0, 0}));
  EXPECT_EQ(moved(Motion::kMoveUp, ahead), (Vec3f{0, 0.5F, 0}));
  EXPECT_EQ(moved(Motion::kMoveDown, ahead), (Vec3f{0, -0.5F, 0}));
  Pose left = ahead;  // looks along -x
  act(left, Motion::kTurnLeft, 90, kAnywhere);
  expect_near(moved(Motion::kMoveForward, left), {-0.5F, 0, 0});
  expect_near(moved(Motion::kMoveLeft, left), {0, 0, 0.5F});
  expect_near(moved(Motion::kMoveUp, left), {0, 0.5F, 0});
}

TEST(HabitatBody, SensorsTurnAboutEachAxis) {
  const auto turned = [](Motion motion) {
    Pose sensor{{0, 1.25F, 0}, {}};
    EXPECT_FALSE(act(sensor, motion, 60, kAnywhere));
    EXPECT_EQ(sensor.position, (Vec3f{0, 1.25F, 0}));
    return sensor.rotation;
  };
  const float s = std::sin(static_cast<float>(kPi / 6));
  EXPECT_FLOAT_EQ(turned(Motion::kLookUp).x, s);
  EXPECT_FLOAT_EQ(turned(Motion::kLookDown).x, -s);
  EXPECT_FLOAT_EQ(turned(Motion::kLookLeft).y, s);
  EXPECT_FLOAT_EQ(turned(Motion::kLookRight).y, -s);
  // Its picture turns clockwise, so it turns about z the other way.
  EXPECT_FLOAT_EQ(turned(Motion::kRotateSensorClockwise).z, s);
  EXPECT_FLOAT_EQ(turned(Motion::kRotateSensorAntiClockwise).z, -s);
  // Up: what looks along -z then looks up.
  Pose sensor;
  act(sensor, Motion::kLookUp, 90, kAnywhere);
  expect_near(moved(Motion::kMoveForward, sensor), {0, 0.5F, 0});
}

TEST(HabitatBody, OnlySomeMotionsMoveBodies) {
  for (const Motion motion : {Motion::kMoveForward, Motion::kMoveBackward, Motion::kMoveLeft,
                              Motion::kMoveRight, Motion::kTurnLeft, Motion::kTurnRight}) {
    EXPECT_TRUE(moves_body(motion));
  }
  const PathFinder floor = square();
  for (const Motion motion :
       {Motion::kMoveUp, Motion::kMoveDown, Motion::kLookUp, Motion::kLookDown, Motion::kLookLeft,
        Motion::kLookRight, Motion::kRotateSensorClockwise, Motion::kRotateSensorAntiClockwise}) {
    EXPECT_FALSE(moves_body(motion));
    // A sensor far from the floor: nothing takes it there.
    Pose sensor = facing({50, 60, 70}, 0);
    EXPECT_FALSE(act(sensor, motion, 1, {&floor}));
    expect_near(sensor.position, {50, 60, 70}, 1.01F);
    EXPECT_NE(sensor, facing({50, 60, 70}, 0));
  }
}

TEST(HabitatBody, TheFirstTurnPutsItOntoTheFloor) {
  const PathFinder floor = square();
  const Vec3f beside{3.5F, 1.5F, 1};
  const Vec3f snapped = floor.snap(beside);
  ASSERT_NEAR(snapped.x, kEdge, 0.03);
  for (const Moves moves : {Moves::kSlide, Moves::kStop}) {
    Pose pose = facing(beside, 0);
    EXPECT_FALSE(act(pose, Motion::kTurnLeft, 0, {&floor, moves}));
    expect_near(pose.position, snapped);
    EXPECT_EQ(pose.rotation, facing(beside, 0).rotation);
  }
}

TEST(HabitatBody, EndsWhereTheFilterSaysButForRounding) {
  // With a wall beside x = 0, where differences of coordinates are not exact.
  const PathFinder floor = flat_floor({{-0.1F, -3, 3, 3}});
  const Ground ground{&floor, Moves::kSlide};
  Pose pose{floor.snap({0.3F, 0, 0}), {}};
  int other = 0;
  for (int step = 0; step < 400; ++step) {
    if (step % 3 == 0) act(pose, Motion::kTurnLeft, 37, ground);
    const Vec3f from = pose.position;
    Pose free = pose;
    act(free, Motion::kMoveForward, 0.25F, kAnywhere);
    const Vec3f asked = free.position;
    const Vec3f reached = floor.step(from, asked, Moves::kSlide);
    act(pose, Motion::kMoveForward, 0.25F, ground);
    ASSERT_EQ(pose.position, reached - asked + asked);
    other += pose.position == reached ? 0 : 1;
    expect_near(pose.position, reached, 1e-6F);
  }
  EXPECT_GT(other, 0);
}

TEST(HabitatBody, CollidesWithWalls) {
  const PathFinder floor = square();
  const Vec3f near = floor.snap({kEdge - 0.1F, 0, 0});
  for (const Moves moves : {Moves::kSlide, Moves::kStop}) {
    const Ground ground{&floor, moves};
    Pose away = facing(near, 90);
    EXPECT_FALSE(act(away, Motion::kMoveForward, 0.25F, ground));
    expect_near(away.position, near + Vec3f{-0.25F, 0, 0}, 1e-5F);

    Pose straight = facing(near, -90);
    EXPECT_TRUE(act(straight, Motion::kMoveForward, 0.25F, ground));
    EXPECT_NEAR(straight.position.x, kEdge, 0.03);
    EXPECT_NEAR(straight.position.z, 0, 0.01);

    // 45 degrees: sliding goes on along the wall.
    Pose aslant = facing(near, -45);
    EXPECT_TRUE(act(aslant, Motion::kMoveForward, 0.5F, ground));
    EXPECT_NEAR(aslant.position.x, kEdge, 0.03);
    EXPECT_NEAR(aslant.position.z, moves == Moves::kSlide ? -0.354 : -0.1, 0.035);
  }
}

TEST(HabitatBody, TriesStepsWhereItWouldGoButForRounding) {
  const PathFinder floor = square();
  int rounded = 0;
  for (int turn = 0; turn < 360; ++turn) {
    const Pose start = facing({0.3F, 0.05F, -0.2F}, turn * 1.7);
    Pose tried = start;
    Pose gone = start;
    EXPECT_FALSE(try_ahead(tried, 0.25, kAnywhere));
    act(gone, Motion::kMoveForward, 0.25, kAnywhere);
    expect_near(tried.position, gone.position, 1e-6F);
    ASSERT_EQ(tried.rotation, start.rotation) << turn;
    rounded += tried == gone ? 0 : 1;
    EXPECT_FALSE(try_ahead(tried, 0.25, {&floor}));
  }
  EXPECT_GT(rounded, 50);
  // Turned about each axis by half: the sum of the matrix's diagonal is negative.
  for (const Rotation half : {Rotation{1, 0, 0, 0}, Rotation{0, 1, 0, 0}, Rotation{0, 0, 1, 0},
                              Rotation{0.6F, 0.8F, 0, 0}}) {
    Pose tried{{0, 0, 0}, half};
    Pose gone = tried;
    try_ahead(tried, 1, kAnywhere);
    act(gone, Motion::kMoveForward, 1, kAnywhere);
    expect_near(tried.position, gone.position);
  }
  Pose walled = facing({2.8F, 0.05F, 0}, -90);
  EXPECT_TRUE(try_ahead(walled, 0.25, {&floor}));
  EXPECT_NEAR(walled.position.x, kEdge, 0.051);
}

TEST(HabitatBody, CarriesItsSensors) {
  const Pose body = facing({1, 2, 3}, 90);  // looks along -x
  Pose sensor{{0.1F, 1.25F, -0.2F}, {}};
  act(sensor, Motion::kLookUp, 30, kAnywhere);
  const Pose camera = in_world(body, sensor);
  expect_near(camera.position, {0.8F, 3.25F, 2.9F});
  expect_near(moved(Motion::kMoveForward, camera), {-0.5F * std::sqrt(0.75F), 0.25F, 0});
  EXPECT_EQ(in_world({}, sensor), sensor);
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous::habitat
