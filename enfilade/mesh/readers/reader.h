/// \file  Shared by the readers of mesh formats: sources, textures, assembly of triangles; lines,
/// words and numbers of text, and lists of faults.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/mesh/read_mesh.h"

namespace enfilade::mesh::readers {

/// The bytes of a mesh file, and where its other parts lie.
struct Source {
  std::string_view bytes;
  std::string name;              ///< in messages
  std::filesystem::path folder;  ///< of its other parts
  bool on_disk = false;          ///< else there are no other parts

  /// Another file that this one names, by a path relative to `folder`.
  struct Part {
    std::filesystem::path path;
    bool as_named = true;  ///< else it lies elsewhere, or its name differs in the case of letters
  };
  /// The file of that name, in which `\` separates folders too. If it is missing: the name in
  /// another case of letters, then the last part of the name alone. Each is searched in `folder`,
  /// then in `other`. Without any, the path as named. \throws FileError if not on_disk
  Part find(std::string_view named, const std::filesystem::path& other = {}) const;

  /// The files of a folder by their names in small letters; the first in the order of names.
  using Names = std::map<std::string, std::filesystem::path>;
  mutable std::map<std::filesystem::path, Names> listed = {};  ///< folders that find() has searched
};
/// The bytes of a part. \throws FileError, also if it is not a plain file
std::string read_part(const std::filesystem::path& path);

/// In the file's own units and axes; materials' textures included, check() not called.
ReadResult read_ply(const Source& source);
ReadResult read_obj(const Source& source);
ReadResult read_gltf(const Source& source);

/// \param file its name in the message
void warn(ReadResult& result, const std::string& file, std::string where, std::string code,
          std::string message);
void note(ReadResult& result, const std::string& file, std::string where, std::string code,
          std::string message);
/// Notes that a part was found under another name than `named`, if that is so.
void note_moved(ReadResult& result, const std::string& file, const std::string& where,
                std::string_view named, const Source::Part& part);

/// Counts odd values of one kind. Files have none, or thousands.
struct OddValues {
  std::size_t count = 0;
  std::string first;  ///< where the first one is

  template <class Where>  ///< Where: gives the text, and is called for the first value only
  void add(const Where& where) {
    if (count++ == 0) first = where();
  }
};
/// Warns "COUNT WHAT" at the first of the values, if there are any.
void warn(ReadResult& result, const std::string& file, const OddValues& odd, std::string code,
          std::string_view what);

/// Decodes textures, within a limit of pixels for the whole file.
class TextureDecoder {
 public:
  /// JPEG, PNG, or WebP where libwebp is built in, as RGB or RGBA. \throws InvalidInput
  /// \param result takes the notes of the picture, once for each file
  image::Image8 decode(std::string_view bytes, const std::string& file, ReadResult& result);
  /// Counts a picture that is stored once more. \throws InvalidInput
  void take(std::uint32_t width, std::uint32_t height, const std::string& file);

 private:
  std::set<std::string> noted_;                         ///< files
  std::uint64_t pixels_left_ = std::uint64_t{1} << 29;  ///< 1.6 GB as RGB
};

/// Colours from here on are no shares of one.
inline constexpr float kLeastColourByte = 2;
/// What float colours are divided by: 255 if the largest of them is no share of one.
inline float colour_divisor(float largest) { return largest < kLeastColourByte ? 1.0F : 255.0F; }
/// Notes that colours are divided by 255, if that is so.
void note_colour_bytes(ReadResult& result, const std::string& file, float largest);

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Indices of one corner of a triangle; kNone: missing.
struct CornerIndices {
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
  void add(const std::array<CornerIndices, 3>& corners, std::uint32_t material,
           std::uint32_t object);
  Mesh finish();

 private:
  bool any_texture_point_ = false, any_normal_ = false, any_object_ = false;
};

/// Triangles of one material with the same corners, in any order, that are kept. Exporters write
/// two, for two sides. No tree of boxes parts those of a file that repeats a triangle, so that each
/// ray would meet all of them.
inline constexpr std::uint32_t kMostCopies = 64;
/// Drops those beyond kMostCopies, in linear time. \returns how many
std::size_t drop_copies(Mesh& mesh);

/// Iterates over the lines of a text; line ends are `\n` and `\r\n`, or `\r` if it is the only one.
class Lines {
 public:
  explicit Lines(std::string_view text)
      : rest_(text), end_(text.find('\n') == std::string_view::npos ? '\r' : '\n') {}
  /// The next line; nothing at the end.
  std::optional<std::string_view> next();
  std::size_t number() const noexcept { return number_; }  ///< of the line last given, from 1
  std::string where() const;                               ///< "line 7"
  std::string_view rest() const noexcept { return rest_; }

 private:
  std::string_view rest_;
  char end_;
  std::size_t number_ = 0;
};

/// Removes and returns the first word of `line`; empty at its end. White space: space, \t, \r, \v,
/// \f.
std::string_view cut_word(std::string_view& line);
std::vector<std::string_view> words(std::string_view line);
/// With small letters; ASCII alone.
std::string lower(std::string_view text);

/// The number that is the whole word; finite. "1e999" and "nan" are invalid.
std::optional<double> to_number(std::string_view word);
/// The same, and NaN for numbers that are not finite, as programs write them: "1e999", "nan",
/// "-nan(ind)", "1.#QNAN", "-1.#IND00", "inf". Nothing for other words.
std::optional<double> to_any_number(std::string_view word);
inline constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
/// As float; NaN if it is out of its range.
float to_float_or_nan(double value);
inline bool is_finite(Vec3f v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
std::optional<std::int64_t> to_integer(std::string_view word);

/// Faults of one file, at most 100: broken files have millions.
class FaultList {
 public:
  explicit FaultList(const std::string& file) : file_(file) {}
  /// \throws InvalidInput at the 100th
  void error(std::string where, std::string code, std::string message);
  /// \throws InvalidInput if there are any
  void throw_if_any();
  bool any() const noexcept { return !found_.empty(); }

 private:
  const std::string& file_;
  std::vector<Diagnostic> found_;
};

}  // namespace enfilade::mesh::readers
