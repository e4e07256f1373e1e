#include "enfilade/continuous/habitat/sensors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/continuous/eyes.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/geometry/habitat_frame.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/mesh/semantic_ply.h"

namespace enfilade::continuous::habitat {
namespace {

constexpr std::uint32_t kLargestEdge = 8192;  // pixels

// Where a pixel is looked up in the faces, which lie one after the other.
struct Lookup {
  std::uint32_t nearest = kNowhere;          // the texel that it lies in
  std::uint32_t left = 0;                    // of the four around it, the first
  std::uint32_t to_right = 0, to_below = 0;  // from there to the others; 0 at the face's edge
  float right = 0, below = 0;                // shares of those

  static constexpr std::uint32_t kNowhere = 0xFFFFFFFFU;
};

struct CubeTable {
  Sensor sensor;
  std::vector<CubeFace> faces;  // that the picture shows, as they lie
  std::vector<Lookup> pixels;
};

// In the panorama frame; none where the lens does not see.
std::optional<Vec3d> direction_of(const Sensor& sensor, std::uint32_t column, std::uint32_t row) {
  const double x = column + 0.5, y = row + 0.5;
  if (sensor.lens == Lens::kEquirectangular) {
    const double heading = (x / sensor.width - 0.5) * 2 * kPi;
    const double elevation = (0.5 - y / sensor.height) * kPi;
    return Vec3d{std::cos(elevation) * std::sin(heading), -std::sin(elevation),
                 std::cos(elevation) * std::cos(heading)};
  }
  const DoubleSphere& lens = sensor.double_sphere;
  const double mx = (x - lens.middle_x) / lens.focal_x, my = (y - lens.middle_y) / lens.focal_y;
  const double square = mx * mx + my * my, alpha = lens.alpha, xi = lens.xi;
  const double under = 1 - (2 * alpha - 1) * square;
  if (under < 0) return std::nullopt;
  const double mz = (1 - alpha * alpha * square) / (alpha * std::sqrt(under) + 1 - alpha);
  const double beyond = mz * mz + (1 - xi * xi) * square;
  if (beyond < 0) return std::nullopt;
  const double scale = (mz * xi + std::sqrt(beyond)) / (mz * mz + square);
  return Vec3d{scale * mx, scale * my, scale * mz - xi};
}

std::uint32_t cube_size_of(const Sensor& sensor) {
  return sensor.cube_size > 0 ? sensor.cube_size : std::min(sensor.width, sensor.height);
}

Lookup lookup_of(const FacePoint& at, std::size_t place, std::uint32_t size) {
  const auto first = static_cast<std::uint32_t>(place * size * size);
  const double last = size - 1.0;
  const auto texel = [&](double x) { return static_cast<std::uint32_t>(std::clamp(x, 0.0, last)); };
  const double x = at.s * size, y = at.t * size;
  Lookup out;
  out.nearest = first + texel(y) * size + texel(x);
  const double across = std::clamp(x - 0.5, 0.0, last), down = std::clamp(y - 0.5, 0.0, last);
  const std::uint32_t i = texel(down), j = texel(across);
  out.left = first + i * size + j;
  out.to_right = j + 1 < size ? 1 : 0;
  out.to_below = i + 1 < size ? size : 0;
  out.right = static_cast<float>(across - j);
  out.below = static_cast<float>(down - i);
  return out;
}

CubeTable table_of(const Sensor& sensor) {
  CubeTable table{sensor, {}, std::vector<Lookup>(std::size_t{sensor.width} * sensor.height)};
  auto pixel = table.pixels.begin();
  for (std::uint32_t row = 0; row < sensor.height; ++row) {
    for (std::uint32_t column = 0; column < sensor.width; ++column, ++pixel) {
      const std::optional<Vec3d> direction = direction_of(sensor, column, row);
      if (!direction) continue;
      const FacePoint at = project_to_cube(*direction);
      const auto found = std::ranges::find(table.faces, at.face);
      const std::ptrdiff_t place = found - table.faces.begin();
      if (found == table.faces.end()) table.faces.push_back(at.face);
      *pixel = lookup_of(at, static_cast<std::size_t>(place), cube_size_of(sensor));
    }
  }
  return table;
}

void check_edge(const char* name, std::uint32_t pixels, std::uint32_t least) {
  if (pixels >= least && pixels <= kLargestEdge) return;
  throw ArgumentError(
      fmt::format("sensor.{}: {} pixels, not {} .. {}", name, pixels, least, kLargestEdge));
}

void check(const DoubleSphere& lens) {
  if (!(lens.focal_x > 0 && lens.focal_y > 0 && std::isfinite(lens.focal_x * lens.focal_y))) {
    throw ArgumentError(fmt::format("sensor.double_sphere.focal: ({}, {}) pixels, not above 0",
                                    lens.focal_x, lens.focal_y));
  }
  if (!(std::isfinite(lens.middle_x) && std::isfinite(lens.middle_y) && std::isfinite(lens.xi))) {
    throw ArgumentError(fmt::format("sensor.double_sphere: middle ({}, {}), xi {}, not finite",
                                    lens.middle_x, lens.middle_y, lens.xi));
  }
  if (!(lens.alpha >= 0 && lens.alpha <= 1)) {
    throw ArgumentError(fmt::format("sensor.double_sphere.alpha: {}, not in [0, 1]", lens.alpha));
  }
}

template <class T>
void check_memory(const char* name, std::span<T> memory, std::size_t values) {
  if (memory.empty() || memory.size() == values) return;
  throw ArgumentError(
      fmt::format("picture.{}: {} values, not {} or none", name, memory.size(), values));
}

// Right, down and forward of a camera in the world.
FaceAxes axes_of(const Rotation& rotation) {
  const double x = rotation.x, y = rotation.y, z = rotation.z, w = rotation.w;
  const double square = x * x + y * y + z * z + w * w;
  constexpr double kSlack = 1e-3;
  if (!(std::abs(square - 1) <= kSlack)) {
    throw ArgumentError(fmt::format("pose.rotation: ({}, {}, {}, {}), not of length 1", rotation.x,
                                    rotation.y, rotation.z, rotation.w));
  }
  const double two = 2 / square;
  const Vec3d right{1 - two * (y * y + z * z), two * (x * y + z * w), two * (x * z - y * w)};
  const Vec3d up{two * (x * y - z * w), 1 - two * (x * x + z * z), two * (y * z + x * w)};
  const Vec3d back{two * (x * z + y * w), two * (y * z - x * w), 1 - two * (x * x + y * y)};
  return {from_habitat(right), -1.0 * from_habitat(up), -1.0 * from_habitat(back)};
}

// A face's axes, for a camera with these.
FaceAxes turned(const FaceAxes& camera, const FaceAxes& face) {
  const auto in_world = [&](Vec3d v) {
    return v.x * camera.right + v.y * camera.down + v.z * camera.forward;
  };
  return {in_world(face.right), in_world(face.down), in_world(face.forward)};
}

MeshView view_of(const FaceAxes& axes, Vec3d eye) {
  const Vec3d ahead = axes.forward;
  const double heading = std::atan2(ahead.x, ahead.y);
  const Vec3d level{std::cos(heading), -std::sin(heading), 0};
  return {0, eye, Radians(heading), Radians(std::atan2(ahead.z, std::hypot(ahead.x, ahead.y))),
          Radians(std::atan2(dot(axes.right, cross(ahead, level)), dot(axes.right, level)))};
}

std::shared_ptr<const Scene> scene_of(mesh::Mesh mesh) {
  auto shared = std::make_shared<const mesh::Mesh>(std::move(mesh));
  return Scene::photographed(std::make_shared<const mesh::RayTracer>(std::move(shared)),
                             Style::kHabitat);
}

std::uint32_t between_texels(const std::uint32_t* texels, const Lookup& at) {
  const std::uint32_t* const top = texels + at.left;
  const std::uint32_t* const bottom = top + at.to_below;
  std::uint32_t rgba = 255U << 24U;
  for (unsigned shift = 0; shift < 24; shift += 8) {
    const auto part = [shift](std::uint32_t texel) {
      return static_cast<float>(texel >> shift & 255U);
    };
    const float above = std::lerp(part(top[0]), part(top[at.to_right]), at.right);
    const float under = std::lerp(part(bottom[0]), part(bottom[at.to_right]), at.right);
    rgba |= static_cast<std::uint32_t>(std::lerp(above, under, at.below) + 0.5F) << shift;
  }
  return rgba;
}

}  // namespace

void check(const Sensor& sensor) {
  check_edge("width", sensor.width, 1);
  check_edge("height", sensor.height, 1);
  check_edge("cube_size", sensor.cube_size, 0);
  const double angle = sensor.horizontal_field_of_view.value;
  if (sensor.lens == Lens::kPinhole && !(angle > 0 && angle < kPi)) {
    throw ArgumentError(fmt::format("sensor.horizontal_field_of_view: {}, not in (0, pi)", angle));
  }
  if (!(sensor.near > 0 && sensor.near < sensor.far && std::isfinite(sensor.far))) {
    throw ArgumentError(fmt::format("sensor: near {} and far {} metres, not 0 < near < far",
                                    sensor.near, sensor.far));
  }
  if (sensor.lens == Lens::kFisheye) check(sensor.double_sphere);
}

std::shared_ptr<const Scene> open_scene(const std::filesystem::path& file, Upright up) {
  const mesh::UpAxis axis = up == Upright::kZ ? mesh::UpAxis::kZ : mesh::UpAxis::kY;
  return scene_of(mesh::read_mesh(file, {1, axis}).mesh);
}

std::shared_ptr<const Scene> open_labels(const std::filesystem::path& file, Upright frame) {
  mesh::Mesh labels = mesh::parse_semantic_ply(read_file(file), file.string());
  // One of the two turns is the one into our own frame.
  if (frame == Upright::kZ) {
    for (Vec3f& p : labels.positions) p = {p.x, p.z, -p.y};
  }
  return scene_of(std::move(labels));
}

struct Sensors::Impl {
  Eyes eyes;
  std::vector<std::unique_ptr<const CubeTable>> tables;
  // The faces of a picture, as textures.
  std::vector<std::uint32_t> colour, instance;
  std::vector<float> depth;

