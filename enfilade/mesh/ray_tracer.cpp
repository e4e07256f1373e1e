#include "enfilade/mesh/ray_tracer.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/mesh/detail/textures.h"

namespace enfilade::mesh {

using namespace detail;

namespace {

// The differences between Embree 3 (Debian 12) and 4 (Ubuntu 24.04).
namespace embree {

#if RTC_VERSION_MAJOR >= 4

void intersect(const int* valid, RTCScene scene, RTCRayHit16& rays) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(valid, scene, &rays, &arguments);
}
void intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray, nullptr); }
void occluded(const int* valid, RTCScene scene, RTCRay16& rays) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcOccluded16(valid, scene, &rays, &arguments);
}
void occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray, nullptr); }

#else

RTCIntersectContext context(RTCIntersectContextFlags flags) {
  RTCIntersectContext made;
  rtcInitIntersectContext(&made);
  made.flags = flags;
  return made;
}
void intersect(const int* valid, RTCScene scene, RTCRayHit16& rays) {
  RTCIntersectContext coherent = context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  rtcIntersect16(valid, scene, &coherent, &rays);
}
void intersect(RTCScene scene, RTCRayHit& ray) {
  RTCIntersectContext single = context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  rtcIntersect1(scene, &single, &ray);
}
void occluded(const int* valid, RTCScene scene, RTCRay16& rays) {
  RTCIntersectContext coherent = context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  rtcOccluded16(valid, scene, &coherent, &rays);
}
void occluded(RTCScene scene, RTCRay& ray) {
  RTCIntersectContext single = context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  rtcOccluded1(scene, &single, &ray);
}

#endif

}  // namespace embree

constexpr unsigned kPacket = 16;
// Spatial splits make rays through rooms of large walls faster, but the tree takes twice as long.
constexpr std::size_t kSplitBelow = 1'000'000;

// What ThreadSanitizer cannot see is the order that oneTBB keeps between Embree's threads: it gets
// no other than the caller's.
#ifdef __SANITIZE_THREAD__
constexpr const char* kDeviceConfig = "threads=1";
#else
constexpr const char* kDeviceConfig = nullptr;
#endif

// Groups of triangles that rays treat alike; each is a geometry of the scene.
enum Group : unsigned { kSolid, kCutOut, kGlowing, kGroups };
constexpr unsigned kMaskOfGlowing = 2, kMaskOfOthers = 1;

Group group_of(const Material& material) {
  if (material.cutout > 0 && material.texture.channels == 4) return kCutOut;
  return material.emission == Vec3f{} ? kSolid : kGlowing;
}

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
template <class T>
using Owned = std::unique_ptr<std::remove_pointer_t<T>, Release>;

// Keeps Embree's first error. C code calls this, so nothing may be thrown.
void note_failure(void* text, RTCError code, const char* words) noexcept {
  auto& failure = *static_cast<std::string*>(text);
  if (!failure.empty()) return;
  try {
    failure = fmt::format("Embree: error {}: {}", static_cast<int>(code), words ? words : "");
  } catch (...) {
    failure = "Embree: out of memory";
  }
}

// Writes ray i of a packet of n; a single ray has the layout of a packet of 1.
void write_ray(void* packet, unsigned n, unsigned i, const Ray& ray, unsigned mask) {
  auto* const to = static_cast<RTCRayN*>(packet);
  RTCRayN_org_x(to, n, i) = ray.origin.x;
  RTCRayN_org_y(to, n, i) = ray.origin.y;
  RTCRayN_org_z(to, n, i) = ray.origin.z;
  RTCRayN_tnear(to, n, i) = ray.near;
  RTCRayN_dir_x(to, n, i) = ray.direction.x;
  RTCRayN_dir_y(to, n, i) = ray.direction.y;
  RTCRayN_dir_z(to, n, i) = ray.direction.z;
  RTCRayN_time(to, n, i) = 0;
  RTCRayN_tfar(to, n, i) = ray.far;
  RTCRayN_mask(to, n, i) = mask;
  RTCRayN_id(to, n, i) = 0;
  RTCRayN_flags(to, n, i) = 0;
}

