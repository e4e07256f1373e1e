#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "enfilade/continuous/navigation_mesh.h"
#include "enfilade/core/file.h"

namespace enfilade::continuous {

using mesh::FloorPolygon;
using mesh::FloorPolygons;
using mesh::PolygonHeights;

namespace {

constexpr std::string_view kTitle = "Enfilade navigation mesh, version 1\n";
constexpr std::string_view kTitleOfAny = "Enfilade navigation mesh, version ";

// In a triangle's flags, two bits a side: it is one of the polygon's.
constexpr unsigned kAnySideOfPolygon = 0b01'01'01;

// What lists of numbers the file has, in order, after the box.
template <class Floor, class Visit>
void each_list(Floor& floor, const Visit& visit) {
  visit("corners", floor.corners);
  visit("polygons", floor.polygons);
  visit("heights", floor.heights);
  visit("points", floor.points);
  visit("triangles", floor.triangles);
}

class Writer {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T> ||
                  std::is_same_v<T, Vec3f>);
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);  // NOLINT: bytes of a number
  }
  template <class T>
  void put_list(const std::vector<T>& list) {
    put(static_cast<std::uint64_t>(list.size()));
    for (const T& value : list) put(value);
  }
  std::string finish() {
    put(static_cast<std::uint64_t>(XXH3_64bits(text_.data(), text_.size())));
    return std::move(text_);
  }

 private:
  std::string text_{kTitle};
};

class Reader {
 public:
  Reader(std::span<const std::uint8_t> bytes, const std::string& name)
      : bytes_(bytes), name_(name) {}

  template <class T>
  void get(T& value, const char* what) {
    if (bytes_.size() - at_ < sizeof value) truncated(what);
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
  }
  template <class T>
  void get_list(std::vector<T>& list, const char* what) {
    std::uint64_t count = 0;
    get(count, what);
    if (count > (bytes_.size() - at_) / sizeof(T)) truncated(what);
    list.resize(count);
    if (count > 0) std::memcpy(list.data(), bytes_.data() + at_, count * sizeof(T));
    at_ += count * sizeof(T);
  }
  void skip(std::size_t count) { at_ += count; }
  void finish() {
    if (at_ != bytes_.size()) {
      refuse(name_, fmt::format("byte {}", at_), "damaged",
             fmt::format("{} bytes follow the last list", bytes_.size() - at_));
    }
  }

 private:
  [[noreturn]] void truncated(const char* what) const {
    refuse(name_, fmt::format("byte {}", at_), "truncated",
           fmt::format("the file ends in its {}", what));
  }

  std::span<const std::uint8_t> bytes_;
  const std::string& name_;
  std::size_t at_ = 0;
};

void check_title(std::span<const std::uint8_t> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()),  // NOLINT: as text
                              std::min<std::size_t>(bytes.size(), 64));
  if (text.starts_with(kTitle)) return;
  if (text.starts_with(kTitleOfAny)) {
    refuse(name, "", "other-version",
           "a navigation mesh of another version; make it again with `enfilade continuous`");
  }
  refuse(name, "", "not-a-navigation-mesh",
         fmt::format("does not begin with \"{}\"", kTitle.substr(0, kTitle.size() - 1)));
}

// Everything but the checksum, which is then right. \pre at least that many bytes
std::span<const std::uint8_t> check_sum(std::span<const std::uint8_t> bytes,
                                        const std::string& name) {
  std::uint64_t sum = 0;
  if (bytes.size() < kTitle.size() + sizeof sum) {
    refuse(name, "", "truncated", fmt::format("only {} bytes", bytes.size()));
  }
  const auto body = bytes.first(bytes.size() - sizeof sum);
  std::memcpy(&sum, bytes.data() + body.size(), sizeof sum);
  if (sum != XXH3_64bits(body.data(), body.size())) {
    refuse(name, "", "damaged", "the checksum at its end is not that of its content");
  }
  return body;
}

// Looks for what Detour would take on trust.
class PolygonChecker {
 public:
  PolygonChecker(const FloorPolygons& floor, const std::string& file)
      : floor_(floor), file_(file) {}

