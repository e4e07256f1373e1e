#include "enfilade/scan/depth_skybox.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "enfilade/geometry/cube_map.h"

namespace enfilade::scan {
namespace EN_UNIT {

struct Box {
  Vec3d low, high;
};

/// How far along a ray (in lengths of `direction`) it enters and leaves a box; nothing if it
/// misses.
std::optional<std::pair<double, double>> cross(const Box& box, Vec3d from, Vec3d direction) {
  double enter = -1e30, leave = 1e30;
  const auto slab = [&](double low, double high, double at, double step) {
    const double a = (low - at) / step, b = (high - at) / step;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  };
  slab(box.low.x, box.high.x, from.x, direction.x);
  slab(box.low.y, box.high.y, from.y, direction.y);
  slab(box.low.z, box.high.z, from.z, direction.z);
  if (enter > leave) return std::nullopt;
  return std::pair(enter, leave);
}

/// A room of flat walls, and maybe a pillar in it.
struct Room {
  Box walls{{-3, -4, 0}, {2.5, 3, 2.7}};
  std::optional<Box> pillar;

  double wall(Vec3d from, Vec3d direction) const { return cross(walls, from, direction)->second; }
  double seen(Vec3d from, Vec3d direction) const {
    const double far = wall(from, direction);
    if (!pillar) return far;
    const auto hit = cross(*pillar, from, direction);
    return hit && hit->first > 0 ? std::min(far, hit->first) : far;
  }
};

PanoramaPose eye() {
  return {"eye", world_from_camera(degrees(25), degrees(0)), {.3, -.4, 1.5}, true};
}

/// Matterport's camera: three heights, six turns, `beside` metres from the eye.
UndistortedCamera camera(std::size_t cam, std::size_t yaw, double beside, std::uint32_t width) {
  constexpr std::array<double, 3> kElevation{41, 0, -42};
  const Radians heading = degrees(25 + 60 * static_cast<double>(yaw));
  const auto r = world_from_camera(heading, degrees(kElevation[cam])).m;
  UndistortedCamera c;
  c.depth_file = "eye_d" + std::to_string(cam) + "_" + std::to_string(yaw) + ".png";
  c.world_from_camera = {{r[0], -r[1], -r[2], r[3], -r[4], -r[5], r[6], -r[7], -r[8]}};
  c.fx = 1076. / 1280 * width;
  c.fy = 1074. / 1280 * width;
  c.cx = .507 * width;
  c.cy = .393 * width;  // 1024 rows at 1280 columns
  c.position = eye().position + Vec3d{beside * std::sin(heading.value + 1),
                                      beside * std::cos(heading.value + 1),
                                      .7 * beside * (1 - static_cast<double>(cam))};
  return c;
}

Vec3d ray_of_pixel(const UndistortedCamera& c, const image::Image16& image, double x, double y) {
  const double row_from_bottom = image.height - 1 - y;
  return c.world_from_camera * Vec3d{(x - c.cx) / c.fx, (row_from_bottom - c.cy) / c.fy, -1};
}

/// Where a camera sees a world point: column and row from the top.
std::pair<double, double> pixel_of(const UndistortedCamera& c, const image::Image16& image,
                                   Vec3d p) {
  const Vec3d q = transpose(c.world_from_camera) * (p - c.position);
  if (q.z >= 0) return {-1e9, -1e9};
  return {c.cx - c.fx * q.x / q.z, image.height - 1 - (c.cy - c.fy * q.y / q.z)};
}

std::vector<DepthImage> photograph(const Room& room, double beside, std::uint32_t width) {
  std::vector<DepthImage> images;
  for (std::size_t k = 0; k < 18; ++k) {
    DepthImage one{camera(k / 6, k % 6, beside, width), {width, width * 4 / 5, 1}};
    for (std::uint32_t y = 0; y < one.depth.height; ++y) {
      for (std::uint32_t x = 0; x < width; ++x) {
        // The ray's part along the optical axis is 1, so that its length counts z.
        const double z = room.seen(one.camera.position, ray_of_pixel(one.camera, one.depth, x, y));
        *one.depth.at(x, y) = static_cast<std::uint16_t>(std::lround(z * kDepthUnitsPerMetre));
      }
    }
    images.push_back(std::move(one));
  }
  return images;
}

/// Calls each(texel's depth in metres, direction of length 1 in the world).
template <class F>
void for_texels(const image::CubeMap<std::uint16_t>& map, const F& each) {
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const double n = map[k].width;
    for (std::size_t y = 0; y < map[k].height; ++y) {
      for (std::size_t x = 0; x < map[k].width; ++x) {
        const Vec3d d = cube_direction(cube_face(k), (static_cast<double>(x) + .5) / n,
                                       (static_cast<double>(y) + .5) / n);
        each(*map[k].at(x, y) / kDepthUnitsPerMetre,
             eye().world_from_panorama * (1 / length(d) * d));
      }
    }
  }
}

/// By how many pixels a point is inside the frame of the picture that sees it best.
double best_inside(const std::vector<DepthImage>& images, Vec3d p) {
  double best = -1e9;
  for (const DepthImage& image : images) {
    const auto [x, y] = pixel_of(image.camera, image.depth, p);
    best = std::max(best, std::min({x, y, image.depth.width - 1 - x, image.depth.height - 1 - y}));
  }
  return best;
}

TEST(DepthSkybox, IsTrueInARoomOfKnownWalls) {
  const Room room;
  const auto images = photograph(room, .06, 640);
  const auto map = depth_skybox(images, eye(), 192);
  std::vector<double> errors;
  std::size_t seen = 0, wrong_holes = 0, invented = 0;
  for_texels(map, [&](double found, Vec3d direction) {
    const double truth = room.wall(eye().position, direction);
    const double inside = best_inside(images, eye().position + truth * direction);
    // At the very frame the last digits of the projection decide.
    if (inside > .05) ++seen, wrong_holes += found == 0;
    if (inside < -.05) invented += found != 0;
    if (found != 0) errors.push_back(std::abs(found - truth));
  });
  EXPECT_EQ(wrong_holes, 0U);
  EXPECT_EQ(invented, 0U);
  EXPECT_GT(seen, 6U * 192 * 192 * 8 / 10);  // the cameras leave out the zenith and the nadir
  std::ranges::sort(errors);
  // 1 / z is linear on a plane, so what is left there is rounding: of the pictures' z and of the
  // result, an eighth of a millimetre each. In the corners of the room the four pixels around a
  // point are on two walls, and the interpolated surface cuts the corner by less than a pixel's
  // width, 1/537 of up to 5 m.
  EXPECT_LT(errors[errors.size() / 2], .00025);
  EXPECT_LT(errors[errors.size() * 99 / 100], .0005);
  EXPECT_LT(errors.back(), .01);
}

TEST(DepthSkybox, TakesThePlaceOfTheCamerasIntoAccount) {
  // As if cameras stood where the eye is, 6 cm would be as many off in places: this shows that the
  // test above can fail.
  const Room room;
  auto images = photograph(room, .06, 160);
  for (DepthImage& image : images) image.camera.position = eye().position;
  double worst = 0;
  for_texels(depth_skybox(images, eye(), 32), [&](double found, Vec3d direction) {
    if (found != 0) worst = std::max(worst, std::abs(found - room.wall(eye().position, direction)));
  });
  EXPECT_GT(worst, .03);
}

TEST(DepthSkybox, PutsNothingBetweenAPillarAndTheWall) {
  Room room;
  room.pillar = Box{{.1, 1.2, 0}, {.4, 1.5, 2.7}};
  Room wider = room;  // what the outermost pixels of the pillar may be taken for, beside its edge
  constexpr double kPixels = .02;  // metres: 5 pixels at 2 m
  wider.pillar->low = wider.pillar->low - Vec3d{kPixels, 0, 0};
  wider.pillar->high = wider.pillar->high + Vec3d{kPixels, 0, 0};
  Room thinner = room;
  thinner.pillar->low = thinner.pillar->low + Vec3d{kPixels, 0, 0};
  thinner.pillar->high = thinner.pillar->high - Vec3d{kPixels, 0, 0};
  const auto images = photograph(room, .06, 640);
  std::size_t on_pillar = 0, ghosts = 0, missing = 0, wrong = 0;
  for_texels(depth_skybox(images, eye(), 192), [&](double found, Vec3d direction) {
    const Vec3d p = eye().position;
    const double truth = room.seen(p, direction);
    on_pillar += truth < room.wall(p, direction);
    if (found == 0) {
      missing += best_inside(images, p + truth * direction) > .05;
      return;
    }
    // Nearest pixels stand for their surroundings: half a pixel on a surface seen at a slant.
    const auto is = [&](double t) { return std::abs(found - t) < .01 + .005 * t; };
    ghosts += !is(room.wall(p, direction)) && !is(wider.seen(p, direction)) &&
              !is(thinner.seen(p, direction));
    const bool at_edge = std::abs(wider.seen(p, direction) - thinner.seen(p, direction)) > .05;
    wrong += !at_edge && !is(truth);
  });
  EXPECT_GT(on_pillar, 1000U);
  EXPECT_EQ(ghosts, 0U);
  EXPECT_EQ(wrong, 0U);
  // What the eye sees past the pillar and no camera does: strips at its two edges.
  EXPECT_LT(missing, on_pillar / 5);
}

/// Are the four pixels around a point all readings, in a picture that shows it?
bool has_reading(const DepthImage& image, Vec3d p) {
  const auto [x, y] = pixel_of(image.camera, image.depth, p);
  if (!(x >= .05 && y >= .05 && x < image.depth.width - 1.05 && y < image.depth.height - 1.05)) {
    return false;
  }
  const auto* a = image.depth.at(static_cast<std::size_t>(x), static_cast<std::size_t>(y));
  const auto* b = a + image.depth.width;
  return a[0] != 0 && a[1] != 0 && b[0] != 0 && b[1] != 0;
}

TEST(DepthSkybox, HasHolesOnlyWhereNoPictureHasAReading) {
  const Room room;
  auto images = photograph(room, .06, 320);
  for (DepthImage& image : images) {
    for (std::uint32_t y = 0; y < image.depth.height; ++y) {
      for (std::uint32_t x = 0; x < image.depth.width; ++x) {
        // Spots all over, and a window in the wall that no camera has a reading of.
        const Vec3d p = ray_of_pixel(image.camera, image.depth, x, y);
        const Vec3d at = image.camera.position + room.wall(image.camera.position, p) * p;
        const bool spot = x % 40 < 12 && y % 40 < 12;
        if (spot || (at.y > 2.99 && std::abs(at.x) < .5)) *image.depth.at(x, y) = 0;
      }
    }
  }
  std::size_t window = 0, invented = 0, readings = 0, lost = 0;
  for_texels(depth_skybox(images, eye(), 96), [&](double found, Vec3d direction) {
    const Vec3d p = eye().position;
    const Vec3d at = p + room.wall(p, direction) * direction;
    // Less its frame, a nearest pixel of 1 cm, seen at a slant.
    if (at.y > 2.99 && std::abs(at.x) < .47 && at.z > .03 && at.z < 2.67) {
      ++window;
      invented += found != 0;
    }
    const bool known =
        std::ranges::any_of(images, [&](const auto& i) { return has_reading(i, at); });
    readings += known;
    lost += known && found == 0;
  });
  EXPECT_GT(window, 300U);
  EXPECT_EQ(invented, 0U);
  EXPECT_GT(readings, 6U * 96 * 96 * 7 / 10);
  // From each of its starts a search may fall into some spot.
  EXPECT_LT(lost, readings / 1000);
}

TEST(DepthSkybox, IsTheSameAtAnyNumberOfThreads) {
  const auto images = photograph(Room(), .05, 160);
  EXPECT_EQ(depth_skybox(images, eye(), 40, 1), depth_skybox(images, eye(), 40, 2));
}

TEST(DepthSkybox, IsEmptyWithoutPictures) {
  const auto map = depth_skybox({}, eye(), 4);
  for (const auto& face : map) EXPECT_EQ(face, image::Image16(4, 4, 1));
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
