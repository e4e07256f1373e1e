// Wavefront OBJ, read here rather than by tinyobjloader (2.0 rc 10), which takes "nan" and words
// for 0, wraps polygons of more than 255 corners, and names no lines.

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "enfilade/core/written_lists.h"
#include "enfilade/image/tone.h"
#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh::readers {
namespace {

/// A material of a .mtl and the names of its textures, which are not read yet.
struct MtlMaterial {
  Material material;
  std::string colour_map, alpha_map;
};

/// An option of a map. Options come before the file's name, each followed by words of its own.
struct MapOption {
  std::string_view name;
  int least, most;  ///< the last ones only if they are numbers
};
constexpr std::array kMapOptions{
    MapOption{"-blendu", 1, 1}, MapOption{"-blendv", 1, 1},    MapOption{"-cc", 1, 1},
    MapOption{"-clamp", 1, 1},  MapOption{"-texres", 1, 1},    MapOption{"-imfchan", 1, 1},
    MapOption{"-bm", 1, 1},     MapOption{"-boost", 1, 1},     MapOption{"-type", 1, 1},
    MapOption{"-mm", 2, 2},     MapOption{"-o", 1, 3},         MapOption{"-s", 1, 3},
    MapOption{"-t", 1, 3},      MapOption{"-colorspace", 1, 1}};

/// Reads the materials of an OBJ. Invalid lines give warnings, as a mesh without a colour can still
/// be used.
class MtlParser {
 public:
  MtlParser(std::string_view text, const std::string& file, std::vector<Diagnostic>& warnings)
      : lines_(text), file_(file), warnings_(warnings) {}

  std::vector<MtlMaterial> parse() {
    while (const auto line = lines_.next()) {
      std::string_view rest = *line;
      const std::string_view word = cut_word(rest);
      const std::string key = lower(word);  // some programs write "map_kd"
      if (key == "newmtl") {
        finish();
        out_.emplace_back();
        illumination_ = 0;
        specular_ = {};
        out_.back().material.name = trimmed(rest);
      } else if (!out_.empty()) {
        read(key, word, rest);
      }
    }
    finish();
    return std::move(out_);
  }

 private:
  void warn(std::string message) {
    constexpr std::size_t kMost = 100;
    if (given_++ >= kMost) return;
    warnings_.push_back(
        {Severity::kWarning, file_, lines_.where(), "bad-material", std::move(message)});
  }

  /// \param word the key as it is in the file
  void read(std::string_view key, std::string_view word, std::string_view rest) {
    Material& material = out_.back().material;
    if (key == "kd") {
      material.colour = colour(word, rest, 1).value_or(material.colour);
    } else if (key == "ke") {
      material.emission = colour(word, rest, 1e6F).value_or(material.emission);
    } else if (key == "ks") {
      specular_ = colour(word, rest, 1).value_or(Vec3f{});
    } else if (key == "illum") {
      illumination_ = to_integer(trimmed(rest)).value_or(0);
    } else if (key == "map_kd") {
      out_.back().colour_map = map_file(rest);
    } else if (key == "map_d") {
      out_.back().alpha_map = map_file(rest);
    }
  }
  /// One number stands for all three, as the format says.
  std::optional<Vec3f> colour(std::string_view key, std::string_view rest, float most) {
    std::array<float, 3> value{};
    const auto found = words(rest.substr(0, rest.find('#')));
    if (found.size() != 1 && found.size() != 3) {
      warn(fmt::format("{} of {} words, not of 1 or 3 numbers", key, found.size()));
      return std::nullopt;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string_view word = found[std::min(k, found.size() - 1)];
      const auto number = to_number(word);
      if (!number || *number < 0) {
        warn(fmt::format("{} {}, not 0 or more", key, quote(word)));
        return std::nullopt;
      }
      if (*number > most) warn(fmt::format("{} {}, taken as {}", key, *number, most));
      value[k] = std::min(static_cast<float>(*number), most);
    }
    return Vec3f{value[0], value[1], value[2]};
  }
  std::string map_file(std::string_view rest) {
    for (rest = trimmed(rest); rest.starts_with('-'); rest = trimmed(rest)) {
      std::string_view after = rest;
      const auto option = std::ranges::find(kMapOptions, cut_word(after), &MapOption::name);
      if (option == kMapOptions.end()) break;
      if (option->name == "-s" || option->name == "-o") {
        warn(fmt::format("option {} of a texture is not looked at", option->name));
      }
      for (int k = 0; k < option->most; ++k) {
        std::string_view next = after;
        const std::string_view word = cut_word(next);
        if (k >= option->least && !to_number(word)) break;
        after = next;
      }
      rest = after;
    }
    return std::string(rest);
  }
  /// `illum 3` and 5 are mirrors with the reflectance Ks.
  void finish() {
    if (out_.empty() || (illumination_ != 3 && illumination_ != 5)) return;
    out_.back().material.mirror = (specular_.x + specular_.y + specular_.z) / 3;
  }

