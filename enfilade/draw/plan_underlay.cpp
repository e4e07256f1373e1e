#include "enfilade/draw/plan_underlay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "enfilade/draw/floor_plan.h"
#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::draw {
namespace {

using Kind = UnderlayLine::Kind;

// Metres above the floor. Plans are cut at about 1.2 m; seats and beds are lower.
constexpr double kCut = 1.2, kLowCut = 0.45;
constexpr double kTread = 0.06;  // between cuts through stairs: less than a riser
constexpr float kAround = 3;     // metres around viewpoints that are drawn

using mesh::Mpcat40;

Kind kind_of(const mesh::Mesh& mesh, std::uint32_t object) {
  if (object == mesh::kNoObject) return Kind::kWall;
  switch (mesh.objects[object].category) {
    case Mpcat40::kVoid:
    case Mpcat40::kWall:
    case Mpcat40::kUnlabeled:
      return Kind::kWall;
    case Mpcat40::kDoor:
      return Kind::kDoor;
    case Mpcat40::kWindow:
      return Kind::kWindow;
    case Mpcat40::kStairs:
      return Kind::kStairs;
    default:
      return Kind::kThing;
  }
}

struct Bounds {
  float west = std::numeric_limits<float>::infinity(), south = west;
  float east = -west, north = -west;

  void add(Vec3f p) {
    west = std::min(west, p.x - kAround);
    east = std::max(east, p.x + kAround);
    south = std::min(south, p.y - kAround);
    north = std::max(north, p.y + kAround);
  }
  bool contains(Vec3f p) const {
    return p.x >= west && p.x <= east && p.y >= south && p.y <= north;
  }
};

// Adds the lines at one height of the objects that are wanted.
template <class Wanted>
void add_cut(const mesh::Mesh& mesh, double z, const Bounds& bounds, const Wanted& wanted,
             std::vector<UnderlayLine>& lines) {
  for (const mesh::SliceLine& line : mesh::slice(mesh, static_cast<float>(z))) {
    const std::optional<Kind> kind = wanted(line.object);
    if (!kind || !bounds.contains(line.from) || !bounds.contains(line.to)) continue;
    lines.push_back({*kind, line.from, line.to});
  }
}

// Surfaces without label count as furniture low above the floor, and as walls higher up.
std::optional<Kind> low_kind(const mesh::Mesh& mesh, std::uint32_t object) {
  if (object == mesh::kNoObject) return Kind::kThing;
  const std::uint16_t category = mesh.objects[object].category;
  if (category == Mpcat40::kVoid || category == Mpcat40::kUnlabeled) return Kind::kThing;
  const bool thing = kind_of(mesh, object) == Kind::kThing && category != Mpcat40::kCurtain;
  return thing ? std::optional(Kind::kThing) : std::nullopt;
}

std::optional<Kind> high_kind(const mesh::Mesh& mesh, std::uint32_t object) {
  const Kind kind = kind_of(mesh, object);
  return kind == Kind::kWall || kind == Kind::kDoor ? std::optional(kind) : std::nullopt;
}

// A window's frames, with or without glass between them, become one line along them.
UnderlayLine window_line(const std::vector<Vec3f>& cut) {
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  const auto n = static_cast<double>(cut.size());
  for (const Vec3f p : cut) x += p.x / n, y += p.y / n;
  for (const Vec3f p : cut) {
    xx += (p.x - x) * (p.x - x);
    xy += (p.x - x) * (p.y - y);
    yy += (p.y - y) * (p.y - y);
  }
  const double angle = std::atan2(2 * xy, xx - yy) / 2;  // of the direction of most variance
  const double along_x = std::cos(angle), along_y = std::sin(angle);
  double low = 0, high = 0;
  for (const Vec3f p : cut) {
    const double along = (p.x - x) * along_x + (p.y - y) * along_y;
    low = std::min(low, along);
    high = std::max(high, along);
  }
  const auto at = [&](double along) {
    return to_float({x + along * along_x, y + along * along_y, cut.front().z});
  };
  return {Kind::kWindow, at(low), at(high)};
}

// The windows that a height goes through.
void add_windows(const mesh::Mesh& mesh, double z, const Bounds& bounds,
                 std::vector<UnderlayLine>& lines) {
  std::map<std::uint32_t, std::vector<Vec3f>> cuts;
  for (const mesh::SliceLine& line : mesh::slice(mesh, static_cast<float>(z))) {
    if (kind_of(mesh, line.object) != Kind::kWindow) continue;
    if (!bounds.contains(line.from)) continue;
    for (const Vec3f end : {line.from, line.to}) cuts[line.object].push_back(end);
  }
  for (const auto& [object, cut] : cuts) lines.push_back(window_line(cut));
}

// The stairs alone, so that the many cuts through them are quick.
mesh::Mesh stairs_of(const mesh::Mesh& mesh) {
  mesh::Mesh stairs;
  stairs.positions = mesh.positions;
  stairs.objects = mesh.objects;
  for (std::size_t t = 0; t < mesh.triangle_object.size(); ++t) {
    if (kind_of(mesh, mesh.triangle_object[t]) != Kind::kStairs) continue;
    stairs.triangles.push_back(mesh.triangles[t]);
    stairs.triangle_object.push_back(mesh.triangle_object[t]);
  }
  return stairs;
}

}  // namespace

PlanUnderlay plan_underlay(const mesh::Mesh& mesh, const graph::NavGraph& graph) {
  const std::vector<GraphStorey> storeys = find_storeys(graph);
  const mesh::Mesh stairs = stairs_of(mesh);
  PlanUnderlay underlay;
  for (std::size_t s = 0; s < storeys.size(); ++s) {
    Bounds bounds;
    for (const ViewpointIndex v : storeys[s].viewpoints) bounds.add(graph.position(v));
    const double floor = storeys[s].floor;
    std::vector<UnderlayLine>& lines = underlay.storeys.emplace_back().lines;
    const auto low = [&](std::uint32_t object) { return low_kind(mesh, object); };
    const auto high = [&](std::uint32_t object) { return high_kind(mesh, object); };
    const auto step = [](std::uint32_t) { return std::optional(Kind::kStairs); };
    add_cut(mesh, floor + kLowCut, bounds, low, lines);
    const double top = s + 1 < storeys.size() ? storeys[s + 1].floor : floor;
    for (double z = floor + kTread / 2; z < top; z += kTread) {
      add_cut(stairs, z, bounds, step, lines);
    }
    add_cut(mesh, floor + kCut, bounds, high, lines);
    add_windows(mesh, floor + kCut, bounds, lines);
    std::ranges::stable_sort(lines, {}, &UnderlayLine::kind);
  }
  return underlay;
}

std::vector<double> line_ends(const std::vector<UnderlayLine>& lines, UnderlayLine::Kind kind,
                              double step) {
  const double steps = std::round(1 / step);  // in a metre
  std::vector<double> ends;
  for (const UnderlayLine& line : lines) {
    if (line.kind != kind) continue;
    for (const double metres : {line.from.x, line.from.y, line.to.x, line.to.y}) {
      ends.push_back(std::round(metres * steps) / steps);
    }
  }
  return ends;
}

}  // namespace enfilade::draw
