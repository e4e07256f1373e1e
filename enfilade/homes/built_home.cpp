#include "enfilade/homes/built_home.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/graph/build.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/sets/home_list.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::homes {
namespace {

mesh::Mesh inside_of(const mesh::Mesh& whole) {
  mesh::Mesh inside;
  inside.positions = whole.positions;
  inside.materials.resize(1);
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    const std::uint32_t object = whole.triangle_object[t];
    if (object == mesh::kNoObject || whole.objects[object].region < 0) continue;
    inside.triangles.push_back(whole.triangles[t]);
    inside.triangle_material.push_back(0);
  }
  return inside;
}

// Kind and ends (x, y, x, y) of a line, in millimetres.
using Line = std::array<long, 5>;

Line to_line(const draw::UnderlayLine& line) {
  const auto mm = [](float metres) { return std::lround(1000.0 * metres); };
  return {static_cast<long>(line.kind), mm(line.from.x), mm(line.from.y), mm(line.to.x),
          mm(line.to.y)};
}

draw::UnderlayLine from_line(const Line& line) {
  const auto end = [](long x, long y) {
    return to_float({static_cast<double>(x) / 1000, static_cast<double>(y) / 1000, 0});
  };
  return {static_cast<draw::UnderlayLine::Kind>(line[0]), end(line[1], line[2]),
          end(line[3], line[4])};
}

// Whether `b` begins where `a` ends and has its direction.
bool goes_on(const Line& a, const Line& b) {
  if (a[0] != b[0] || a[3] != b[1] || a[4] != b[2]) return false;
  const long ax = a[3] - a[1], ay = a[4] - a[2], bx = b[3] - b[1], by = b[4] - b[2];
  return ax * by == ay * bx && ax * bx + ay * by > 0;
}

// The same drawing in fewer lines: the two triangles of a face give two pieces of one line, and
// stairs are cut at many heights.
void simplify(std::vector<draw::UnderlayLine>& lines) {
  std::vector<Line> kept;
  for (const draw::UnderlayLine& line : lines) {
    const Line next = to_line(line);
    if (!kept.empty() && goes_on(kept.back(), next)) {
      std::copy(next.begin() + 3, next.end(), kept.back().begin() + 3);
    } else {
      kept.push_back(next);
    }
  }
  std::ranges::sort(kept);
  const auto repeated = std::ranges::unique(kept);
  kept.erase(repeated.begin(), repeated.end());
  lines.clear();
  std::ranges::transform(kept, std::back_inserter(lines), from_line);
}

double to_millimetre(double metres) { return std::round(1000 * metres) / 1000; }

Rect to_millimetre(const Rect& r) {
  return {to_millimetre(r.x0), to_millimetre(r.y0), to_millimetre(r.x1), to_millimetre(r.y1)};
}

constexpr double kAround = 1;  // metres beside the rooms: their walls, and thresholds

mesh::Box around_rooms(const Plan& plan) {
  constexpr double kFar = std::numeric_limits<double>::max();
  Rect rooms{kFar, kFar, -kFar, -kFar};
  for (const PlanRoom& room : plan.rooms) {
    rooms = {std::min(rooms.x0, room.floor.x0), std::min(rooms.y0, room.floor.y0),
             std::max(rooms.x1, room.floor.x1), std::max(rooms.y1, room.floor.y1)};
  }
  const PlanStorey& top = plan.storeys.back();
  return {to_float(Vec3d{rooms.x0 - kAround, rooms.y0 - kAround, plan.storeys.front().floor - 0.5}),
          to_float(Vec3d{rooms.x1 + kAround, rooms.y1 + kAround, top.floor + top.height})};
}

}  // namespace

BuiltHome build_home(const PlanOptions& options, HomeSurfaces surfaces) {
  BuiltHome built{make_home(options, surfaces), nullptr};
  built.tracer =
      std::make_shared<mesh::RayTracer>(std::make_shared<const mesh::Mesh>(built.home.mesh));
  return built;
}

scan::Connectivity build_graph(const BuiltHome& built, const std::string& scan, int threads) {
  const mesh::WalkableFloor floor(inside_of(built.home.mesh));
  auto viewpoints = graph::place_viewpoints(*built.tracer, floor);
  // Beds and tables are floor to a mesh, but out of reach.
  std::erase_if(viewpoints, [&](const graph::PlacedViewpoint& v) {
    const auto cell = floor.below(to_float(v.eye));
    return !cell || floor.cells()[*cell].area != 0;
  });
  return graph::connect_viewpoints(*built.tracer, floor, viewpoints, scan, {}, threads);
}

scan::Connectivity home_graph(const BuiltHome& built, const std::string& scan, int threads) {
  scan::Connectivity graph = build_graph(built, sets::draws_of(scan), threads);
  graph.scan = scan;
  graph.file = scan + "_connectivity.json";
  return graph;
}

std::vector<capture::ScanRoom> scan_rooms(const Plan& plan) {
  std::vector<capture::ScanRoom> rooms;
  for (const PlanRoom& room : plan.rooms) {
    rooms.push_back(
        {room.type, room.floor, plan.storeys[room.storey].floor, room.ceiling, room.storey});
  }
  return rooms;
}

mesh::FloorPolygons make_home_floor(const BuiltHome& built, const mesh::Body& body) {
  mesh::PolygonOptions options;
  options.floor.body = body;
  options.floor.within = around_rooms(built.home.plan);
  return mesh::make_floor_polygons(*built.tracer, options);
}

HomeEntry describe(const Home& home, const PlanOptions& plan,
                   const scan::Connectivity& connectivity) {
  const graph::NavGraph graph(connectivity);
  HomeEntry entry;
  entry.scan = connectivity.scan;
  entry.plan = plan;
  entry.kind = enum_name(home.plan.kind);
  entry.viewpoints = graph.included_count();
  entry.edges = graph.edge_count() / 2;
  entry.triangles = home.mesh.triangles.size();
  for (const PlanRoom& room : home.plan.rooms) {
    const double elevation = to_millimetre(home.plan.storeys[room.storey].floor);
    entry.rooms.push_back(
        {room.type, room.name, room.storey, to_millimetre(room.floor), elevation, {}});
  }
  for (const scan::ConnectivityEntry& viewpoint : connectivity.entries) {
    Vec3d foot = viewpoint.position();
    foot.z -= viewpoint.height;
    if (const auto room = room_at(home.plan, foot)) {
      entry.rooms[*room].viewpoints.push_back(viewpoint.id);
    }
  }
  entry.lines = draw::plan_underlay(home.mesh, graph);
  for (draw::UnderlayStorey& storey : entry.lines.storeys) simplify(storey.lines);
  return entry;
}

HomeEntry completed(HomeEntry home, const std::filesystem::path& folder) {
  if (!home.lines.storeys.empty()) return home;
  const auto graph = scan::load_connectivity(folder / "connectivity", home.scan);
  HomeEntry found = describe(make_home(home.plan, HomeSurfaces::kPlain), home.plan, graph);
  if (found.triangles != home.triangles) {
    throw FileError(fmt::format(
        "{}: {} has {} triangles, but this version of Enfilade makes it of {}, so its lines would "
        "not fit; use the version that made the folder, or make the homes anew in another",
        (folder / "homes.json").string(), home.scan, home.triangles, found.triangles));
  }
  found.corrections = std::move(home.corrections);
  return found;
}

}  // namespace enfilade::homes
