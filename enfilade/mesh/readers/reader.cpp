#include "enfilade/mesh/readers/reader.h"

#include <fmt/format.h>
#include <algorithm>
#include <system_error>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/mesh/detail/vector.h"
#include "enfilade/mesh/readers/text.h"

namespace enfilade::mesh::readers {
namespace {

/// Grey becomes RGB, and grey with alpha RGBA.
image::Image8 as_colour(image::Image8 picture) {
  if (picture.channels >= 3) return picture;
  const bool alpha = picture.channels == 2;
  image::Image8 out(picture.width, picture.height, alpha ? 4 : 3);
  for (std::size_t i = 0; i < std::size_t{picture.width} * picture.height; ++i) {
    const std::uint8_t* from = picture.pixels.data() + i * picture.channels;
    std::uint8_t* to = out.pixels.data() + i * out.channels;
    std::fill_n(to, 3, from[0]);
    if (alpha) to[3] = from[1];
  }
  return out;
}

}  // namespace

std::string Source::part(std::string_view relative) const {
  if (!on_disk) throw FileError(fmt::format("{}: {} is not inside it", name, in_quotes(relative)));
  const std::filesystem::path path = folder / std::filesystem::path(relative);
  std::error_code code;
  // Reading a pipe or a device that an untrusted file names could block for ever.
  if (std::filesystem::exists(path, code) && !std::filesystem::is_regular_file(path, code)) {
    throw FileError(path.string() + ": cannot read: not a plain file");
  }
  return read_file(path);
}

void warn(ReadResult& result, const std::string& file, std::string where, std::string code,
          std::string message) {
  result.warnings.push_back(
      {Severity::kWarning, file, std::move(where), std::move(code), std::move(message)});
}

image::Image8 TextureDecoder::decode(std::string_view bytes, const std::string& file) {
  const image::Bytes raw = image::bytes_of(bytes);
  const bool jpeg = bytes.starts_with("\xFF\xD8"), png = bytes.starts_with("\x89PNG");
  if (!jpeg && !png) refuse(file, "", "unknown-picture", "neither a JPEG nor a PNG");
  const image::Shape shape = jpeg ? image::jpeg_shape(raw, file) : image::png_shape(raw, file);
  take(shape.width, shape.height, file);
  return as_colour(jpeg ? image::decode_jpeg(raw, file) : image::decode_png8(raw, file));
}

void TextureDecoder::take(std::uint32_t width, std::uint32_t height, const std::string& file) {
  const std::uint64_t pixels = std::uint64_t{width} * height;
  if (pixels > pixels_left_) {
    refuse(file, "", "too-many-pixels",
           fmt::format("{} x {} pixels, but only {} more are taken of all textures", width, height,
                       pixels_left_));
  }
  pixels_left_ -= pixels;
}

void MeshCollector::add(const std::array<Corner, 3>& corners, std::uint32_t material,
                        std::uint32_t object) {
  std::array<TexturePoint, 3> points{};
  std::array<Vec3f, 3> directions{};
  std::array<std::uint32_t, 3> triangle{};
  for (std::size_t k = 0; k < 3; ++k) {
    triangle[k] = corners[k].position;
    if (corners[k].texture_point != kNone) {
      any_texture_point_ = true;
      points[k] = texture_points[corners[k].texture_point];
    }
    if (corners[k].normal != kNone) {
      any_normal_ = true;
      directions[k] = detail::unit(to_double(normals[corners[k].normal]), {});
    }
  }
  mesh.triangles.push_back(triangle);
  mesh.texture_points.push_back(points);
  mesh.normals.push_back(directions);
  mesh.triangle_material.push_back(material);
  mesh.triangle_object.push_back(object);
  any_object_ = any_object_ || object != kNoObject;
}

Mesh MeshCollector::finish() {
  if (!any_texture_point_) mesh.texture_points.clear();
  if (!any_object_) mesh.triangle_object.clear();
  if (!coloured) mesh.colours.clear();
  if (!any_normal_) {
    mesh.normals.clear();
    return std::move(mesh);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (Vec3f& normal : mesh.normals[t]) {
      if (normal == Vec3f{}) normal = face_normal(mesh, t);
    }
  }
  return std::move(mesh);
}

}  // namespace enfilade::mesh::readers
