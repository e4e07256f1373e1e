#include "enfilade/mesh/readers/reader.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/numbers.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/photo.h"
#include "enfilade/mesh/detail/vector.h"
#include "enfilade/mesh/readers/webp.h"

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

constexpr std::string_view kBlanks = " \t\r\v\f";

bool is_plain_file(const std::filesystem::path& path) {
  std::error_code code;
  return std::filesystem::is_regular_file(path, code);
}

Source::Names names_of(const std::filesystem::path& folder) {
  Source::Names out;
  std::error_code code;
  for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    const auto [at, fresh] = out.emplace(lower(entry->path().filename().string()), entry->path());
    if (!fresh && entry->path() < at->second) at->second = entry->path();
  }
  return out;
}

/// The file or folder below `folder` whose path differs in the case of letters at most; the first
/// in the order of names, or empty.
std::filesystem::path in_any_case(const Source& source, const std::filesystem::path& folder,
                                  const std::filesystem::path& relative) {
  std::filesystem::path at = folder.empty() ? "." : folder;
  for (const std::filesystem::path& name : relative) {
    if (name == ".") continue;
    std::error_code code;
    if (std::filesystem::exists(at / name, code)) {
      at /= name;
      continue;
    }
    const auto [listed, fresh] = source.listed.try_emplace(at);
    if (fresh) listed->second = names_of(at);
    const auto found = listed->second.find(lower(name.string()));
    if (found == listed->second.end()) return {};
    at = found->second;
  }
  return at;
}

/// Whether C's printf writes a word for numbers that are not finite; any case of letters.
bool names_no_finite_number(std::string_view word) {
  constexpr std::size_t kMost = 24;
  if (word.size() > kMost) return false;
  const std::string text = lower(word);
  std::string_view rest = text;
  if (rest.starts_with('-') || rest.starts_with('+')) rest.remove_prefix(1);
  if (rest == "inf" || rest == "infinity") return true;
  if (rest.starts_with("nan")) {  // "nan", "nan(ind)"
    return rest.size() == 3 || (rest[3] == '(' && rest.ends_with(')'));
  }
  // Microsoft's library: "1.#INF", "1.#QNAN0", "1.#IND00", "1.#J" (rounded).
  return rest.size() > 3 && rest.starts_with("1.#");
}

/// parse_number() takes no plus sign, which other programs write.
std::string_view without_plus(std::string_view word) {
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
  return plus ? word.substr(1) : word;
}

}  // namespace

Source::Part Source::find(std::string_view named, const std::filesystem::path& other) const {
  if (!on_disk) throw FileError(fmt::format("{}: {} is not inside it", name, quote(named)));
  std::string text(named);
  std::ranges::replace(text, '\\', '/');  // as programs for Windows write it
  const std::filesystem::path path(text);
  std::vector<std::filesystem::path> folders{folder};
  if (!other.empty() && other != folder) folders.push_back(other);
  for (const auto& in : folders) {
    if (is_plain_file(in / path)) return {in / path, true};
  }
  // A whole path of another machine ends in the name of a file that was copied with the mesh.
  for (const std::filesystem::path& wanted : {path.relative_path(), path.filename()}) {
    for (const auto& in : folders) {
      std::filesystem::path found = in_any_case(*this, in, wanted);
      if (!found.empty() && is_plain_file(found)) return {std::move(found), false};
    }
  }
  return {folder / path, true};
}

std::string read_part(const std::filesystem::path& path) {
  check_plain_file(path);  // an untrusted file names it
  return read_file(path);
}

void warn(ReadResult& result, const std::string& file, std::string where, std::string code,
          std::string message) {
  result.warnings.push_back(
      {Severity::kWarning, file, std::move(where), std::move(code), std::move(message)});
}

void note(ReadResult& result, const std::string& file, std::string where, std::string code,
          std::string message) {
  result.warnings.push_back(
      {Severity::kNote, file, std::move(where), std::move(code), std::move(message)});
}

void note_moved(ReadResult& result, const std::string& file, const std::string& where,
                std::string_view named, const Source::Part& part) {
  if (part.as_named) return;
  constexpr std::size_t kMost = 200;
  note(result, file, where, "moved-file",
       fmt::format("{} is read from {}", quote(named, kMost), part.path.string()));
}

void warn(ReadResult& result, const std::string& file, const OddValues& odd, std::string code,
          std::string_view what) {
  if (odd.count == 0) return;
  warn(result, file, odd.first, std::move(code), fmt::format("{} {}", odd.count, what));
}