  std::vector<Diagnostic> run() {
    check_frame();
    if (floor_.polygons.empty()) fault("$.polygons", "no-floor", "has no polygon");
    if (floor_.corners.size() > 0xfffe || floor_.polygons.size() > 0xfffe) {
      fault("$", "too-large",
            fmt::format("{} corners and {} polygons, at most 65,534 of each", floor_.corners.size(),
                        floor_.polygons.size()));
    }
    if (floor_.heights.size() != floor_.polygons.size()) {
      fault(
          "$.heights", "list-length",
          fmt::format("{} entries for {} polygons", floor_.heights.size(), floor_.polygons.size()));
    }
    if (!found_.empty()) return found_;
    for (std::size_t p = 0; p < floor_.polygons.size() && found_.size() < kMostFaultsKept; ++p) {
      if (check_corners(p)) {
        check_sides(p);
        check_heights(p);
      }
    }
    check_parts();
    for (std::size_t i = 0; i < floor_.points.size() && found_.size() < kMostFaultsKept; ++i) {
      const Vec3f v = floor_.points[i];
      if (!is_place(v)) {
        fault(fmt::format("$.points[{}]", i), "bad-number",
              "has a coordinate that is not finite, or beyond 1e6 m");
      }
    }
    return found_;
  }

 private:
  void fault(std::string where, std::string code, std::string message) {
    found_.push_back(
        {Severity::kError, file_, std::move(where), std::move(code), std::move(message)});
  }

  static bool is_place(Vec3f v) {
    return std::abs(v.x) < 1e6F && std::abs(v.y) < 1e6F && std::abs(v.z) < 1e6F;
  }

  void check_frame() {
    const auto positive = [this](const char* name, double value) {
      if (!(value > 0 && value < 1e6)) {
        fault(fmt::format("$.{}", name), "bad-number", fmt::format("{}, not from 0 to 1e6", value));
      }
    };
    positive("cell", floor_.cell);
    positive("level", floor_.level);
    positive("body.height", floor_.body.height);
    for (const double value : {floor_.body.radius, floor_.body.step, floor_.body.slope}) {
      if (!(value >= 0 && value < 1e6)) {
        fault("$.body", "bad-number", fmt::format("{}, not from 0 to 1e6", value));
      }
    }
    for (const Vec3f v : {floor_.low, floor_.high}) {
      if (!is_place(v)) {
        fault("$.box", "bad-number", "has a coordinate that is not finite, or beyond 1e6 m");
      }
    }
  }

  Vec3d flat(std::uint16_t corner) const {
    const mesh::PolygonCorner& c = floor_.corners[corner];
    return {static_cast<double>(c[0]), static_cast<double>(c[1]), 0};
  }

  bool check_corners(std::size_t p) {
    const FloorPolygon& polygon = floor_.polygons[p];
    const std::string where = fmt::format("$.polygons[{}]", p);
    const std::size_t n = polygon.size();
    if (n < 3) {
      fault(where, "bad-polygon", fmt::format("has {} corners, at least 3", n));
      return false;
    }
    for (std::size_t k = 0; k < n; ++k) {
      if (polygon.corners[k] >= floor_.corners.size()) {
        fault(where, "bad-index",
              fmt::format("corner {}, of {}", polygon.corners[k], floor_.corners.size()));
        return false;
      }
    }
    double twice = 0;
    for (std::size_t k = 2; k < n; ++k) {
      const Vec3d a = flat(polygon.corners[0]);
      twice += cross(flat(polygon.corners[k - 1]) - a, flat(polygon.corners[k]) - a).z;
    }
    if (!is_convex(polygon, n, twice < 0 ? -1 : 1)) {
      fault(where, "bad-polygon", "is not convex, or has a side of no length");
      return false;
    }
    const int sign = (twice > 0) - (twice < 0);
    if (sign_ == 0) sign_ = sign;
    if (sign == 0 || sign != sign_) {
      fault(where, "bad-polygon",
            sign == 0 ? "has no area" : "turns the other way than the first one");
      return false;
    }
    return true;
  }

