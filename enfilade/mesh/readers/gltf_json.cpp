#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/mesh/readers/gltf.h"
#include "enfilade/mesh/readers/webp.h"

namespace enfilade::mesh::readers {
namespace {

constexpr std::size_t kGlbHeader = 12, kGlbChunkHeader = 8;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);  // little-endian, as the machine is
  return value;
}
void put_word(std::string& out, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  std::array<char, sizeof word> raw{};
  std::memcpy(raw.data(), &word, sizeof word);
  out.append(raw.data(), raw.size());
}

/// An extension that a build reads only with a library.
struct OptionalExtension {
  std::string_view name, library, package;
  bool built;
};
#ifdef EN_WITH_DRACO
constexpr bool kHasDraco = true;
#else
constexpr bool kHasDraco = false;
#endif
#ifdef EN_WITH_MESHOPT
constexpr bool kHasMeshopt = true;
#else
constexpr bool kHasMeshopt = false;
#endif
constexpr std::array kOptionalExtensions{
    OptionalExtension{kDracoCompression, "Draco", "libdraco-dev", kHasDraco},
    OptionalExtension{kMeshoptCompression, "meshoptimizer", "libmeshoptimizer-dev", kHasMeshopt}};

const OptionalExtension* find_optional(std::string_view name) {
  const auto at = std::ranges::find(kOptionalExtensions, name, &OptionalExtension::name);
  return at == kOptionalExtensions.end() ? nullptr : &*at;
}

/// Whether all of an extension is read, or is told elsewhere.
bool is_read(std::string_view name) {
  constexpr auto kRead = std::to_array<std::string_view>(
      {"KHR_texture_transform", "KHR_mesh_quantization", "KHR_lights_punctual",
       "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness", "KHR_xmp",
       "KHR_xmp_json_ld", kBasisTexture, kWebpTexture});
  const OptionalExtension* optional = find_optional(name);
  return std::ranges::find(kRead, name) != kRead.end() || (optional != nullptr && optional->built);
}
/// Whether an extension concerns materials, textures, lights and the like, but no geometry.
bool concerns_looks(std::string_view name) {
  constexpr auto kParts = std::to_array<std::string_view>(
      {"_materials_", "_texture_", "_lights_", "KHR_technique", "MSFT_packing_", "MSFT_lod", "AGI_",
       "KHR_animation_pointer", "KHR_audio", "KHR_blend", "EXT_mesh_features",
       "EXT_structural_metadata", "CESIUM_primitive_outline", "GOOGLE_tilt_brush_material"});
  return std::ranges::any_of(
      kParts, [&](std::string_view part) { return name.find(part) != std::string_view::npos; });
}

void check_extensions(json::Element list, const json::Path& where, json::Faults& faults,
                      const std::string& file, ReadResult& result) {
  const auto names = json::array(list, where, faults);
  if (!names) return;
  std::size_t i = 0;
  for (const json::Element item : *names) {
    const json::Path path(where, i++);
    const auto name = json::string(item, path, faults);
    if (!name || is_read(*name)) continue;
    if (concerns_looks(*name)) {
      warn(result, file, "$.extensionsRequired", "left-out",
           fmt::format("{} is required, but not read: it concerns looks alone", quote(*name)));
    } else if (find_optional(*name) != nullptr) {
      faults.error(path, "unknown-extension", lacks_library(*name));
    } else {
      faults.error(path, "unknown-extension",
                   fmt::format("{} is required, but not known here", quote(*name)));
    }
  }
}

/// Whether tinygltf can read accessors and buffers as they are.
bool is_plain(json::Element root) {
  const auto any = [&](const char* list, const char* field, bool there) {
    simdjson::dom::array items;
    if (root[list].get(items) != simdjson::SUCCESS) return false;
    for (const json::Element item : items) {
      if ((item[field].error() == simdjson::SUCCESS) == there) return true;
    }
    return false;
  };
  return !any("accessors", "bufferView", false) && !any("buffers", "extensions", true);
}

using JsonValue = nlohmann::json;

/// The member that is an object or a list; null if it is missing or something else.
JsonValue* member(JsonValue& object, const char* name) {
  if (!object.is_object()) return nullptr;
  const auto at = object.find(name);
  return at != object.end() && at->is_structured() ? &*at : nullptr;
}

void keep_indices(JsonValue& primitive, const JsonValue& accessors) {
  if (!primitive.is_object()) return;
  const auto at = primitive.find("indices");
  if (at == primitive.end() || !at->is_number_unsigned()) return;
  const auto accessor = at->get<std::size_t>();
  if (accessor >= accessors.size() || accessors[accessor].contains("bufferView")) return;
  JsonValue& extensions = primitive["extensions"];
  if (!extensions.is_object()) extensions = JsonValue::object();
  extensions[std::string(kKeptIndices)] = {{"accessor", accessor}};
  primitive.erase(at);
}

