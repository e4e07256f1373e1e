#include "enfilade/mesh/lighting.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/mesh/detail/vector.h"
#include "enfilade/mesh/light/baker.h"

namespace enfilade::mesh {

using namespace detail;
using namespace light;

namespace {

constexpr std::size_t kBlock = 256;  // rays that are worked on together, on the stack

void check_finite(const char* name, Vec3f v, float least) {
  const auto ok = [least](float x) { return std::isfinite(x) && x >= least; };
  if (ok(v.x) && ok(v.y) && ok(v.z)) return;
  throw ArgumentError(fmt::format("lights: {}: ({}, {}, {}), not finite and at least {}", name, v.x,
                                  v.y, v.z, least));
}

void check_lights(const Lights& lights) {
  constexpr float kAny = std::numeric_limits<float>::lowest();
  check_finite("sky.zenith", lights.sky.zenith, 0);
  check_finite("sky.horizon", lights.sky.horizon, 0);
  check_finite("sky.ground", lights.sky.ground, 0);
  check_finite("sun.towards", lights.sun.towards, kAny);
  check_finite("sun.irradiance", lights.sun.irradiance, 0);
  check_range("sun.radius", lights.sun.radius, 0, 0.5);
  check_finite("ambient", lights.ambient, 0);
  for (const Lamp& lamp : lights.lamps) {
    check_finite("lamp.position", lamp.position, kAny);
    check_finite("lamp.power", lamp.power, 0);
    check_range("lamp.radius", lamp.radius, 0, 100);
  }
  for (const Portal& portal : lights.portals) {
    check_finite("portal.corner", portal.corner, kAny);
    check_finite("portal.edge0", portal.edge0, kAny);
    check_finite("portal.edge1", portal.edge1, kAny);
  }
}

// Secondary rays, each with the number of the ray that it continues.
struct Onward {
  std::array<Ray, kBlock> rays;
  std::array<std::uint32_t, kBlock> of;
  std::array<Vec3f, kBlock> share;  ///< of what they find
  std::size_t count = 0;

  void add(std::size_t ray, Vec3f origin, Vec3f direction, Vec3f weight) {
    rays[count] = {origin, direction};
    of[count] = static_cast<std::uint32_t>(ray);
    share[count++] = weight;
  }
  std::span<const Ray> all() const { return std::span(rays).first(count); }
};

// Directions to the parts of the sun's disc. Their angles are all different, and their distances
// from its middle, so that each part has the same area; each four in turn have one in each quarter
// of the disc, and one in each of four rings. All are the middle of a sun without size.
std::array<Vec3f, kSunParts> parts_of(const Sun& sun) {
  const Vec3f middle = unit(sun.towards);
  const Vec3f beside =
      unit(cross(middle, std::abs(middle.z) < 0.9F ? Vec3f{0, 0, 1} : Vec3f{1, 0, 0}));
  const Vec3f across = cross(middle, beside);
  std::array<Vec3f, kSunParts> parts;
  parts.fill(middle);
  if (sun.radius <= 0) return parts;
  constexpr std::size_t kFour = 4;
  for (std::size_t k = 0; k < kSunParts; ++k) {
    const std::size_t four = k / kFour, quarter = k % kFour;
    const double angle = 2 * kPi * static_cast<double>(kFour * quarter + four) / kSunParts;
    const double ring = static_cast<double>(kFour * ((quarter + 2 * four) % kFour) + four) + 0.5;
    const double far = std::tan(double{sun.radius}) * std::sqrt(ring / kSunParts);
    parts[k] = unit(middle + static_cast<float>(far * std::cos(angle)) * beside +
                    static_cast<float>(far * std::sin(angle)) * across);
  }
  return parts;
}

// The point moved off its surface, along the normal.
Vec3f lifted(Vec3f at, Vec3f normal) {
  const float far = std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)});
  return at + (3e-4F + 1e-6F * far) * normal;
}

}  // namespace

Vec3f sky_radiance(const Sky& sky, Vec3f towards) {
  if (towards.z >= 0) return mix(sky.horizon, sky.zenith, std::sqrt(std::min(towards.z, 1.0F)));
  constexpr float kHaze = 0.1F;  // how far below the horizon the ground is lost in haze
  return mix(sky.horizon, sky.ground, std::min(-towards.z / kHaze, 1.0F));
}

