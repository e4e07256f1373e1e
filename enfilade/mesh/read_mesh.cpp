#include "enfilade/mesh/read_mesh.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/utf8.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh {

using namespace readers;
namespace {

struct Format {
  std::string_view ending;
  ReadResult (*read)(const Source&);
  UpAxis up;
};
constexpr std::array kFormats{
    Format{".glb", read_gltf, UpAxis::kY}, Format{".gltf", read_gltf, UpAxis::kY},
    Format{".obj", read_obj, UpAxis::kZ}, Format{".ply", read_ply, UpAxis::kZ}};

/// Byte-order marks, of UTF-8 and UTF-16.
constexpr std::array<std::string_view, 3> kMarks{kByteOrderMark, "\xFF\xFE", "\xFE\xFF"};

const Format& format_of(const std::string& name) {
  std::string ending = std::filesystem::path(name).extension().string();
  std::ranges::transform(ending, ending.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  const auto at = std::ranges::find(kFormats, ending, &Format::ending);
  if (at == kFormats.end()) {
    throw ArgumentError(
        fmt::format("{}: ending {}, not .glb, .gltf, .obj or .ply", name, quote(ending)));
  }
  return *at;
}

void check_options(const ReadOptions& options) {
  if (std::isfinite(options.scale) && options.scale > 0) return;
  throw ArgumentError(fmt::format("ReadOptions::scale {}, not above 0", options.scale));
}

/// To metres with z up.
void orient(Mesh& mesh, double scale, bool y_up) {
  const auto turned = [&](Vec3f v) { return y_up ? Vec3f{v.x, -v.z, v.y} : v; };
  for (Vec3f& p : mesh.positions) {
    const Vec3f v = turned(p);
    p = {static_cast<float>(v.x * scale), static_cast<float>(v.y * scale),
         static_cast<float>(v.z * scale)};
  }
  if (!y_up) return;
  for (auto& corners : mesh.normals) {
    for (Vec3f& n : corners) n = turned(n);
  }
}

ReadResult read(Source source, const ReadOptions& options) {
  check_options(options);
  const Format& format = format_of(source.name);
  std::string text;
  const auto has_mark = [&](std::string_view mark) { return source.bytes.starts_with(mark); };
  if (std::ranges::any_of(kMarks, has_mark)) {
    source.bytes = text = plain_text(std::string(source.bytes));
  }
  ReadResult out = format.read(source);
  const UpAxis up = options.up == UpAxis::kFormat ? format.up : options.up;
  orient(out.mesh, options.scale, up == UpAxis::kY);
  std::vector<Diagnostic> found = check(out.mesh, source.name);
  if (count(found, Severity::kError) > 0) throw InvalidInput(std::move(found));
  std::ranges::move(found, std::back_inserter(out.warnings));
  if (const std::size_t dropped = drop_copies(out.mesh); dropped > 0) {
    warn(
        out, source.name, "", "repeated-triangles",
        fmt::format("{} triangles dropped: more than {} have the same corners, material and object",
                    dropped, kMostCopies));
  }
  return out;
}

}  // namespace

ReadResult read_mesh(const std::filesystem::path& file, const ReadOptions& options) {
  check_options(options);
  format_of(file.string());  // before a large file is read in vain
  const std::string bytes = read_file(file);
  return read({bytes, file.string(), file.parent_path(), true}, options);
}

ReadResult parse_mesh(std::string_view bytes, const std::string& name, const ReadOptions& options) {
  return read({bytes, name, {}, false}, options);
}

}  // namespace enfilade::mesh
