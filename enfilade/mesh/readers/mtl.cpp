#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "enfilade/mesh/readers/reader.h"
#include "enfilade/mesh/readers/text.h"

namespace enfilade::mesh::readers {
namespace {

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

class MtlParser {
 public:
  MtlParser(std::string_view text, const std::string& file, std::vector<Diagnostic>& warnings)
      : lines_(text), file_(file), warnings_(warnings) {}

  std::vector<MtlMaterial> parse() {
    while (const auto line = lines_.next()) {
      std::string_view rest = *line;
      const std::string_view key = cut_word(rest);
      if (key == "newmtl") {
        finish();
        out_.emplace_back();
        illumination_ = 0;
        specular_ = {};
        out_.back().material.name = trim(rest);
      } else if (!out_.empty()) {
        read(key, rest);
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

  void read(std::string_view key, std::string_view rest) {
    Material& material = out_.back().material;
    if (key == "Kd") {
      material.colour = colour(key, rest, 1).value_or(material.colour);
    } else if (key == "Ke") {
      material.emission = colour(key, rest, 1e6F).value_or(material.emission);
    } else if (key == "Ks") {
      specular_ = colour(key, rest, 1).value_or(Vec3f{});
    } else if (key == "illum") {
      illumination_ = to_integer(trim(rest)).value_or(0);
    } else if (key == "map_Kd") {
      out_.back().colour_map = map_file(rest);
    } else if (key == "map_d") {
      out_.back().alpha_map = map_file(rest);
    }
  }
  /// One number stands for all three, as the format says.
  std::optional<Vec3f> colour(std::string_view key, std::string_view rest, float most) {
    std::array<float, 3> value{};
    const auto found = words(rest);
    if (found.size() != 1 && found.size() != 3) {
      warn(fmt::format("{} of {} words, not of 1 or 3 numbers", key, found.size()));
      return std::nullopt;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string_view word = found[std::min(k, found.size() - 1)];
      const auto number = to_number(word);
      if (!number || *number < 0) {
        warn(fmt::format("{} {}, not 0 or more", key, in_quotes(word)));
        return std::nullopt;
      }
      if (*number > most) warn(fmt::format("{} {}, taken as {}", key, *number, most));
      value[k] = std::min(static_cast<float>(*number), most);
    }
    return Vec3f{value[0], value[1], value[2]};
  }
  std::string map_file(std::string_view rest) {
    for (rest = trim(rest); rest.starts_with('-'); rest = trim(rest)) {
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
    std::string name(rest);
    std::ranges::replace(name, '\\', '/');  // as programs for Windows write it
    return name;
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

}  // namespace

std::vector<MtlMaterial> parse_mtl(std::string_view text, const std::string& file,
                                   std::vector<Diagnostic>& warnings) {
  return MtlParser(text, file, warnings).parse();
}

}  // namespace enfilade::mesh::readers
