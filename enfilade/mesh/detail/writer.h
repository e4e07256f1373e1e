/// \file  Shared parts of the writers of mesh files. Internal.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh::detail {

/// Places of all triangles, by object (those of none first), then by material.
std::vector<std::size_t> by_object_and_material(const Mesh& mesh);

/// A texture as a file: PNG if it has cut-outs, else JPEG.
struct EncodedTexture {
  std::vector<std::uint8_t> bytes;
  std::string_view suffix;  ///< "png" or "jpg"
};
EncodedTexture encode_texture(const image::Image8& texture);

}  // namespace enfilade::mesh::detail
