/// \file  glTF 2.0 files: what tinygltf does not check. Internal.
#pragma once
#include <tiny_gltf.h>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh::readers {

inline constexpr std::string_view kDracoCompression = "KHR_draco_mesh_compression";
inline constexpr std::string_view kMeshoptCompression = "EXT_meshopt_compression";
inline constexpr std::string_view kWebpTexture = "EXT_texture_webp";
inline constexpr std::string_view kBasisTexture = "KHR_texture_basisu";
/// Where rewrite_gltf() keeps a primitive's indices.
inline constexpr std::string_view kKeptIndices = "ENFILADE_indices";

/// Whether this build reads one of the four extensions above.
bool reads_extension(std::string_view name);
/// "compressed by NAME, and this build is without LIBRARY (PACKAGE)".
/// \pre one of the two compressions
std::string lacks_library(std::string_view name);

/// The JSON text of a .glb, whose parts all lie inside the file (glTF 2.0, 4.4).
/// \throws InvalidInput
std::string_view gltf_json_chunk(std::string_view glb, const std::string& file);
/// Checks version and required extensions. To be called before tinygltf, whose parser recurses:
/// simdjson refuses JSON that is nested too deeply. Required extensions that concern looks alone
/// are warnings.
/// \returns whether tinygltf can read the text as it is
/// \throws InvalidInput
bool check_gltf_json(std::string_view text, const std::string& file, ReadResult& result);
/// The file, .glb or text, changed so that tinygltf reads it. Indices in accessors without a buffer
/// view become an extension (kKeptIndices). Fallback buffers without bytes get one byte.
/// \pre check_gltf_json() accepts it
std::string rewrite_gltf(std::string_view bytes, const std::string& file);

/// Parses container and JSON. Images are not decoded: they are in `image` if not in a buffer. The
/// `uri` of those that were read is their file's path.
/// \throws InvalidInput for files that are not glTF 2.0, and for unknown required extensions;
/// FileError for buffers that cannot be read
tinygltf::Model load_gltf(const Source& source, ReadResult& result);

/// Replaces buffer views of EXT_meshopt_compression by their contents, where it is built in.
/// \throws InvalidInput
void unpack_meshopt(tinygltf::Model& model, const std::string& file);
/// Whether a view's bytes are compressed, without a copy for other readers.
bool is_meshopt_alone(const tinygltf::Model& model, const tinygltf::BufferView& view);

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
/// What stands for 1 in an accessor of normalised integers; 0: none are there.
double normalised_one(const tinygltf::Accessor& accessor);
/// The most vertices and indices that a file may have, all instances together.
std::size_t most_items(const tinygltf::Model& model);

/// A primitive that KHR_draco_mesh_compression holds: triangles.
struct DracoPrimitive {
  std::vector<std::uint32_t> indices;  ///< three per triangle, each below the attributes' count
  std::map<std::string, GltfNumbers> attributes;
};
/// Nothing if the primitive is not compressed, or has a copy for other readers.
/// \throws InvalidInput, also if the build has no Draco
std::optional<DracoPrimitive> read_draco(const tinygltf::Model& model,
                                         const tinygltf::Primitive& primitive,
                                         const std::string& file, const std::string& where);

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
