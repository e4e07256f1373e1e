#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "enfilade/mesh/detail/textures.h"
#include "enfilade/mesh/readers/gltf.h"

namespace enfilade::mesh::readers {
namespace {

using tinygltf::Model;
using tinygltf::Value;

double number(const Value& object, const char* key, double otherwise) {
  if (!object.IsObject() || !object.Has(key)) return otherwise;
  const Value& value = object.Get(key);
  return value.IsNumber() ? value.GetNumberAsDouble() : otherwise;
}
/// Numbers of a list; `otherwise` where there are none.
template <std::size_t kCount>
std::array<double, kCount> numbers(const Value& object, const char* key,
                                   std::array<double, kCount> otherwise) {
  if (!object.IsObject() || !object.Has(key) || !object.Get(key).IsArray()) return otherwise;
  const auto& list = object.Get(key).Get<Value::Array>();
  for (std::size_t k = 0; k < std::min(kCount, list.size()); ++k) {
    if (list[k].IsNumber()) otherwise[k] = list[k].GetNumberAsDouble();
  }
  return otherwise;
}
template <class T>
const Value* extension(const T& owner, const char* name) {
  const auto at = owner.extensions.find(name);
  return at == owner.extensions.end() ? nullptr : &at->second;
}

float share(double value) {
  return std::isfinite(value) ? static_cast<float>(std::clamp(value, 0.0, 1.0)) : 1.0F;
}
double at(const std::vector<double>& list, std::size_t k, double otherwise) {
  return k < list.size() ? list[k] : otherwise;
}

/// A reference to a texture, wherever the file has it.
struct TextureUse {
  int texture = -1;
  GltfTexturePlace place;
};

GltfTexturePlace place_of(int set, const Value* transform) {
  GltfTexturePlace out;
  out.set = std::max(set, 0);
  if (transform == nullptr) return out;
  // KHR_texture_transform: scaled, then turned (v down: clockwise), then moved.
  const auto offset = numbers<2>(*transform, "offset", {0, 0});
  const auto scale = numbers<2>(*transform, "scale", {1, 1});
  const double angle = number(*transform, "rotation", 0), c = std::cos(angle), s = std::sin(angle);
  out.map = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
  const double other = number(*transform, "texCoord", out.set);
  if (other >= 0 && other < 256) out.set = static_cast<int>(other);
  return out;
}
TextureUse use_of(const tinygltf::TextureInfo& info) {
  return {info.index, place_of(info.texCoord, extension(info, "KHR_texture_transform"))};
}
/// A textureInfo inside of an extension, which tinygltf leaves as values.
TextureUse use_of(const Value& info) {
  if (!info.IsObject()) return {};
  const Value* transform = nullptr;
  if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform")) {
    transform = &info.Get("extensions").Get("KHR_texture_transform");
  }
  const double index = number(info, "index", -1), set = number(info, "texCoord", 0);
  if (!(index >= 0 && index < 1e9) || !(set >= 0 && set < 256)) return {};
  return {static_cast<int>(index), place_of(static_cast<int>(set), transform)};
}

class MaterialReader {
 public:
  MaterialReader(const Model& model, const Source& source, ReadResult& result)
      : model_(model), source_(source), result_(result) {}

  std::vector<GltfMaterial> read() {
    std::vector<GltfMaterial> out;
    for (std::size_t m = 0; m < model_.materials.size(); ++m) {
      where_ = fmt::format("$.materials[{}]", m);
      out.push_back(read(model_.materials[m]));
    }
    if (!basis_.empty()) {
      warn(result_, source_.name, "", "left-out",
           fmt::format("{} textures in {}, which is not read: `gltf-transform ktxdecompress` "
                       "makes them PNG",
                       basis_.size(), kBasisTexture));
    }
    return out;
  }

 private:
  void complain(std::string where, const char* code, std::string message) {
    warn(result_, source_.name, std::move(where), code, std::move(message));
  }

  GltfMaterial read(const tinygltf::Material& from) {
    GltfMaterial out;
    out.material.name = from.name;
    std::array<double, 4> colour{1, 1, 1, 1};
    TextureUse use;
    if (const Value* old = extension(from, "KHR_materials_pbrSpecularGlossiness")) {
      colour = numbers<4>(*old, "diffuseFactor", colour);
      if (old->Has("diffuseTexture")) use = use_of(old->Get("diffuseTexture"));
    } else {
      const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
      for (std::size_t k = 0; k < 4; ++k) colour[k] = at(pbr.baseColorFactor, k, 1);
      use = use_of(pbr.baseColorTexture);
    }
    out.material.colour = {share(colour[0]), share(colour[1]), share(colour[2])};
    const image::Image8* picture = use.texture >= 0 ? texture(use.texture) : nullptr;
    if (picture != nullptr) {
      out.place = use.place;
      out.material.texture_file = file_;
    }
    set_alpha(from, share(colour[3]), picture, out.material);
    out.material.emission = emission(from);
    return out;
  }

