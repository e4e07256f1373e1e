/// \file  Shared by the readers of mesh formats: sources, textures, assembly of triangles.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/mesh/read_mesh.h"

namespace enfilade::mesh::readers {

/// The bytes of a mesh file, and where its other parts lie.
struct Source {
  std::string_view bytes;
  std::string name;              ///< in messages
  std::filesystem::path folder;  ///< of its other parts
  bool on_disk = false;          ///< else there are no other parts

  /// Another file that this one names. \throws FileError, also if it is not a plain file
  std::string part(std::string_view relative) const;
};

/// In the file's own units and axes; materials' textures included, check() not called.
ReadResult read_ply(const Source& source);
ReadResult read_obj(const Source& source);
ReadResult read_gltf(const Source& source);

/// A material of a .mtl and the names of its textures, which are not read yet.
struct MtlMaterial {
  Material material;
  std::string colour_map, alpha_map;
};
/// Materials of an OBJ. Invalid lines give warnings, as a mesh without a colour can still be used.
/// \param file in messages
std::vector<MtlMaterial> parse_mtl(std::string_view text, const std::string& file,
                                   std::vector<Diagnostic>& warnings);

/// \param file its name in the message
void warn(ReadResult& result, const std::string& file, std::string where, std::string code,
          std::string message);

/// Decodes textures, within a limit of pixels for the whole file.
class TextureDecoder {
 public:
  /// JPEG or PNG as RGB or RGBA. \throws InvalidInput
  image::Image8 decode(std::string_view bytes, const std::string& file);
  /// Counts a picture that is stored once more. \throws InvalidInput
  void take(std::uint32_t width, std::uint32_t height, const std::string& file);

 private:
  std::uint64_t pixels_left_ = std::uint64_t{1} << 29;  ///< 1.6 GB as RGB
};

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Indices of one corner of a triangle; kNone: missing.
struct Corner {
  std::uint32_t position = 0, texture_point = kNone, normal = kNone;
};

/// Collects triangles. Lists that no triangle uses stay empty.
class MeshCollector {
 public:
  Mesh mesh;
  std::vector<TexturePoint> texture_points;
  std::vector<Vec3f> normals;  ///< any length
  bool coloured = false;       ///< whether mesh.colours is used

  /// \pre indices are valid
  void add(const std::array<Corner, 3>& corners, std::uint32_t material, std::uint32_t object);
  Mesh finish();

 private:
  bool any_texture_point_ = false, any_normal_ = false, any_object_ = false;
};

}  // namespace enfilade::mesh::readers