void give_byte(JsonValue& buffer) {
  JsonValue* extensions = member(buffer, "extensions");
  if (extensions == nullptr || buffer.contains("uri")) return;
  const JsonValue* meshopt = member(*extensions, std::string(kMeshoptCompression).c_str());
  if (meshopt == nullptr || !meshopt->is_object() || !meshopt->contains("fallback")) return;
  if ((*meshopt)["fallback"] != true) return;
  buffer["uri"] = "data:application/octet-stream;base64,AA==";
  buffer["byteLength"] = 1;
}

std::string rewrite_json(std::string_view text, const std::string& file) {
  JsonValue root = JsonValue::parse(text, nullptr, false);
  if (root.is_discarded()) refuse(file, "", "bad-gltf", "JSON that only one of two parsers reads");
  JsonValue* accessors = member(root, "accessors");
  if (JsonValue* meshes = member(root, "meshes"); meshes != nullptr && accessors != nullptr) {
    for (JsonValue& mesh : *meshes) {
      JsonValue* primitives = member(mesh, "primitives");
      if (primitives == nullptr || !accessors->is_array()) continue;
      for (JsonValue& primitive : *primitives) keep_indices(primitive, *accessors);
    }
  }
  if (JsonValue* buffers = member(root, "buffers")) {
    for (JsonValue& buffer : *buffers) give_byte(buffer);
  }
  return root.dump(-1, ' ', false, JsonValue::error_handler_t::replace);
}

}  // namespace

bool reads_extension(std::string_view name) {
  const OptionalExtension* optional = find_optional(name);
  return optional != nullptr ? optional->built : name == kWebpTexture && reads_webp();
}

std::string lacks_library(std::string_view name) {
  const OptionalExtension& optional = *find_optional(name);
  return fmt::format("compressed by {}, and this build is without {} ({})", name, optional.library,
                     optional.package);
}

std::string_view gltf_json_chunk(std::string_view glb, const std::string& file) {
  constexpr std::uint32_t kJson = 0x4E4F534A;
  const auto fail = [&](const std::string& what) { refuse(file, "", "bad-container", what); };
  if (glb.size() < kGlbHeader + kGlbChunkHeader) fail("too short for a binary glTF");
  if (word_at(glb, 4) != 2) fail(fmt::format("version {} of glTF, not 2", word_at(glb, 4)));
  const std::size_t length = word_at(glb, 8);
  if (length > glb.size()) fail(fmt::format("{} bytes, but it says {}", glb.size(), length));
  std::string_view json;
  for (std::size_t at = kGlbHeader; at < length;) {
    if (at + kGlbChunkHeader > length || word_at(glb, at) > length - at - kGlbChunkHeader) {
      fail(fmt::format("the chunk at byte {} ends after the file", at));
    }
    const std::size_t size = word_at(glb, at);
    if (at == kGlbHeader) {
      if (word_at(glb, at + 4) != kJson) fail("the first chunk is not JSON");
      json = glb.substr(at + kGlbChunkHeader, size);
    }
    at += kGlbChunkHeader + size;
  }
  return json;
}

bool check_gltf_json(std::string_view text, const std::string& file, ReadResult& result) {
  const json::Document document = json::Document::parse(text, file);
  json::Faults faults(file);
  constexpr std::array<json::Field, 2> kFields{{{"asset", true}, {"extensionsRequired", false}}};
  std::array<std::optional<json::Element>, 2> found;
  const json::Path root, asset(root, "asset"), required(root, "extensionsRequired");
  json::fields(document.root(), kFields, found, root, faults);
  faults.throw_if_errors();
  constexpr std::array<json::Field, 1> kVersion{{{"version", true}}};
  std::array<std::optional<json::Element>, 1> version;
  json::fields(*found[0], kVersion, version, asset, faults);
  faults.throw_if_errors();
  const json::Path version_path(asset, "version");
  if (version[0]->is_number()) {  // of glTF 1.0, where some writers forget the quotes
    faults.error(version_path, "bad-version", "a number, as in files of glTF 1.0, not \"2.x\"");
  } else if (const auto value = json::string(*version[0], version_path, faults);
             value && !value->starts_with("2.")) {
    faults.error(version_path, "bad-version", fmt::format("{}, not 2.x", quote(*value)));
  }
  if (found[1]) check_extensions(*found[1], required, faults, file, result);
  faults.throw_if_errors();
  return is_plain(document.root());
}

std::string rewrite_gltf(std::string_view bytes, const std::string& file) {
  if (!bytes.starts_with("glTF")) return rewrite_json(bytes, file);
  const std::string_view chunk = gltf_json_chunk(bytes, file);
  std::string json = rewrite_json(chunk, file);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::size_t rest = kGlbHeader + kGlbChunkHeader + chunk.size();
  const std::size_t length = word_at(bytes, 8);
  const std::string_view after = bytes.substr(rest, length - rest);
  std::string out(bytes.substr(0, 8));
  out.reserve(rest + json.size() + after.size());
  put_word(out, kGlbHeader + kGlbChunkHeader + json.size() + after.size());
  put_word(out, json.size());
  out += bytes.substr(kGlbHeader + 4, 4);
  out += json;
  out += after;
  return out;
}

}  // namespace enfilade::mesh::readers