  Impl(std::shared_ptr<const Scene> scene, int threads)
      : eyes({std::move(scene)}, {.threads = threads}) {}

  const CubeTable& table(const Sensor& sensor) {
    const auto found = std::ranges::find(
        tables, sensor, [](const auto& one) -> const Sensor& { return one->sensor; });
    if (found != tables.end()) return **found;
    constexpr std::size_t kMostKept = 8;
    if (tables.size() >= kMostKept) tables.erase(tables.begin());
    return *tables.emplace_back(std::make_unique<const CubeTable>(table_of(sensor)));
  }

  void draw_pinhole(const Sensor& sensor, const MeshView& view, const SensorPicture& picture) {
    const double half = std::tan(sensor.horizontal_field_of_view.value / 2);
    const Radians vertical(2 * std::atan(half * sensor.height / sensor.width));
    eyes.render({sensor.width, sensor.height, vertical}, {&view, 1}, outputs(picture),
                {sensor.near, sensor.far});
  }

  void draw_from_cube(const Sensor& sensor, const FaceAxes& axes, Vec3d eye,
                      const SensorPicture& picture) {
    const CubeTable& lookups = table(sensor);
    const std::uint32_t size = cube_size_of(sensor);
    const std::size_t texels = lookups.faces.size() * size * size;
    const auto room = [texels](auto& values, bool wanted) {
      if (wanted && values.size() < texels) values.resize(texels);
      return std::span(values).first(wanted ? texels : 0);
    };
    const auto of_colour = room(colour, !picture.colour.empty());
    const SensorPicture faces{
        {reinterpret_cast<std::uint8_t*>(of_colour.data()), 4 * of_colour.size()},
        room(depth, !picture.depth.empty()),
        room(instance, !picture.instance.empty())};
    std::array<MeshView, kCubeFaces> views;
    for (std::size_t k = 0; k < lookups.faces.size(); ++k) {
      views[k] = view_of(turned(axes, kFaceAxes[index(lookups.faces[k])]), eye);
    }
    eyes.render({size, size, degrees(90)}, std::span(views).first(lookups.faces.size()),
                outputs(faces), {sensor.near, sensor.far});
    look_up(lookups, picture);
  }

