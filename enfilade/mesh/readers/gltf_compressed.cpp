// Compressed geometry of glTF: EXT_meshopt_compression and KHR_draco_mesh_compression.

#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <utility>

#include "enfilade/mesh/readers/gltf.h"

#ifdef EN_WITH_MESHOPT
#include <meshoptimizer.h>
#endif
#ifdef EN_WITH_DRACO
#include <draco/compression/decode.h>
#endif

namespace enfilade::mesh::readers {
namespace {

using tinygltf::Model;
using tinygltf::Value;

const Value* extension_of(const tinygltf::ExtensionMap& extensions, std::string_view name) {
  const auto at = extensions.find(std::string(name));
  return at == extensions.end() || !at->second.IsObject() ? nullptr : &at->second;
}

/// A whole number from 0 on; `otherwise` if it is missing, nothing if it is something else.
[[maybe_unused]] std::optional<std::size_t> count_of(
    const Value& object, const char* key, std::optional<std::size_t> otherwise = std::nullopt) {
  if (!object.Has(key)) return otherwise;
  const Value& value = object.Get(key);
  constexpr double kMost = 1e15;  // exact as a double
  const double number = value.IsNumber() ? value.GetNumberAsDouble() : -1;
  if (!(number >= 0 && number <= kMost)) return std::nullopt;
  return static_cast<std::size_t>(number);
}
[[maybe_unused]] std::string text_of(const Value& object, const char* key, const char* otherwise) {
  if (!object.Has(key) || !object.Get(key).IsString()) return otherwise;
  return object.Get(key).Get<std::string>();
}

}  // namespace

bool is_meshopt_alone(const Model& model, const tinygltf::BufferView& view) {
  if (extension_of(view.extensions, kMeshoptCompression) == nullptr) return false;
  const tinygltf::Buffer* buffer = item_at(model.buffers, view.buffer);
  const Value* extension =
      buffer == nullptr ? nullptr : extension_of(buffer->extensions, kMeshoptCompression);
  if (extension == nullptr) return false;
  const Value& fallback = extension->Get("fallback");
  return fallback.IsBool() && fallback.Get<bool>();
}

#ifdef EN_WITH_MESHOPT

namespace {

/// Unpacks one buffer view.
class MeshoptView {
 public:
  MeshoptView(const Model& model, const Value& extension, const std::string& file,
              std::string where)
      : model_(model), extension_(extension), file_(file), where_(std::move(where)) {}

  std::vector<unsigned char> unpack() {
    const std::string_view packed = bytes();
    count_ = number("count");
    stride_ = number("byteStride");
    // Each byte of a stream has at least two bits per 16 of its value bytes.
    constexpr std::size_t kMostRatio = 64;
    if (stride_ == 0 || stride_ > 256 || count_ > kMostRatio * packed.size() / stride_ + 64) {
      fail(fmt::format("{} items of {} bytes, from {} bytes", count_, stride_, packed.size()));
    }
    std::vector<unsigned char> out(count_ * stride_);
    if (decode(packed, out) != 0) fail("its data are damaged");
    filter(out);
    return out;
  }
  std::size_t stride() const {
    return text_of(extension_, "mode", "") == "ATTRIBUTES" ? stride_ : 0;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    refuse(file_, where_, "bad-compression", fmt::format("{}: {}", kMeshoptCompression, what));
  }
  std::size_t number(const char* key, std::optional<std::size_t> otherwise = std::nullopt) const {
    const auto value = count_of(extension_, key, otherwise);
    if (!value) fail(fmt::format("{} is missing, or no whole number", key));
    return *value;
  }
  std::string_view bytes() const {
    const std::size_t index = number("buffer"), offset = number("byteOffset", 0),
                      length = number("byteLength");
    if (index >= model_.buffers.size()) {
      fail(fmt::format("buffer {} of {}", index, model_.buffers.size()));
    }
    const auto& data = model_.buffers[index].data;
    if (offset > data.size() || length > data.size() - offset) {
      fail(fmt::format("{} bytes from {} on end after their buffer's {}", length, offset,
                       data.size()));
    }
    return {reinterpret_cast<const char*>(data.data()) + offset, length};
  }
  int decode(std::string_view packed, std::vector<unsigned char>& out) const {
    const auto* from = reinterpret_cast<const unsigned char*>(packed.data());
    const std::string mode = text_of(extension_, "mode", "");
    const bool index = stride_ == 2 || stride_ == 4;
    if (mode == "ATTRIBUTES" && stride_ % 4 == 0) {
      return meshopt_decodeVertexBuffer(out.data(), count_, stride_, from, packed.size());
    }
    if (mode == "TRIANGLES" && index && count_ % 3 == 0) {
      return meshopt_decodeIndexBuffer(out.data(), count_, stride_, from, packed.size());
    }
    if (mode == "INDICES" && index) {
      return meshopt_decodeIndexSequence(out.data(), count_, stride_, from, packed.size());
    }
    fail(fmt::format("{} items of {} bytes in the mode {}", count_, stride_, quote(mode)));
  }
  void filter(std::vector<unsigned char>& out) const {
    const std::string name = text_of(extension_, "filter", "NONE");
    if (name == "NONE") return;
    const bool words = stride_ == 4 || stride_ == 8;
    if (name == "OCTAHEDRAL" && words) {
      meshopt_decodeFilterOct(out.data(), count_, stride_);
    } else if (name == "QUATERNION" && stride_ == 8) {
      meshopt_decodeFilterQuat(out.data(), count_, stride_);
    } else if (name == "EXPONENTIAL" && stride_ % 4 == 0) {
      meshopt_decodeFilterExp(out.data(), count_, stride_);
    } else {
      fail(fmt::format("the filter {} for items of {} bytes", quote(name), stride_));
    }
  }

