#include "enfilade/mesh/light/sources.h"

#include <algorithm>
#include <cmath>

#include "enfilade/mesh/detail/vector.h"

namespace enfilade::mesh::light {

using namespace detail;

namespace {

constexpr int kPortalGrid = 3;           // points across a portal, each way
constexpr std::size_t kGlowPoints = 12;  // of a glowing thing
constexpr float kSurface = 2e-3F;        // metres in front of a glowing surface: not on it
constexpr float kAimedAtFrom = 1.25F;    // times its radius

// Fractional parts of the plastic number's powers (Roberts' R2): evenly spread points.
constexpr float kR2u = 0.7548776662F, kR2v = 0.5698402910F;

float fraction(float x) { return x - std::floor(x); }

float luminance_of_brightest(const Sky& sky) {
  return std::max({luminance(sky.zenith), luminance(sky.horizon), luminance(sky.ground)});
}

}  // namespace

LightSource::LightSource(const Lamp& lamp)
    : kind_(Kind::kLamp),
      middle_(lamp.position),
      radius_(lamp.radius),
      strength_(lamp.power),
      most_(luminance(lamp.power)) {
  // Corners of a cube in the ball, each next to its opposite.
  const float r = lamp.radius / std::sqrt(3.0F);
  for (const Vec3f corner : {Vec3f{r, r, r}, Vec3f{r, -r, r}, Vec3f{-r, r, r}, Vec3f{-r, -r, r}}) {
    points_.push_back({middle_ + corner, {}, 0});
    points_.push_back({middle_ - corner, {}, 0});
  }
  first_few_ = 2;
}

LightSource::LightSource(const Portal& portal, const Sky& sky)
    : kind_(Kind::kPortal),
      middle_(portal.corner + 0.5F * (portal.edge0 + portal.edge1)),
      radius_(0.5F *
              std::max(length(portal.edge0 + portal.edge1), length(portal.edge0 - portal.edge1))),
      portal_(portal),
      sky_(sky) {
  const Vec3f across = cross(portal.edge0, portal.edge1);
  const float area = length(across);
  most_ = area * luminance_of_brightest(sky);
  const Vec3f normal = unit(across);
  const float part = area / (kPortalGrid * kPortalGrid);
  // The first three lie in three rows and columns.
  for (int i = 0; i < kPortalGrid * kPortalGrid; ++i) {
    const int row = i % kPortalGrid, column = (row + i / kPortalGrid) % kPortalGrid;
    const float s = (static_cast<float>(column) + fraction(kR2u * static_cast<float>(i + 1)));
    const float t = (static_cast<float>(row) + fraction(kR2v * static_cast<float>(i + 1)));
    points_.push_back(
        {portal.corner + (s / kPortalGrid) * portal.edge0 + (t / kPortalGrid) * portal.edge1,
         normal, part});
  }
  first_few_ = kPortalGrid;
}

LightSource::LightSource(const Mesh& mesh, std::span<const std::uint32_t> triangles, Vec3f radiance)
    : kind_(Kind::kGlow), strength_(radiance) {
  std::vector<float> until;  // area of all triangles up to this one
  float area = 0;
  Vec3f low{1e30F, 1e30F, 1e30F}, high{-1e30F, -1e30F, -1e30F};
  for (const std::uint32_t t : triangles) {
    const auto& c = mesh.triangles[t];
    const Vec3f a = mesh.positions[c[0]];
    area += 0.5F * length(cross(mesh.positions[c[1]] - a, mesh.positions[c[2]] - a));
    until.push_back(area);
    for (const std::uint32_t corner : c) {
      const Vec3f p = mesh.positions[corner];
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  }
  middle_ = 0.5F * (low + high);
  radius_ = 0.5F * length(high - low);
  most_ = area * luminance(radiance);
  for (std::size_t i = 0; i < kGlowPoints && area > 0; ++i) {
    const float at = area * (static_cast<float>(i) + 0.5F) / kGlowPoints;
    const auto place =
        static_cast<std::size_t>(std::ranges::lower_bound(until, at) - until.begin());
    const auto& c = mesh.triangles[triangles[std::min(place, triangles.size() - 1)]];
    const Vec3f a = mesh.positions[c[0]], b = mesh.positions[c[1]], d = mesh.positions[c[2]];
    float u = fraction(kR2u * static_cast<float>(i + 1));
    float v = fraction(kR2v * static_cast<float>(i + 1));
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    points_.push_back(
        {(1 - u - v) * a + u * b + v * d, unit(cross(b - a, d - a)), area / kGlowPoints});
  }
  first_few_ = points_.size();
}

bool LightSource::aimed_at(Vec3f from) const {
  return kind_ == Kind::kLamp || length(from - middle_) > kAimedAtFrom * radius_;
}

float LightSource::distance(Vec3f from) const {
  return std::max(length(from - middle_) - radius_, 0.0F);
}

bool LightSource::reaches(const Receiver& receiver, float least) const {
  const Vec3f way = middle_ - receiver.position;
  const float along = dot(way, receiver.normal);
  if (along <= -radius_) return false;
  const float distance = std::max(length(way) - radius_, 0.05F);
  return most_ > least * distance * distance;
}

LightSource::Aim LightSource::aim(const Receiver& receiver, std::size_t point) const {
  const Point& at = points_[point];
  const Vec3f way = at.position - receiver.position;
  Aim aim{{receiver.position, way, 0, 1}, {}};
  if (kind_ == Kind::kLamp) {
    const Vec3f to_middle = middle_ - receiver.position;
    const float square = std::max(dot(to_middle, to_middle), radius_ * radius_ + 1e-6F);
    const float cosine = std::max(dot(to_middle, receiver.normal), 0.0F) / std::sqrt(square);
    aim.irradiance = cosine / (square * static_cast<float>(points_.size())) * strength_;
    return aim;
  }
  const float square = std::max(dot(way, way), 1e-6F);
  const float distance = std::sqrt(square);
  const float cosines =
      std::max(dot(way, receiver.normal), 0.0F) * std::abs(dot(way, at.normal)) / square;
  const Vec3f radiance =
      kind_ == Kind::kGlow ? strength_ : sky_radiance(sky_, (1 / distance) * way);
  aim.irradiance = cosines * at.area / square * radiance;
  aim.ray.far = kind_ == Kind::kGlow ? std::max(1 - kSurface / distance, 0.0F)
                                     : std::numeric_limits<float>::infinity();
  return aim;
}

bool LightSource::crossed_by(Vec3f origin, Vec3f direction) const {
  if (kind_ != Kind::kPortal) return false;
  // origin + t direction = corner + s edge0 + r edge1 (Moeller and Trumbore's way to solve it)
  const Vec3f p = cross(direction, portal_.edge1);
  const float determinant = dot(portal_.edge0, p);
  if (determinant == 0) return false;
  const Vec3f from = origin - portal_.corner;
  const float s = dot(from, p) / determinant;
  const Vec3f q = cross(from, portal_.edge0);
  const float r = dot(direction, q) / determinant;
  const float t = dot(portal_.edge1, q) / determinant;
  return t > 0 && s >= 0 && s <= 1 && r >= 0 && r <= 1;
}

}  // namespace enfilade::mesh::light
