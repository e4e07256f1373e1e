#include "enfilade/mesh/detail/writer.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "enfilade/image/codecs.h"

namespace enfilade::mesh::detail {

std::vector<std::size_t> by_object_and_material(const Mesh& mesh) {
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // kNoObject + 1 is 0.
  std::ranges::stable_sort(order, {}, [&](std::size_t t) {
    return std::pair(object_of(mesh, t) + 1, mesh.triangle_material[t]);
  });
  return order;
}

EncodedTexture encode_texture(const image::Image8& texture) {
  constexpr int kQuality = 92;  // above it files grow faster than differences shrink
  if (texture.channels == 4) return {image::encode_png(texture), "png"};
  return {image::encode_jpeg(texture, kQuality), "jpg"};
}

}  // namespace enfilade::mesh::detail
