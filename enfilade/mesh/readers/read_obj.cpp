// Wavefront OBJ, read here rather than by tinyobjloader (2.0 rc 10), which takes "nan" and words
// for 0, wraps polygons of more than 255 corners, and names no lines.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "enfilade/image/tone.h"
#include "enfilade/mesh/readers/reader.h"
#include "enfilade/mesh/readers/text.h"

namespace enfilade::mesh::readers {
namespace {

class ObjReader {
 public:
  explicit ObjReader(const Source& source)
      : source_(source), lines_(source.bytes), faults_(source.name) {}

  ReadResult read() {
    std::string joined;
    while (auto line = lines_.next()) {
      if (line->ends_with('\\')) {  // goes on in the next line
        joined.clear();
        for (; line && line->ends_with('\\'); line = lines_.next()) {
          joined += line->substr(0, line->size() - 1);
          joined += ' ';
        }
        if (line) joined += *line;
        read_line(joined);
      } else {
        read_line(*line);
      }
    }
    faults_.throw_if_any();
    name_missing_materials();
    for (const auto& [what, times] : left_out_) {
      warn(out_, source_.name, "", "left-out", fmt::format("{} {} lines", times, what));
    }
    out_.mesh = mesh_.finish();
    return std::move(out_);
  }

 private:
  void read_line(std::string_view rest) {
    const std::string_view key = cut_word(rest);
    if (key.empty() || key[0] == '#') return;
    if (key == "v") {
      read_position(rest);
    } else if (key == "vt") {
      read_texture_point(rest);
    } else if (key == "vn") {
      read_normal(rest);
    } else if (key == "f") {
      read_face(rest);
    } else if (key == "usemtl") {
      material_ = material_named(std::string(trim(rest)));
    } else if (key == "mtllib") {
      read_library(trim(rest));
    } else if (key == "g" || key == "o") {
      start_object(rest);
    } else if (key != "s") {
      ++left_out_[is_known(key) ? std::string(key) : "unknown"];
    }
  }
  static bool is_known(std::string_view key) {
    constexpr std::array<std::string_view, 8> kKnown{"l",    "p",      "vp",   "curv",
                                                     "surf", "cstype", "trim", "parm"};
    return std::ranges::find(kKnown, key) != kKnown.end();
  }

  /// Reads up to 8 numbers. Gives how many there are, at least `least`; 0 after a fault.
  std::size_t numbers(std::string_view rest, std::size_t least, std::array<float, 8>& out) {
    std::size_t n = 0;
    for (std::string_view word = cut_word(rest); !word.empty() && n < out.size();
         word = cut_word(rest)) {
      const auto value = to_number(word);
      if (!value) {
        faults_.error(lines_.where(), "bad-value",
                      fmt::format("{}, not a finite number", in_quotes(word)));
        return 0;
      }
      out[n++] = static_cast<float>(*value);
    }
    if (n >= least) return n;
    faults_.error(lines_.where(), "bad-value", fmt::format("{} numbers, not {}", n, least));
    return 0;
  }
  void read_position(std::string_view rest) {
    std::array<float, 8> v{};
    const std::size_t n = numbers(rest, 3, v);
    mesh_.mesh.positions.push_back({v[0], v[1], v[2]});
    // Many programs write a colour after the position, which the format does not specify.
    const bool coloured = n >= 6;
    mesh_.coloured = mesh_.coloured || coloured;
    const auto linear = [](float c) { return image::linear_from_srgb(std::clamp(c, 0.0F, 1.0F)); };
    mesh_.mesh.colours.push_back(coloured ? Vec3f{linear(v[3]), linear(v[4]), linear(v[5])}
                                          : Vec3f{1, 1, 1});
  }
  void read_texture_point(std::string_view rest) {
    std::array<float, 8> v{};
    numbers(rest, 1, v);
    mesh_.texture_points.push_back({v[0], 1 - v[1]});  // v goes up in OBJ
  }
  void read_normal(std::string_view rest) {
    std::array<float, 8> v{};
    numbers(rest, 3, v);
    mesh_.normals.push_back({v[0], v[1], v[2]});
  }