image::Image8 TextureDecoder::decode(std::string_view bytes, const std::string& file,
                                     ReadResult& result) {
  const image::Bytes raw = image::bytes_of(bytes);
  const bool jpeg = bytes.starts_with("\xFF\xD8"), png = bytes.starts_with("\x89PNG");
  const bool webp = is_webp(bytes);
  if (!jpeg && !png && !webp) refuse(file, "", "unknown-picture", "neither a JPEG nor a PNG");
  const image::Shape shape = webp   ? webp_shape(bytes, file)
                             : jpeg ? image::jpeg_shape(raw, file)
                                    : image::png_shape(raw, file);
  take(shape.width, shape.height, file);
  constexpr std::uint64_t kMost = image::kMostPhotoPixels;
  image::Photo photo = webp ? image::upright_by_exif(decode_webp(bytes, file, kMost),
                                                     image::bytes_of(webp_exif(bytes)), shape, file)
                            : image::decode_photo(raw, file, kMost);
  const bool fresh = noted_.insert(file).second;
  for (Diagnostic& d : photo.findings) {
    if (fresh && d.code != "bad-sphere") result.warnings.push_back(std::move(d));
  }
  return as_colour(std::move(photo.picture));
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

void note_colour_bytes(ReadResult& result, const std::string& file, float largest) {
  if (largest < kLeastColourByte) return;
  note(result, file, "", "colour-bytes",
       fmt::format("colours of up to {}, taken as 0 to 255", largest));
}

void MeshCollector::add(const std::array<CornerIndices, 3>& corners, std::uint32_t material,
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

std::size_t drop_copies(Mesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  const std::size_t mask = std::bit_ceil(count + 1) - 1;
  const auto hash = [&](std::size_t t) {
    // The same place in any order of corners. A sum of zeros has no sign, and no number is NaN.
    std::array<std::array<float, 3>, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f p = mesh.positions[mesh.triangles[t][k]];
      corners[k] = {p.x + 0.0F, p.y + 0.0F, p.z + 0.0F};
    }
    std::ranges::sort(corners);
    std::uint64_t sum = mesh.triangle_material[t];
    for (const auto& corner : corners) {
      for (const float value : corner) {
        sum = (sum ^ std::bit_cast<std::uint32_t>(value)) * 0x9E3779B97F4A7C15U;
        sum ^= sum >> 32U;
      }
    }
    return sum;
  };
  // Nearly every mesh ends here, after a count in a byte a triangle.
  std::vector<std::uint8_t> alike(mask + 1);
  for (std::size_t t = 0; t < count; ++t) {
    std::uint8_t& n = alike[hash(t) & mask];
    if (n <= kMostCopies) ++n;
  }
  if (std::ranges::max(alike) <= kMostCopies) return 0;
  std::unordered_map<std::uint64_t, std::uint32_t> copies;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < count; ++t) {
    const std::uint64_t own = hash(t);
    if (alike[own & mask] > kMostCopies && ++copies[own] > kMostCopies) continue;
    const auto keep = [&](auto& list) {
      if (!list.empty()) list[kept] = list[t];
    };
    keep(mesh.triangles);
    keep(mesh.triangle_material);
    keep(mesh.triangle_object);
    keep(mesh.texture_points);
    keep(mesh.normals);
    ++kept;
  }
  const auto cut = [&](auto& list) { list.resize(std::min(list.size(), kept)); };
  cut(mesh.triangles);
  cut(mesh.triangle_material);
  cut(mesh.triangle_object);
  cut(mesh.texture_points);
  cut(mesh.normals);
  return count - kept;
}

std::optional<std::string_view> Lines::next() {
  if (rest_.empty()) return std::nullopt;
  ++number_;
  const std::size_t end = rest_.find(end_);
  std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string Lines::where() const { return fmt::format("line {}", number_); }

std::string_view cut_word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    line = {};
    return {};
  }
  line.remove_prefix(begin);
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> out;
  for (std::string_view word = cut_word(line); !word.empty(); word = cut_word(line)) {
    out.push_back(word);
  }
  return out;
}

std::optional<double> to_any_number(std::string_view word) {
  const std::string_view digits = without_plus(word);
  double value = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, code] = std::from_chars(digits.data(), end, value);
  if (stop == end && code == std::errc()) return std::isfinite(value) ? value : double{kNotANumber};
  if (stop == end && code == std::errc::result_out_of_range) {
    const bool tiny = digits.find("e-") != digits.npos || digits.find("E-") != digits.npos;
    return tiny ? 0 : double{kNotANumber};
  }
  return names_no_finite_number(word) ? std::optional<double>(kNotANumber) : std::nullopt;
}

std::optional<double> to_number(std::string_view word) {
  const auto value = to_any_number(word);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

float to_float_or_nan(double value) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return std::abs(value) <= kMost ? static_cast<float>(value) : kNotANumber;
}

std::optional<std::int64_t> to_integer(std::string_view word) {
  return parse_number<std::int64_t>(without_plus(word));
}

void FaultList::error(std::string where, std::string code, std::string message) {
  constexpr std::size_t kMost = 100;
  found_.push_back(
      {Severity::kError, file_, std::move(where), std::move(code), std::move(message)});
  if (found_.size() == kMost) throw_if_any();
}

void FaultList::throw_if_any() {
  if (any()) throw InvalidInput(std::move(found_));
}

}  // namespace enfilade::mesh::readers