  /// Takes the picture, with its alpha where that says what is cut out.
  void set_alpha(const tinygltf::Material& from, float alpha, const image::Image8* picture,
                 Material& out) {
    const bool has_alpha = picture != nullptr && picture->channels == 4;
    const bool mask = from.alphaMode == "MASK", blend = from.alphaMode == "BLEND";
    // There is no partial transparency here: a blended surface is opaque where its alpha is above
    // one half.
    const float limit = mask ? share(from.alphaCutoff) : 0.5F;
    if ((mask || blend) && alpha <= limit && !(has_alpha && alpha > 0)) {
      complain(where_, "transparent", "a transparent material is taken as opaque");
    }
    if (has_alpha && (mask || blend)) {
      out.texture = *picture;
      out.cutout = alpha > 0 ? std::min(limit / alpha, 1.0F) : 1.0F;
    } else if (has_alpha) {
      out.texture = image::Image8(picture->width, picture->height, 3);
      for (std::size_t i = 0; i < std::size_t{picture->width} * picture->height; ++i) {
        std::copy_n(picture->pixels.data() + 4 * i, 3, out.texture.pixels.data() + 3 * i);
      }
    } else if (picture != nullptr) {
      out.texture = *picture;
    }
  }

  Vec3f emission(const tinygltf::Material& from) {
    double strength = 1;
    if (const Value* e = extension(from, "KHR_materials_emissive_strength")) {
      strength = number(*e, "emissiveStrength", 1);
    }
    constexpr double kMost = 1e6;  // brighter than the sun among relative radiances
    std::array<float, 3> out{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = at(from.emissiveFactor, k, 0) * strength;
      out[k] = value > 0 ? static_cast<float>(std::min(value, kMost)) : 0.0F;
    }
    const Vec3f factor{out[0], out[1], out[2]};
    if (from.emissiveTexture.index < 0 || factor == Vec3f{}) return factor;
    const image::Image8* picture = texture(from.emissiveTexture.index);
    if (picture == nullptr) return factor;
    complain(where_, "mean-emission", "its emissive texture is taken as the mean of its pixels");
    const Vec3f mean = mean_linear(*picture);
    return {factor.x * mean.x, factor.y * mean.y, factor.z * mean.z};
  }
  static Vec3f mean_linear(const image::Image8& picture) {
    std::array<double, 3> sum{};
    const std::size_t pixels = std::size_t{picture.width} * picture.height;
    for (std::size_t i = 0; i < pixels; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        sum[k] += detail::linear_of(picture.pixels[i * picture.channels + k]);
      }
    }
    const auto n = static_cast<double>(pixels);
    return {static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n),
            static_cast<float>(sum[2] / n)};
  }

  /// The picture of a texture, or null with a warning; its name in file_. Valid to the next call.
  const image::Image8* texture(int index) {
    file_.clear();
    const std::string where = fmt::format("$.textures[{}]", index);
    const tinygltf::Texture* texture = item_at(model_.textures, index);
    if (texture == nullptr) {
      complain(where_, "missing-texture",
               fmt::format("texture {} of {}", index, model_.textures.size()));
      return nullptr;
    }
    const int source = source_of(*texture);
    const tinygltf::Image* image = item_at(model_.images, source);
    if (image == nullptr && extension(*texture, "KHR_texture_basisu") != nullptr) {
      basis_.insert(index);  // told once
      return nullptr;
    }
    if (image == nullptr) {
      complain(where, "missing-texture", "no image that is JPEG or PNG");
      return nullptr;
    }
    const std::string image_where = fmt::format("$.images[{}]", source);
    file_ = image->uri.empty()     ? fmt::format("{}#images[{}]", source_.name, source)
            : image->image.empty() ? (source_.folder / image->uri).string()
                                   : image->uri;
    try {
      if (source != decoded_) {
        decoded_ = -1;
        picture_ = textures_.decode(image_bytes(*image, image_where), file_, result_);
        decoded_ = source;
      } else {
        textures_.take(picture_.width, picture_.height, file_);
      }
      return &picture_;
    } catch (const Error& e) {
      if (told_.insert(source).second) complain(image_where, "missing-texture", e.what());
      return nullptr;
    }
  }
  /// The image of a texture: WebP before its copy for other readers, where this build reads it.
  static int source_of(const tinygltf::Texture& texture) {
    const Value* webp = extension(texture, "EXT_texture_webp");
    const bool needed = texture.source < 0 || reads_extension(kWebpTexture);
    if (webp == nullptr || !needed) return texture.source;
    const double image = number(*webp, "source", -1);
    return image >= 0 && image < 1e9 ? static_cast<int>(image) : texture.source;
  }
  std::string_view image_bytes(const tinygltf::Image& image, const std::string& where) const {
    if (image.bufferView >= 0) return view_bytes(model_, image.bufferView, source_.name, where);
    if (image.image.empty()) throw FileError(file_ + ": cannot be read");
    return {reinterpret_cast<const char*>(image.image.data()), image.image.size()};
  }

  const Model& model_;
  const Source& source_;
  ReadResult& result_;
  TextureDecoder textures_;
  std::string where_;  ///< of the material
  std::string file_;
  /// Only the last one is kept: neighbouring materials share pictures, and each owns a copy anyway.
  image::Image8 picture_;
  int decoded_ = -1;
  std::set<int> basis_;  ///< textures that are in Basis Universal alone
  std::set<int> told_;   ///< broken images, each of which gives one warning
};

}  // namespace

std::vector<GltfMaterial> read_gltf_materials(const Model& model, const Source& source,
                                              ReadResult& result) {
  return MaterialReader(model, source, result).read();
}

}  // namespace enfilade::mesh::readers
