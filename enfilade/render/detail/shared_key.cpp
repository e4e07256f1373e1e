#include "enfilade/render/detail/shared_key.h"

#include <xxhash.h>

#include <array>
#include <bit>
#include <string>
#include <string_view>

namespace enfilade::render::detail {
namespace {

SharedKey hash(const void* bytes, std::size_t count) {
  const XXH128_hash_t found = XXH3_128bits(bytes, count);
  return {found.low64, found.high64};
}

SharedKey hash(std::string_view text) { return hash(text.data(), text.size()); }

}  // namespace

SharedKeys::SharedKeys(const scan::PanoramaSet& panoramas)
    : panoramas_(panoramas), sources_(panoramas.size()) {}

std::optional<SharedKey> SharedKeys::key(const FaceKey& face, std::uint32_t size) {
  const scan::PanoramaSource& from = panoramas_.source(face.scan);
  Source& source = sources_[face.scan.at()];
  if (!source.asked) {
    const std::string state = from.state();
    if (!state.empty()) source.hash = hash(state + '\0' + from.origin() + '\0' + from.scan());
    source.asked = true;
  }
  if (!source.hash) return {};
  // The pose too: a state may be of the pictures alone, and turned depth depends on it.
  const scan::PanoramaPose& pose = from.poses()[face.viewpoint.at()];
  const SharedKey viewpoint = hash(pose.viewpoint);
  std::array<std::uint64_t, 19> all{};
  std::size_t next = 0;
  for (const std::uint64_t part :
       {source.hash->low, source.hash->high, viewpoint.low, viewpoint.high,
        std::uint64_t{index(face.layer)}, std::uint64_t{index(face.face)}, std::uint64_t{size}}) {
    all[next++] = part;
  }
  for (const double part : pose.world_from_panorama.m) {
    all[next++] = std::bit_cast<std::uint64_t>(part);
  }
  for (const double part : {pose.position.x, pose.position.y, pose.position.z}) {
    all[next++] = std::bit_cast<std::uint64_t>(part);
  }
  return hash(all.data(), sizeof(all));
}

}  // namespace enfilade::render::detail
