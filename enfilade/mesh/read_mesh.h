/// \file  Readers of mesh files: glTF, OBJ, PLY; writers of OBJ and binary glTF.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// Which axis of the file points up.
enum class UpAxis : std::uint8_t {
  kFormat,  ///< y for glTF, as it specifies; z for OBJ and PLY, which specify none
  kY,
  kZ,
};

/// How a file's units and axes become metres with +z up.
struct ReadOptions {
  double scale = 1;  ///< metres per unit of the file; > 0
  UpAxis up = UpAxis::kFormat;
};

/// A mesh, and warnings about its file.
struct ReadResult {
  Mesh mesh;  ///< objects: one per named node or group of the file
  std::vector<Diagnostic>
      warnings;  ///< and notes: of check(), odd values, ignored content (lines, cameras, ...)
};

/// Reads a file; the format is that of the name's suffix.
/// - .glb, .gltf (2.0): all nodes of the default scene, as triangles, strips and fans; vertex
///   colours, alpha masks, base colour, emission and their textures. Compressed geometry is read
///   where its library is built in.
/// - .obj, with .mtl and its textures; polygons become fans; vertex colours are sRGB, shares or
///   bytes
/// - .ply, ASCII and binary; polygons become fans; vertex colours are sRGB; textures of
///   `comment TextureFile`
///
/// .mtl: Kd, Ke, map_Kd, cut-outs where map_d is the same file, and Ks as a mirror under illum 3
/// and 5. Textures are JPEG, PNG, and WebP where libwebp is built in. A missing or broken one gives
/// a warning, and the material keeps its colour.
///
/// Numbers that are not finite, and references to missing normals, texture points or materials, are
/// warnings with a count. A computed value stands for each. Only a position that a face uses is an
/// error.
/// \throws FileError
/// \throws InvalidInput naming file and place for broken files, errors of check(), and unknown
/// required extensions of glTF, except those that concern looks alone
/// \throws ArgumentError for options out of range or an unknown suffix
ReadResult read_mesh(const std::filesystem::path& file, const ReadOptions& options = {});

/// The same for a file in memory, with all its parts inside. `name` has the format's suffix.
/// \throws InvalidInput, ArgumentError as read_mesh()
ReadResult parse_mesh(std::string_view bytes, const std::string& name,
                      const ReadOptions& options = {});

/// Writes NAME.obj, NAME.mtl and the textures as JPEG (PNG where they have cut-outs) into a folder,
/// as Matterport3D ships its textured meshes. Groups are objects (`g <place>_<name>`).
/// \throws FileError
void write_obj(const Mesh& mesh, const std::filesystem::path& folder, const std::string& name);
/// The same, in a folder whose links are not followed.
void write_obj(const Mesh& mesh, const OutputFolder& folder, const std::string& name);

/// Writes a binary glTF 2.0 file (.glb), textures inside, as Habitat, Isaac Sim and Blender open
/// it. Objects are nodes, whose `extras` hold instance, category and region. In the file +y is up,
/// as the format requires. read_mesh() gives the same triangles, materials and textures (JPEG, or
/// PNG where they have cut-outs). Only viewers use `mirror`.
/// \throws FileError; ArgumentError for a file of more than 4 GiB
void write_glb(const Mesh& mesh, const std::filesystem::path& file);
/// The bytes of that file. \throws ArgumentError if they are more than 4 GiB
/// \param up  kZ: coordinates are as here. glTF does not allow that, but Habitat takes every .glb
/// that is opened by its path to be z up.
std::string to_glb(const Mesh& mesh, UpAxis up = UpAxis::kFormat);
/// The same for viewers, packed as gzip does. Numbers whose last bits say nothing are rounded, so
/// that it has half the size: positions to 1/65536 m, texture points to 1/4096, colours to 1/512.
std::string to_packed_glb(Mesh mesh);

}  // namespace enfilade::mesh