  const Model& model_;
  const Value& extension_;
  const std::string& file_;
  std::string where_;
  std::size_t count_ = 0, stride_ = 0;
};

}  // namespace

void unpack_meshopt(Model& model, const std::string& file) {
  std::size_t left = std::size_t{1} << 20;  // bytes, of all views together
  for (const tinygltf::Buffer& buffer : model.buffers) left += 64 * buffer.data.size();
  for (std::size_t v = 0; v < model.bufferViews.size(); ++v) {
    tinygltf::BufferView& view = model.bufferViews[v];
    const Value* extension = extension_of(view.extensions, kMeshoptCompression);
    if (extension == nullptr) continue;
    MeshoptView packed(model, *extension, file, fmt::format("$.bufferViews[{}]", v));
    tinygltf::Buffer buffer;
    buffer.data = packed.unpack();
    if (buffer.data.size() > left) {
      refuse(file, fmt::format("$.bufferViews[{}]", v), "too-large",
             "its views unpack the same bytes again and again");
    }
    left -= buffer.data.size();
    view.buffer = static_cast<int>(model.buffers.size());
    view.byteOffset = 0;
    view.byteLength = buffer.data.size();
    view.byteStride = packed.stride();
    model.buffers.push_back(std::move(buffer));
  }
}

#else

void unpack_meshopt(Model& /*model*/, const std::string& /*file*/) {}

#endif

namespace {

/// Whether the primitive's own accessors have data.
bool has_plain_copy(const Model& model, const tinygltf::Primitive& primitive) {
  const auto at = primitive.attributes.find("POSITION");
  const tinygltf::Accessor* accessor =
      at == primitive.attributes.end() ? nullptr : item_at(model.accessors, at->second);
  return accessor != nullptr && (accessor->bufferView >= 0 || accessor->sparse.isSparse);
}

}  // namespace

#ifdef EN_WITH_DRACO

namespace {

class DracoReader {
 public:
  DracoReader(const Model& model, const tinygltf::Primitive& primitive, const Value& extension,
              const std::string& file, const std::string& where)
      : model_(model), primitive_(primitive), extension_(extension), file_(file), where_(where) {}

  DracoPrimitive read() {
    const auto view = count_of(extension_, "bufferView");
    if (!view || *view > std::numeric_limits<int>::max()) fail("no bufferView");
    const std::string_view bytes = view_bytes(model_, static_cast<int>(*view), file_, where_);
    check_header(bytes);
    draco::DecoderBuffer buffer;
    buffer.Init(bytes.data(), bytes.size());
    try {
      draco::Decoder decoder;
      auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
      if (!decoded.ok()) fail(decoded.status().error_msg_string());
      mesh_ = std::move(decoded).value();
    } catch (const std::bad_alloc&) {
      fail("more memory than there is");
    }
    if (mesh_ == nullptr) fail("no mesh");
    DracoPrimitive out;
    read_indices(out);
    read_attributes(out);
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    refuse(file_, where_, "bad-compression",
           fmt::format("{}: {}", kDracoCompression, what.substr(0, 200)));
  }