// Lanes after the last ray repeat it and are switched off.
void write_rays(RTCRay16& to, std::span<const Ray> rays, unsigned mask, int* valid) {
  for (unsigned i = 0; i < kPacket; ++i) {
    valid[i] = i < rays.size() ? -1 : 0;
    write_ray(&to, kPacket, i, i < rays.size() ? rays[i] : rays.back(), mask);
  }
}

}  // namespace

struct RayTracer::Impl {
  explicit Impl(std::shared_ptr<const Mesh> of) : mesh(std::move(of)) {}

  void build();
  void add(Group group);
  void throw_failure() const {
    if (!failure.empty()) throw Error(failure);
  }
  std::uint32_t triangle_of(unsigned group, unsigned primitive) const {
    return triangles[group].empty() ? primitive : triangles[group][primitive];
  }
  static void cut(const RTCFilterFunctionNArguments* arguments);

  std::shared_ptr<const Mesh> mesh;
  std::string failure;
  /// By group: the triangle of each primitive; empty: the primitive's own number.
  std::array<std::vector<std::uint32_t>, kGroups> triangles;
  Owned<RTCDevice> device;
  Owned<RTCScene> scene;
};

void RayTracer::Impl::build() {
  device.reset(rtcNewDevice(kDeviceConfig));
  if (!device)
    throw Error(fmt::format("Embree: no device: error {}", int{rtcGetDeviceError(nullptr)}));
  rtcSetDeviceErrorFunction(device.get(), note_failure, &failure);
  for (const RTCDeviceProperty needed :
       {RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED, RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED}) {
    if (rtcGetDeviceProperty(device.get(), needed) == 0) {
      throw Error("Embree: this machine's was built without ray masks or filter functions");
    }
  }
  scene.reset(rtcNewScene(device.get()));
  throw_failure();
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene.get(), mesh->triangles.size() < kSplitBelow
                                           ? RTC_BUILD_QUALITY_HIGH
                                           : RTC_BUILD_QUALITY_MEDIUM);
  for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t) {
    triangles[group_of(mesh->materials[mesh->triangle_material[t]])].push_back(t);
  }
  for (const Group group : {kSolid, kCutOut, kGlowing}) {
    if (!triangles[group].empty()) add(group);
  }
  rtcCommitScene(scene.get());
  throw_failure();
  if (triangles[kSolid].size() == mesh->triangles.size()) triangles[kSolid] = {};
}

void RayTracer::Impl::add(Group group) {
  const Owned<RTCGeometry> geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  throw_failure();
  auto* positions = static_cast<Vec3f*>(
      rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              sizeof(Vec3f), mesh->positions.size()));
  auto* corners = static_cast<std::array<std::uint32_t, 3>*>(
      rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              sizeof(std::array<std::uint32_t, 3>), triangles[group].size()));
  throw_failure();
  std::ranges::copy(mesh->positions, positions);
  for (const std::uint32_t triangle : triangles[group]) *corners++ = mesh->triangles[triangle];
  rtcSetGeometryMask(geometry.get(), group == kGlowing ? kMaskOfGlowing : kMaskOfOthers);
  if (group == kCutOut) {
    rtcSetGeometryUserData(geometry.get(), this);
    rtcSetGeometryIntersectFilterFunction(geometry.get(), cut);
    rtcSetGeometryOccludedFilterFunction(geometry.get(), cut);
  }
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene.get(), geometry.get(), group);
  throw_failure();
}

void RayTracer::Impl::cut(const RTCFilterFunctionNArguments* arguments) {
  const auto& self = *static_cast<const Impl*>(arguments->geometryUserPtr);
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const std::uint32_t triangle = self.triangle_of(kCutOut, RTCHitN_primID(arguments->hit, n, i));
    const Material& material = self.mesh->materials[self.mesh->triangle_material[triangle]];
    const TexturePoint at = texture_point(*self.mesh, triangle, RTCHitN_u(arguments->hit, n, i),
                                          RTCHitN_v(arguments->hit, n, i));
    if (alpha_at(material.texture, at) < material.cutout) arguments->valid[i] = 0;
  }
}