  void look_up(const CubeTable& lookups, const SensorPicture& picture) const {
    for (std::size_t k = 0; k < lookups.pixels.size(); ++k) {
      const Lookup& at = lookups.pixels[k];
      const bool seen = at.nearest != Lookup::kNowhere;
      if (!picture.depth.empty()) picture.depth[k] = seen ? depth[at.nearest] : 0;
      if (!picture.instance.empty()) picture.instance[k] = seen ? instance[at.nearest] : 0;
      if (!picture.colour.empty()) {
        const std::uint32_t rgba = seen ? between_texels(colour.data(), at) : 255U << 24U;
        std::memcpy(picture.colour.data() + 4 * k, &rgba, sizeof rgba);
      }
    }
  }

  static render::Outputs outputs(const SensorPicture& picture) {
    render::Outputs out;
    if (!picture.colour.empty()) {
      out.colour = render::ColourOutput{
          render::ColourFormat::kRgba8, {}, std::as_writable_bytes(picture.colour)};
    }
    if (!picture.depth.empty()) {
      out.depth = render::DepthOutput{render::DepthFormat::kMetresFloat32, render::DepthMeasure::kZ,
                                      std::as_writable_bytes(picture.depth)};
    }
    if (!picture.instance.empty()) out.instances = render::InstanceOutput{picture.instance};
    return out;
  }
};

Sensors::Sensors(std::shared_ptr<const Scene> scene, int threads)
    : impl_(std::make_unique<Impl>(std::move(scene), threads)) {}

Sensors::~Sensors() = default;

void Sensors::render(const Sensor& sensor, const Pose& pose, const SensorPicture& picture) {
  check(sensor);
  const std::size_t pixels = std::size_t{sensor.width} * sensor.height;
  check_memory("colour", picture.colour, 4 * pixels);
  check_memory("depth", picture.depth, pixels);
  check_memory("instance", picture.instance, pixels);
  const FaceAxes axes = axes_of(pose.rotation);
  const Vec3d eye = from_habitat(to_double(pose.position));
  if (sensor.lens == Lens::kPinhole) {
    impl_->draw_pinhole(sensor, view_of(axes, eye), picture);
  } else {
    impl_->draw_from_cube(sensor, axes, eye, picture);
  }
}

}  // namespace enfilade::continuous::habitat