struct LitMesh::Impl {
  Impl(std::shared_ptr<const RayTracer> with, Lights of, const BakeOptions& options,
       const Progress& progress)
      : tracer(std::move(with)),
        lights(std::move(of)),
        sun(unit(lights.sun.towards)),
        sun_parts(parts_of(lights.sun)),
        sunny(luminance(lights.sun.irradiance) > 0),
        surfaces(tracer->mesh()),
        baked(Baker(*tracer, surfaces, lights, options, progress).run()) {}

  void look(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3f> radiance,
            float spread, bool mirrors) const;
  void light(std::span<const SurfacePoint> points, std::span<Vec3f> radiance) const;
  Vec3f light_at(std::uint32_t triangle, float u, float v, LightPoint side) const;
  Vec3f light_at(const Hit& hit, LightPoint side) const {
    return light_at(hit.triangle, hit.u, hit.v, side);
  }
  void shine_sun(const Onward& towards, std::span<Vec3f> radiance) const;
  void look_in_mirrors(const Onward& mirrored, std::span<Vec3f> radiance, float spread) const;

  std::shared_ptr<const RayTracer> tracer;
  Lights lights;
  Vec3f sun;
  std::array<Vec3f, kSunParts> sun_parts;
  bool sunny;
  LitSurfaces surfaces;
  BakedLight baked;
};

Vec3f LitMesh::Impl::light_at(std::uint32_t triangle, float u, float v, LightPoint side) const {
  const LightMesh::PiecePoint place = baked.mesh.locate(triangle, u, v);
  const auto& corners = baked.mesh.pieces()[place.piece].front;
  return place.weights[0] * baked.light[corners[0] ^ side] +
         place.weights[1] * baked.light[corners[1] ^ side] +
         place.weights[2] * baked.light[corners[2] ^ side];
}

// \pre at most kBlock rays
void LitMesh::Impl::look(std::span<const Ray> rays, std::span<const Hit> hits,
                         std::span<Vec3f> radiance, float spread, bool mirrors) const {
  Onward to_sun, mirrored;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Hit& hit = hits[i];
    const Vec3f way = rays[i].direction;
    if (!hit) {
      radiance[i] = sky_radiance(lights.sky, unit(way));
      continue;
    }
    const Material& material = surfaces.material(hit.triangle);
    const Vec3f geometric = surfaces.normal(hit.triangle);
    const float across = dot(way, geometric), size = length(way);
    const LightPoint side = across > 0 ? 1 : 0;
    // Seen at a slant, a texel covers fewer pixels along one axis: the mean of both axes.
    const float slant = std::sqrt(std::max(std::abs(across) / size, 0.05F));
    const Vec3f colour =
        (1 - material.mirror) *
        surfaces.colour(hit.triangle, hit.u, hit.v, spread * hit.distance * size / slant);
    radiance[i] = colour * light_at(hit, side) + material.emission;
    const bool reflects = mirrors && material.mirror > 0;
    if (!sunny && !reflects) continue;
    const float turned = side == 1 ? -1.0F : 1.0F;
    const Vec3f normal = turned * surfaces.normal(hit.triangle, hit.u, hit.v);
    const Vec3f from = lifted(surfaces.position(hit.triangle, hit.u, hit.v), turned * geometric);
    const float cosine = dot(normal, sun);
    if (sunny && cosine > 0 && turned * dot(geometric, sun) > 0) {
      to_sun.add(i, from, sun_parts[i % kSunParts],
                 cosine / kFloatPi * colour * lights.sun.irradiance);
    }
    if (reflects) {
      const Vec3f back = way - 2 * dot(way, normal) * normal;
      mirrored.add(i, from, back, material.mirror * Vec3f{1, 1, 1});
    } else if (material.mirror > 0) {
      // A mirror in a mirror is as bright as a white wall there.
      radiance[i] += material.mirror * light_at(hit, side);
    }
  }
  if (to_sun.count > 0) shine_sun(to_sun, radiance);
  if (mirrored.count > 0) look_in_mirrors(mirrored, radiance, spread);
}