  /// Compares the number of faces with the file's size before Draco allocates memory for it.
  void check_header(std::string_view bytes) const {
    constexpr std::size_t kHeader = 11;
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
    if (bytes.size() < kHeader + 2 || !bytes.starts_with("DRACO")) fail("no data of Draco's");
    if (byte(5) != 2 || byte(6) != 2) {
      fail(fmt::format("version {}.{} of its bit stream, not 2.2", byte(5), byte(6)));
    }
    constexpr unsigned kMetadata = 0x80;  // of the second byte of its flags
    if (byte(7) != 1 || byte(8) > 1 || (byte(10) & kMetadata) != 0) {
      fail("no mesh without metadata, as glTF wants it");
    }
    std::string_view rest = bytes.substr(kHeader + (byte(8) == 1 ? 1 : 0));
    const std::uint64_t first = variable(rest), second = variable(rest);
    // Its smallest meshes are regular grids: about a bit per triangle.
    const std::uint64_t most = (std::uint64_t{1} << 20) + 64 * bytes.size();
    if (first > most || second > most) {
      fail(fmt::format("{} and {} faces and vertices, from {} bytes", first, second, bytes.size()));
    }
  }
  std::uint64_t variable(std::string_view& bytes) const {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35; shift += 7) {
      if (bytes.empty()) break;
      const auto byte = static_cast<unsigned char>(bytes[0]);
      bytes.remove_prefix(1);
      value |= std::uint64_t{byte & 0x7FU} << shift;
      if ((byte & 0x80U) == 0) return value;
    }
    fail("a damaged number of faces");
  }

  void read_indices(DracoPrimitive& out) const {
    const std::uint32_t points = mesh_->num_points();
    out.indices.reserve(3 * std::size_t{mesh_->num_faces()});
    for (draco::FaceIndex f(0); f < mesh_->num_faces(); ++f) {
      for (const draco::PointIndex& point : mesh_->face(f)) {
        if (point.value() >= points) fail(fmt::format("vertex {} of {}", point.value(), points));
        out.indices.push_back(point.value());
      }
    }
  }
  void read_attributes(DracoPrimitive& out) const {
    if (!extension_.Has("attributes") || !extension_.Get("attributes").IsObject()) {
      fail("no attributes");
    }
    const Value& attributes = extension_.Get("attributes");
    for (const std::string& name : attributes.Keys()) {
      const auto id = count_of(attributes, name.c_str());
      const draco::PointAttribute* attribute =
          id && *id <= std::numeric_limits<std::uint32_t>::max()
              ? mesh_->GetAttributeByUniqueId(static_cast<std::uint32_t>(*id))
              : nullptr;
      if (attribute == nullptr) fail(fmt::format("no attribute {}", quote(name)));
      out.attributes.emplace(name, numbers(name, *attribute));
    }
  }
  GltfNumbers numbers(const std::string& name, const draco::PointAttribute& attribute) const {
    GltfNumbers out;
    out.count = mesh_->num_points();
    out.components = static_cast<std::size_t>(attribute.num_components());
    constexpr std::size_t kMostComponents = 4;
    if (out.components == 0 || out.components > kMostComponents) {
      fail(fmt::format("{} of {} numbers", quote(name), out.components));
    }
    const double one = attribute.normalized() ? 0 : one_of(name);
    out.values.reserve(out.count * out.components);
    for (draco::PointIndex point(0); point < mesh_->num_points(); ++point) {
      const draco::AttributeValueIndex value = attribute.mapped_index(point);
      std::array<float, kMostComponents> item{};
      if (value.value() >= attribute.size() ||
          !attribute.ConvertValue<float>(value, static_cast<std::int8_t>(out.components),
                                         item.data())) {
        fail(fmt::format("{} has no value {}", quote(name), value.value()));
      }
      for (std::size_t k = 0; k < out.components; ++k) {
        out.values.push_back(one > 0 ? std::max(item[k] / one, -1.0) : double{item[k]});
      }
    }
    return out;
  }
  /// What stands for 1 in the accessor of an attribute; 0 if it is not normalised.
  double one_of(const std::string& name) const {
    const auto at = primitive_.attributes.find(name);
    const tinygltf::Accessor* accessor =
        at == primitive_.attributes.end() ? nullptr : item_at(model_.accessors, at->second);
    return accessor == nullptr ? 0 : normalised_one(*accessor);
  }

  const Model& model_;
  const tinygltf::Primitive& primitive_;
  const Value& extension_;
  const std::string& file_;
  const std::string& where_;
  std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace

#endif

std::optional<DracoPrimitive> read_draco(const Model& model, const tinygltf::Primitive& primitive,
                                         const std::string& file, const std::string& where) {
  const Value* extension = extension_of(primitive.extensions, kDracoCompression);
  if (extension == nullptr || has_plain_copy(model, primitive)) return std::nullopt;
#ifdef EN_WITH_DRACO
  return DracoReader(model, primitive, *extension, file, where).read();
#else
  refuse(file, where, "bad-compression", lacks_library(kDracoCompression));
#endif
}

}  // namespace enfilade::mesh::readers