  // Exact: corners are whole numbers.
  bool is_convex(const FloorPolygon& polygon, std::size_t n, int sign) const {
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3d a = flat(polygon.corners[k]), side = flat(polygon.corners[(k + 1) % n]) - a;
      if (side == Vec3d{}) return false;
      for (std::size_t c = 0; c < n; ++c) {
        if (sign * cross(side, flat(polygon.corners[c]) - a).z < 0) return false;
      }
    }
    return true;
  }

  void check_sides(std::size_t p) {
    const FloorPolygon& polygon = floor_.polygons[p];
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const std::uint16_t beyond = polygon.beyond[k];
      if (beyond == FloorPolygon::kNone) continue;
      const std::string where = fmt::format("$.polygons[{}].beyond[{}]", p, k);
      if (beyond >= floor_.polygons.size()) {
        fault(where, "bad-index", fmt::format("{}, of {}", beyond, floor_.polygons.size()));
        continue;
      }
      const std::uint16_t a = polygon.corners[k], b = polygon.corners[(k + 1) % polygon.size()];
      if (!has_side(floor_.polygons[beyond], b, a, p)) {
        fault(where, "bad-neighbour",
              fmt::format("polygon {} does not have the same side", beyond));
      }
      if (floor_.polygons[beyond].area != polygon.area) {
        fault(where, "bad-neighbour", fmt::format("polygon {} is of another area", beyond));
      }
    }
  }

  static bool has_side(const FloorPolygon& polygon, std::uint16_t from, std::uint16_t to,
                       std::size_t beyond) {
    const std::size_t n = polygon.size();
    for (std::size_t k = 0; k < n; ++k) {
      if (polygon.corners[k] == from && polygon.corners[(k + 1) % n] == to &&
          polygon.beyond[k] == beyond) {
        return true;
      }
    }
    return false;
  }

  void check_heights(std::size_t p) {
    const PolygonHeights& h = floor_.heights[p];
    const std::string where = fmt::format("$.heights[{}]", p);
    const std::uint64_t points = std::uint64_t{h.first_point} + h.points;
    const std::uint64_t triangles = std::uint64_t{h.first_triangle} + h.triangles;
    if (points > floor_.points.size() || triangles > floor_.triangles.size()) {
      fault(where, "bad-index", "is beyond the lists of points or triangles");
      return;
    }
    if (h.points < floor_.polygons[p].size() || h.points > 255 || h.triangles > 255) {
      fault(where, "bad-heights",
            fmt::format("{} points and {} triangles for {} corners", h.points, h.triangles,
                        floor_.polygons[p].size()));
      return;
    }
    bool has_rim = false;  // Detour looks for the nearest point on such a side
    for (std::uint32_t t = 0; t < h.triangles; ++t) {
      const auto& triangle = floor_.triangles[h.first_triangle + t];
      has_rim = has_rim || (triangle[3] & kAnySideOfPolygon) != 0;
      if (std::max({triangle[0], triangle[1], triangle[2]}) >= h.points) {
        fault(where, "bad-index", fmt::format("triangle {} has an invalid point", t));
      }
    }
    if (!has_rim) fault(where, "bad-heights", "no triangle has a side of the polygon");
  }

  // Areas are numbered without gaps.
  void check_parts() {
    std::vector<bool> there;
    for (const FloorPolygon& p : floor_.polygons) {
      if (p.area >= floor_.polygons.size()) {
        fault("$.polygons", "bad-index", fmt::format("area {}", p.area));
        return;
      }
      if (p.area >= there.size()) there.resize(std::size_t{p.area} + 1);
      there[p.area] = true;
    }
    if (std::ranges::find(there, false) != there.end()) {
      fault("$.polygons", "bad-index", "an area has no polygon");
    }
  }

  const FloorPolygons& floor_;
  const std::string& file_;
  int sign_ = 0;
  std::vector<Diagnostic> found_;
};

}  // namespace

std::vector<Diagnostic> check_polygons(const FloorPolygons& floor, const std::string& file) {
  return PolygonChecker(floor, file).run();
}

void save_navigation_mesh(const FloorPolygons& floor, const std::filesystem::path& file) {
  Writer writer;
  const auto& [radius, height, step, slope] = floor.body;
  for (const double value : {radius, height, step, slope, floor.cell, floor.level}) {
    writer.put(value);
  }
  writer.put(floor.low);
  writer.put(floor.high);
  each_list(floor, [&](const char*, const auto& list) { writer.put_list(list); });
  write_file_atomically(file, writer.finish());
}

FloorPolygons parse_navigation_mesh(std::span<const std::uint8_t> bytes, const std::string& name) {
  check_title(bytes, name);
  Reader reader(check_sum(bytes, name), name);
  reader.skip(kTitle.size());
  FloorPolygons floor;
  auto& [radius, height, step, slope] = floor.body;
  for (double* value : {&radius, &height, &step, &slope}) reader.get(*value, "body");
  for (double* value : {&floor.cell, &floor.level}) reader.get(*value, "lattice");
  for (Vec3f* value : {&floor.low, &floor.high}) reader.get(*value, "box");
  each_list(floor, [&](const char* what, auto& list) { reader.get_list(list, what); });
  reader.finish();
  std::vector<Diagnostic> faults = check_polygons(floor, name);
  if (count(faults, Severity::kError) > 0) throw InvalidInput(std::move(faults));
  return floor;
}

FloorPolygons load_navigation_mesh(const std::filesystem::path& file) {
  const std::string content = read_file(file);
  return parse_navigation_mesh(
      {reinterpret_cast<const std::uint8_t*>(content.data()), content.size()},  // NOLINT: bytes
      file.string());
}

}  // namespace enfilade::continuous