// \pre at most kBlock points
void LitMesh::Impl::light(std::span<const SurfacePoint> points, std::span<Vec3f> radiance) const {
  Onward to_sun;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [triangle, u, v, back] = points[i];
    radiance[i] = light_at(triangle, u, v, back ? 1 : 0);
    const float turned = back ? -1.0F : 1.0F;
    const Vec3f geometric = turned * surfaces.normal(triangle);
    const float cosine = turned * dot(surfaces.normal(triangle, u, v), sun);
    if (!sunny || cosine <= 0 || dot(geometric, sun) <= 0) continue;
    to_sun.add(i, lifted(surfaces.position(triangle, u, v), geometric), sun,
               cosine / kFloatPi * lights.sun.irradiance);
  }
  if (to_sun.count > 0) shine_sun(to_sun, radiance);
}

void LitMesh::Impl::shine_sun(const Onward& towards, std::span<Vec3f> radiance) const {
  std::array<std::uint8_t, kBlock> blocked;
  tracer->blocked(towards.all(), std::span(blocked).first(towards.count));
  for (std::size_t k = 0; k < towards.count; ++k) {
    if (blocked[k] == 0) radiance[towards.of[k]] += towards.share[k];
  }
}

void LitMesh::Impl::look_in_mirrors(const Onward& mirrored, std::span<Vec3f> radiance,
                                    float spread) const {
  std::array<Hit, kBlock> hits;
  std::array<Vec3f, kBlock> seen;
  const auto found = std::span(hits).first(mirrored.count);
  tracer->trace(mirrored.all(), found);
  look(mirrored.all(), found, std::span(seen).first(mirrored.count), spread, false);
  for (std::size_t k = 0; k < mirrored.count; ++k) {
    radiance[mirrored.of[k]] += mirrored.share[k] * seen[k];
  }
}

LitMesh::LitMesh(std::shared_ptr<const RayTracer> tracer, Lights lights, const BakeOptions& options,
                 const Progress& progress) {
  if (tracer == nullptr) throw ArgumentError("tracer: none");
  check_range("spacing", options.spacing, 0.01, 100);
  check_range("detail", options.detail, 0.01, 1);
  check_range("rays", options.rays, 1, 65536);
  check_range("bounces", options.bounces, 0, 100);
  check_lights(lights);
  impl_ = std::make_unique<Impl>(std::move(tracer), std::move(lights), options, progress);
}

LitMesh::~LitMesh() = default;

const RayTracer& LitMesh::tracer() const noexcept { return *impl_->tracer; }
const Lights& LitMesh::lights() const noexcept { return impl_->lights; }
float LitMesh::key() const noexcept { return impl_->baked.key; }

void LitMesh::look(std::span<const Ray> rays, std::span<Vec3f> radiance, float spread) const {
  EN_CHECK_EQ(rays.size(), radiance.size());
  std::array<Hit, kBlock> hits;
  for (std::size_t first = 0; first < rays.size(); first += kBlock) {
    const std::size_t n = std::min(kBlock, rays.size() - first);
    const auto found = std::span(hits).first(n);
    impl_->tracer->trace(rays.subspan(first, n), found);
    impl_->look(rays.subspan(first, n), found, radiance.subspan(first, n), spread, true);
  }
}

void LitMesh::look(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3f> radiance,
                   float spread) const {
  EN_CHECK_EQ(rays.size(), radiance.size());
  EN_CHECK_EQ(rays.size(), hits.size());
  for (std::size_t first = 0; first < rays.size(); first += kBlock) {
    const std::size_t n = std::min(kBlock, rays.size() - first);
    impl_->look(rays.subspan(first, n), hits.subspan(first, n), radiance.subspan(first, n), spread,
                true);
  }
}

void LitMesh::light(std::span<const SurfacePoint> points, std::span<Vec3f> radiance) const {
  EN_CHECK_EQ(points.size(), radiance.size());
  for (std::size_t first = 0; first < points.size(); first += kBlock) {
    const std::size_t n = std::min(kBlock, points.size() - first);
    impl_->light(points.subspan(first, n), radiance.subspan(first, n));
  }
}

Lights studio_lights(const Mesh&) {
  Lights lights;
  lights.sky = {{1.0F, 1.0F, 1.05F}, {0.9F, 0.9F, 0.9F}, {0.5F, 0.48F, 0.45F}};
  lights.ambient = {0.6F, 0.6F, 0.6F};
  return lights;
}

}  // namespace enfilade::mesh