RayTracer::RayTracer(std::shared_ptr<const Mesh> mesh)
    : impl_(std::make_unique<Impl>(std::move(mesh))) {
  std::vector<Diagnostic> found = check(*impl_->mesh, "mesh");
  if (count(found, Severity::kError) > 0) throw InvalidInput(std::move(found));
  impl_->build();
}

RayTracer::~RayTracer() = default;

const Mesh& RayTracer::mesh() const noexcept { return *impl_->mesh; }

void RayTracer::trace(std::span<const Ray> rays, std::span<Hit> hits) const {
  EN_CHECK_EQ(rays.size(), hits.size());
  alignas(64) RTCRayHit16 packet;
  alignas(64) std::array<int, kPacket> valid;
  for (std::size_t first = 0; first < rays.size(); first += kPacket) {
    const std::size_t n = std::min<std::size_t>(kPacket, rays.size() - first);
    write_rays(packet.ray, rays.subspan(first, n), kMaskOfGlowing | kMaskOfOthers, valid.data());
    std::ranges::fill(packet.hit.geomID, RTC_INVALID_GEOMETRY_ID);
    std::ranges::fill(packet.hit.instID[0], RTC_INVALID_GEOMETRY_ID);
    embree::intersect(valid.data(), impl_->scene.get(), packet);
    for (std::size_t i = 0; i < n; ++i) {
      const unsigned group = packet.hit.geomID[i];
      hits[first + i] =
          group == RTC_INVALID_GEOMETRY_ID
              ? Hit{}
              : Hit{packet.ray.tfar[i], impl_->triangle_of(group, packet.hit.primID[i]),
                    packet.hit.u[i], packet.hit.v[i]};
    }
  }
}

Hit RayTracer::trace(const Ray& ray) const {
  RTCRayHit single;
  write_ray(&single.ray, 1, 0, ray, kMaskOfGlowing | kMaskOfOthers);
  single.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  single.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  embree::intersect(impl_->scene.get(), single);
  const unsigned group = single.hit.geomID;
  if (group == RTC_INVALID_GEOMETRY_ID) return {};
  return {single.ray.tfar, impl_->triangle_of(group, single.hit.primID), single.hit.u,
          single.hit.v};
}

void RayTracer::blocked(std::span<const Ray> rays, std::span<std::uint8_t> out,
                        Blockers blockers) const {
  EN_CHECK_EQ(rays.size(), out.size());
  const unsigned mask = blockers == Blockers::kAll ? kMaskOfGlowing | kMaskOfOthers : kMaskOfOthers;
  alignas(64) RTCRay16 packet;
  alignas(64) std::array<int, kPacket> valid;
  for (std::size_t first = 0; first < rays.size(); first += kPacket) {
    const std::size_t n = std::min<std::size_t>(kPacket, rays.size() - first);
    write_rays(packet, rays.subspan(first, n), mask, valid.data());
    embree::occluded(valid.data(), impl_->scene.get(), packet);
    // Embree marks a blocked ray by far = -infinity.
    for (std::size_t i = 0; i < n; ++i) out[first + i] = packet.tfar[i] < 0 ? 1 : 0;
  }
}

bool RayTracer::blocked(const Ray& ray) const {
  RTCRay single;
  write_ray(&single, 1, 0, ray, kMaskOfGlowing | kMaskOfOthers);
  embree::occluded(impl_->scene.get(), single);
  return single.tfar < 0;
}

bool RayTracer::sees(Vec3f a, Vec3f b, float slack) const {
  const Vec3f way = b - a;
  const float distance = length(way);
  if (!(distance > 2 * slack)) return true;
  return !blocked({a, way, slack / distance, 1 - slack / distance});
}

}  // namespace enfilade::mesh