  /// Counts from 1, or backwards from the last one before this line.
  bool read_index(std::string_view word, const char* what, std::size_t size, std::uint32_t& out) {
    const auto value = to_integer(word);
    const auto n = static_cast<std::int64_t>(size);
    if (value && *value > 0 && *value <= n) {
      out = static_cast<std::uint32_t>(*value - 1);
    } else if (value && *value < 0 && *value >= -n) {
      out = static_cast<std::uint32_t>(n + *value);
    } else {
      faults_.error(lines_.where(), "bad-index",
                    fmt::format("{} {}, not one of the {} before it", what, in_quotes(word), size));
      return false;
    }
    return true;
  }
  /// "1", "1/2", "1//3" or "1/2/3".
  bool read_corner(std::string_view word, Corner& out) {
    std::array<std::string_view, 3> part;
    for (std::string_view& p : part) {
      const std::size_t end = std::min(word.find('/'), word.size());
      p = word.substr(0, end);
      word.remove_prefix(std::min(end + 1, word.size()));
    }
    return read_index(part[0], "position", mesh_.mesh.positions.size(), out.position) &&
           (part[1].empty() ||
            read_index(part[1], "texture point", mesh_.texture_points.size(), out.texture_point)) &&
           (part[2].empty() || read_index(part[2], "normal", mesh_.normals.size(), out.normal));
  }
  void read_face(std::string_view rest) {
    corners_.clear();
    for (std::string_view word = cut_word(rest); !word.empty(); word = cut_word(rest)) {
      Corner corner;
      if (!read_corner(word, corner)) return;
      corners_.push_back(corner);
    }
    if (corners_.size() < 3) {
      ++left_out_["f (fewer than 3 corners)"];
      return;
    }
    if (!material_) material_ = material_named("");
    if (!object_) object_ = object_named();
    for (std::size_t k = 2; k < corners_.size(); ++k) {
      mesh_.add({corners_[0], corners_[k - 1], corners_[k]}, *material_, *object_);
    }
  }

  void start_object(std::string_view rest) {
    name_ = trim(rest);
    object_.reset();  // its first face adds it: many groups have none
  }
  std::uint32_t object_named() {
    if (name_.empty()) return kNoObject;
    const auto [at, fresh] =
        objects_.emplace(name_, static_cast<std::uint32_t>(mesh_.mesh.objects.size()));
    if (fresh) mesh_.mesh.objects.push_back({name_, 0, -1});
    return at->second;
  }

  std::uint32_t material_named(const std::string& name) {
    const auto [at, fresh] =
        materials_.emplace(name, static_cast<std::uint32_t>(mesh_.mesh.materials.size()));
    if (fresh) {
      mesh_.mesh.materials.emplace_back().name = name;
      known_.push_back(name.empty());
    }
    return at->second;
  }
  void name_missing_materials() {
    for (std::size_t m = 0; m < known_.size(); ++m) {
      if (known_[m]) continue;
      warn(out_, source_.name, "", "missing-material",
           fmt::format("material {} is in no .mtl", in_quotes(mesh_.mesh.materials[m].name)));
    }
  }
  /// One name with blanks, or several names: the format leaves it open.
  void read_library(std::string_view names) {
    try {
      read_library_file(names, source_.part(names));
      return;
    } catch (const FileError& e) {
      const auto single = words(names);
      if (single.size() < 2) {
        warn(out_, source_.name, lines_.where(), "missing-material", e.what());
        return;
      }
      for (const std::string_view name : single) read_library(name);
    }
  }
  void read_library_file(std::string_view name, const std::string& text) {
    if (!libraries_.insert(std::string(name)).second) return;
    const std::string file = (source_.folder / std::filesystem::path(name)).string();
    for (MtlMaterial& m : parse_mtl(text, file, out_.warnings)) {
      const std::uint32_t place = material_named(m.material.name);
      known_[place] = true;
      if (!m.colour_map.empty()) read_texture(m, file);
      mesh_.mesh.materials[place] = std::move(m.material);
    }
  }
  void read_texture(MtlMaterial& m, const std::string& file) {
    Material& material = m.material;
    try {
      // Names are relative to the .mtl's folder, which is nearly always the .obj's.
      material.texture_file = (source_.folder / m.colour_map).string();
      material.texture = textures_.decode(source_.part(m.colour_map), material.texture_file);
    } catch (const Error& e) {
      material.texture_file.clear();
      warn(out_, file, material.name, "missing-texture", e.what());
      return;
    }
    if (material.texture.channels == 4 && m.alpha_map == m.colour_map) material.cutout = 0.5F;
    if (material.colour == Vec3f{}) {
      material.colour = {1, 1, 1};
      warn(out_, file, material.name, "black-material",
           "Kd is 0 and would hide the texture; taken as 1");
    }
  }

  const Source& source_;
  Lines lines_;
  FaultList faults_;
  ReadResult out_;
  MeshCollector mesh_;
  TextureDecoder textures_;
  std::string name_;  ///< of the group
  std::optional<std::uint32_t> material_, object_;
  std::unordered_map<std::string, std::uint32_t> materials_, objects_;
  std::set<std::string> libraries_;  ///< that were read
  std::vector<bool> known_;          ///< was the material in a file?
  std::map<std::string, std::size_t> left_out_;
  std::vector<Corner> corners_;
};

}  // namespace

ReadResult read_obj(const Source& source) { return ObjReader(source).read(); }

}  // namespace enfilade::mesh::readers