  Lines lines_;
  const std::string& file_;
  std::vector<Diagnostic>& warnings_;
  std::vector<MtlMaterial> out_;
  std::int64_t illumination_ = 0;
  Vec3f specular_;
  std::size_t given_ = 0;
};

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
    tell_odd_values();
    finish_colours();
    out_.mesh = mesh_.finish();
    return std::move(out_);
  }

 private:
  void tell_odd_values() {
    // Faults are thrown already, so that no face uses these.
    for (const std::uint32_t p : not_finite_) mesh_.mesh.positions[p] = {};
    const auto tell = [&](const OddValues& odd, const char* code, const char* what) {
      warn(out_, source_.name, odd, code, what);
    };
    tell(odd_.positions, "not-finite", "positions are not finite numbers; no face uses them");
    tell(odd_.normals, "not-finite",
         "normals are not finite numbers: those of the faces are taken");
    tell(odd_.texture_points, "not-finite", "texture points are not finite numbers: taken as 0");
    tell(odd_.colours, "not-finite", "colours are not finite numbers: taken as white");
    tell(odd_.normal_indices, "bad-index",
         "corners name a normal that is missing: that of the face is taken");
    tell(odd_.texture_indices, "bad-index",
         "corners name a texture point that is missing: taken as 0");
  }
  /// Many programs write a colour after the position, which the format does not specify: sRGB as
  /// shares of one, or as bytes.
  void finish_colours() {
    if (!mesh_.coloured) return;
    note_colour_bytes(out_, source_.name, largest_colour_);
    const float one = colour_divisor(largest_colour_);
    const auto linear = [&](float c) {
      return image::linear_from_srgb(std::clamp(c / one, 0.0F, 1.0F));
    };
    for (Vec3f& c : mesh_.mesh.colours) {
      c = is_finite(c) ? Vec3f{linear(c.x), linear(c.y), linear(c.z)} : Vec3f{1, 1, 1};
    }
  }

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
      material_ = material_named(std::string(trimmed(rest)));
    } else if (key == "mtllib") {
      read_library(trimmed(rest));
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

  /// Reads up to 8 numbers, NaN for each word that is no finite one, and gives how many there are.
  static std::size_t numbers(std::string_view rest, std::array<float, 8>& out) {
    std::size_t n = 0;
    for (std::string_view word = cut_word(rest); !word.empty() && word[0] != '#' && n < out.size();
         word = cut_word(rest)) {
      out[n++] = to_float_or_nan(to_any_number(word).value_or(kNotANumber));
    }
    return n;
  }
  void read_position(std::string_view rest) {
    std::array<float, 8> v{};
    const std::size_t n = numbers(rest, v);
    if (n < 3 || !is_finite({v[0], v[1], v[2]})) {
      keep_odd_position(rest, n);
      v[0] = kNotANumber;
    }
    mesh_.mesh.positions.push_back({v[0], v[1], v[2]});
    Vec3f colour{kNotANumber, 0, 0};  // none
    if (n >= 6) {
      mesh_.coloured = true;
      colour = {v[3], v[4], v[5]};
      if (is_finite(colour)) {
        largest_colour_ = std::max({largest_colour_, v[3], v[4], v[5]});
      } else {
        odd_.colours.add([&] { return lines_.where(); });
      }
    }
    mesh_.mesh.colours.push_back(colour);
  }
  void keep_odd_position(std::string_view rest, std::size_t n) {
    const auto place = static_cast<std::uint32_t>(mesh_.mesh.positions.size());
    odd_.positions.add([&] { return lines_.where(); });
    not_finite_.push_back(place);
    constexpr std::size_t kMost = 100;  // no more faults are told
    if (told_positions_.size() >= kMost) return;
    std::string message = fmt::format("{} numbers, not 3", n);
    for (std::size_t k = 0; k < std::min<std::size_t>(n, 3); ++k) {
      const std::string_view word = cut_word(rest);
      if (!std::isnan(to_float_or_nan(to_number(word).value_or(kNotANumber)))) continue;
      message = quote(word) + ", not a finite number";
      break;
    }
    told_positions_.emplace(place, std::pair(lines_.where(), std::move(message)));
  }
  /// Whether the corner's position is finite; else a fault, once for each position.
  bool check_position(std::uint32_t place) {
    if (is_finite(mesh_.mesh.positions[place])) return true;
    if (!refused_.insert(place).second) return false;
    const auto told = told_positions_.find(place);
    if (told == told_positions_.end()) {
      faults_.error(lines_.where(), "bad-value",
                    fmt::format("position {}, which is not a finite number", place + 1));
    } else {
      faults_.error(
          told->second.first, "bad-value",
          fmt::format("{}, and the face of {} uses it", told->second.second, lines_.where()));
    }
    return false;
  }
  void read_texture_point(std::string_view rest) {
    std::array<float, 8> v{};
    const std::size_t n = numbers(rest, v);
    if (n == 0 || std::isnan(v[0]) || std::isnan(v[1])) {
      odd_.texture_points.add([&] { return lines_.where(); });
    }
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
      if (std::isnan(v[k])) v[k] = 0;
    }
    mesh_.texture_points.push_back({v[0], 1 - v[1]});  // v goes up in OBJ
  }
  void read_normal(std::string_view rest) {
    std::array<float, 8> v{};
    Vec3f normal;
    if (numbers(rest, v) >= 3 && is_finite({v[0], v[1], v[2]})) {
      normal = {v[0], v[1], v[2]};
    } else {
      odd_.normals.add([&] { return lines_.where(); });
    }
    mesh_.normals.push_back(normal);  // of length 0: the face's
  }

  /// Counts from 1, or backwards from the last one before this line. Nothing if it is missing.
  static std::optional<std::uint32_t> read_index(std::string_view word, std::size_t size) {
    const auto value = to_integer(word);
    const auto n = static_cast<std::int64_t>(size);
    if (value && *value > 0 && *value <= n) return static_cast<std::uint32_t>(*value - 1);
    if (value && *value < 0 && *value >= -n) return static_cast<std::uint32_t>(n + *value);
    return std::nullopt;
  }
  /// kNone, and a count, if it names none that is there.
  std::uint32_t optional_index(std::string_view word, std::size_t size, OddValues& missing) {
    if (word.empty()) return kNone;
    const auto found = read_index(word, size);
    if (!found) missing.add([&] { return lines_.where(); });
    return found.value_or(kNone);
  }
  /// "1", "1/2", "1//3" or "1/2/3".
  bool read_corner(std::string_view word, CornerIndices& out) {
    std::array<std::string_view, 3> part;
    for (std::string_view& p : part) {
      const std::size_t end = std::min(word.find('/'), word.size());
      p = word.substr(0, end);
      word.remove_prefix(std::min(end + 1, word.size()));
    }
    const std::size_t positions = mesh_.mesh.positions.size();
    const auto position = read_index(part[0], positions);
    if (!position) {
      faults_.error(
          lines_.where(), "bad-index",
          fmt::format("position {}, not one of the {} before it", quote(part[0]), positions));
      return false;
    }
    out.position = *position;
    out.texture_point = optional_index(part[1], mesh_.texture_points.size(), odd_.texture_indices);
    out.normal = optional_index(part[2], mesh_.normals.size(), odd_.normal_indices);
    return true;
  }
  void read_face(std::string_view rest) {
    corners_.clear();
    for (std::string_view word = cut_word(rest); !word.empty() && word[0] != '#';
         word = cut_word(rest)) {
      CornerIndices corner;
      if (!read_corner(word, corner)) return;
      corners_.push_back(corner);
    }
    if (corners_.size() < 3) {
      ++left_out_["f (fewer than 3 corners)"];
      return;
    }
    for (const CornerIndices& corner : corners_) {
      if (!check_position(corner.position)) return;
    }
    if (!material_) material_ = material_named("");
    if (!object_) object_ = object_named();
    for (std::size_t k = 2; k < corners_.size(); ++k) {
      mesh_.add({corners_[0], corners_[k - 1], corners_[k]}, *material_, *object_);
    }
  }

  void start_object(std::string_view rest) {
    name_ = trimmed(rest);
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
           fmt::format("material {} is in no .mtl", quote(mesh_.mesh.materials[m].name)));
    }
  }
  /// One name with blanks, or several names: the format leaves it open.
  void read_library(std::string_view names) {
    try {
      const Source::Part part = source_.find(names);
      read_library_file(part.path, plain_text(read_part(part.path)));
      note_moved(out_, source_.name, lines_.where(), names, part);
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
  void read_library_file(const std::filesystem::path& path, const std::string& text) {
    const std::string file = path.string();
    if (!libraries_.insert(file).second) return;
    for (MtlMaterial& m : MtlParser(text, file, out_.warnings).parse()) {
      const std::uint32_t place = material_named(m.material.name);
      known_[place] = true;
      if (!m.colour_map.empty()) read_texture(m, path);
      mesh_.mesh.materials[place] = std::move(m.material);
    }
  }
  void read_texture(MtlMaterial& m, const std::filesystem::path& library) {
    Material& material = m.material;
    const std::string file = library.string();
    try {
      // Names are relative to the .mtl's folder, which is nearly always the .obj's.
      const Source::Part part = source_.find(m.colour_map, library.parent_path());
      material.texture_file = part.path.string();
      material.texture = textures_.decode(read_part(part.path), material.texture_file, out_);
      note_moved(out_, file, material.name, m.colour_map, part);
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
  std::vector<CornerIndices> corners_;
  struct {
    OddValues positions, normals, texture_points, colours, normal_indices, texture_indices;
  } odd_;
  std::vector<std::uint32_t> not_finite_;  ///< positions
  /// Line and fault of the first of them.
  std::map<std::uint32_t, std::pair<std::string, std::string>> told_positions_;
  std::set<std::uint32_t> refused_;  ///< positions whose fault is told
  float largest_colour_ = 0;
};

}  // namespace

ReadResult read_obj(const Source& source) { return ObjReader(source).read(); }

}  // namespace enfilade::mesh::readers
