/// \file  glTF 2.0 files: what tinygltf does not check. Internal.
#pragma once
#include <tiny_gltf.h>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh::readers {

/// Parses container and JSON. Images are not decoded: they are in `image` if not in a buffer.
/// \throws InvalidInput for files that are not glTF 2.0, and for unknown required extensions;
/// FileError for buffers that cannot be read
tinygltf::Model load_gltf(const Source& source);

/// The item that a file refers to by its number; null if there is none.
template <class T>
const T* item_at(const std::vector<T>& list, int index) {
  const auto at = static_cast<std::size_t>(index);
  return index >= 0 && at < list.size() ? &list[at] : nullptr;
}

/// The bytes of a buffer view. \param where in messages  \throws InvalidInput
std::string_view view_bytes(const tinygltf::Model& model, int view, const std::string& file,
                            const std::string& where);

/// The numbers of an accessor, with sparse ones applied; normalised integers become [0, 1].
struct GltfNumbers {
  std::size_t count = 0;       ///< items
  std::size_t components = 0;  ///< numbers an item
  bool whole = false;          ///< unsigned and not normalised: may be indices
  std::vector<double> values;
};
/// \throws InvalidInput for data outside of its buffer
GltfNumbers read_accessor(const tinygltf::Model& model, int accessor, const std::string& file);

/// Texture coordinates, after KHR_texture_transform.
struct GltfTexturePlace {
  int set = -1;                                 ///< TEXCOORD_<set>; -1: no texture
  std::array<double, 6> map{1, 0, 0, 0, 1, 0};  ///< u' = m0 u + m1 v + m2, v' = m3 u + m4 v + m5
};
struct GltfMaterial {
  Material material;
  GltfTexturePlace place;
};
/// All materials; textures that are missing or broken are warnings.
std::vector<GltfMaterial> read_gltf_materials(const tinygltf::Model& model, const Source& source,
                                              ReadResult& result);

}  // namespace enfilade::mesh::readers
