#include "enfilade/continuous/habitat/habitat_floor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <utility>

#include "enfilade/continuous/habitat/body.h"
#include "enfilade/continuous/habitat/floor_query.h"
#include "enfilade/continuous/habitat/path_finder.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/geometry/habitat_frame.h"

namespace enfilade::continuous::habitat {
namespace {

constexpr std::size_t kMostIndices = 65534;  // of FloorPolygons
// A corner nearer than this, seen from above, is no direction: metres.
constexpr float kHere = 1e-4F;

bool is_here(Vec3f place, Vec3f here) {
  return std::hypot(place.x - here.x, place.y - here.y) <= kHere;
}

// Polygons for maps: corners on Recast's lattice, without the heights inside.
class Outlines {
 public:
  Outlines(const NavMesh& mesh, const FloorQuery& floor) : floor_(floor) {
    const NavMeshSettings& s = mesh.settings;
    out_.body = {.radius = s.agent_radius,
                 .height = s.agent_height,
                 .step = s.agent_max_climb,
                 .slope = s.agent_max_slope};
    out_.cell = s.cell_size;
    out_.level = s.cell_height;
    // Rows of cells are counted from low.z, which is south's end negated.
    const float rows = std::ceil((mesh.high.z - mesh.low.z) / s.cell_size);
    out_.low = {mesh.low.x, -(mesh.low.z + rows * s.cell_size), mesh.low.y};
    out_.high = {mesh.high.x, -mesh.low.z, mesh.high.y};
  }

  mesh::FloorPolygons made() {
    floor_.for_each([&](dtPolyRef ref, const PolygonPlace& place) {
      if (floor_.island_of(ref) >= 0) numbers_.emplace(ref, numbers_.size());
      add_corners(place.tile);
    });
    if (std::max(out_.corners.size(), numbers_.size()) > kMostIndices) {
      throw InvalidInput({{Severity::kError, "navigation mesh", "", "too-large",
                           fmt::format("{} corners and {} polygons, at most {} of each",
                                       out_.corners.size(), numbers_.size(), kMostIndices)}});
    }
    floor_.for_each([&](dtPolyRef ref, const PolygonPlace& place) {
      if (floor_.island_of(ref) >= 0) out_.polygons.push_back(polygon(ref, place));
    });
    out_.heights.resize(out_.polygons.size());
    return std::move(out_);
  }

 private:
  void add_corners(const dtMeshTile* tile) {
    if (!first_corner_.emplace(tile, out_.corners.size()).second) return;
    for (int k = 0; k < tile->header->vertCount; ++k) {
      const Vec3f p = from_habitat(point_of(tile->verts + std::ptrdiff_t{3} * k));
      const auto steps = [](float from, float to, double size) {
        return static_cast<std::uint16_t>(std::clamp(std::round((to - from) / size), 0.0, 65535.0));
      };
      out_.corners.push_back({steps(out_.low.x, p.x, out_.cell), steps(out_.low.y, p.y, out_.cell),
                              steps(out_.low.z, p.z, out_.level)});
    }
  }

  mesh::FloorPolygon polygon(dtPolyRef ref, const PolygonPlace& place) const {
    mesh::FloorPolygon out;
    out.corners.fill(mesh::FloorPolygon::kNone);
    out.beyond.fill(mesh::FloorPolygon::kNone);
    out.area = static_cast<std::uint32_t>(floor_.island_of(ref));
    for (std::size_t k = 0; k < place.size(); ++k) {
      out.corners[k] =
          static_cast<std::uint16_t>(first_corner_.at(place.tile) + place.polygon->verts[k]);
      if (const dtPolyRef next = floor_.beyond(ref, k); next != 0) {
        out.beyond[k] = static_cast<std::uint16_t>(numbers_.at(next));
      }
    }
    return out;
  }

  const FloorQuery& floor_;
  std::map<dtPolyRef, std::size_t> numbers_;
  std::map<const dtMeshTile*, std::size_t> first_corner_;
  mesh::FloorPolygons out_;
};

Vec3f asked_of(const FloorPoint& at) { return to_habitat(at.asked); }

}  // namespace

std::vector<std::array<Vec3f, 3>> world_triangles(const PathFinder& finder, int island) {
  const std::vector<Vec3f> corners = finder.vertices(island);
  std::vector<std::array<Vec3f, 3>> triangles;
  triangles.reserve(corners.size() / 3);
  for (std::size_t k = 0; k + 2 < corners.size(); k += 3) {
    triangles.push_back(
        {from_habitat(corners[k]), from_habitat(corners[k + 1]), from_habitat(corners[k + 2])});
  }
  return triangles;
}

NavMeshSettings settings_of(const mesh::Body& body) {
  NavMeshSettings settings;
  settings.agent_radius = static_cast<float>(body.radius);
  settings.agent_height = static_cast<float>(body.height);
  settings.agent_max_climb = static_cast<float>(body.step);
  settings.agent_max_slope = static_cast<float>(body.slope);
  return settings;
}

// A PathFinder is one thread's at a time: one for each of those that ask at once.
class HabitatFloor::Finders {
 public:
  explicit Finders(NavMesh mesh) : mesh_(std::move(mesh)) { free_.push_back(make()); }

  const NavMesh& mesh() const noexcept { return mesh_; }

  template <class Query>  ///< Query(PathFinder&)
  auto ask(const Query& query) const {
    struct Lease {
      const Finders& of;
      std::unique_ptr<PathFinder> finder;
      explicit Lease(const Finders& all) : of(all), finder(all.take()) {}
      Lease(const Lease&) = delete;
      Lease& operator=(const Lease&) = delete;
      ~Lease() { of.give(std::move(finder)); }
    } lease(*this);
    return query(*lease.finder);
  }

 private:
  std::unique_ptr<PathFinder> make() const {
    return std::make_unique<PathFinder>(mesh_, Navigation::kV033);
  }
  std::unique_ptr<PathFinder> take() const {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        auto taken = std::move(free_.back());
        free_.pop_back();
        return taken;
      }
      // Room for all, so that giving back never allocates.
      free_.reserve(++made_);
    }
    return make();
  }
  void give(std::unique_ptr<PathFinder> finder) const noexcept {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(finder));
  }

  NavMesh mesh_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<PathFinder>> free_;
  mutable std::size_t made_ = 1;
};

// The triangles of islands that points were drawn from.
struct HabitatFloor::Draws {
  std::mutex mutex;
  std::map<int, const TriangleDraw> of_island;
};

struct HabitatFloor::Goals final : DistanceField::Goals {
  std::shared_ptr<const Finders> finders;
  std::vector<Vec3f> goals;  // Habitat's frame

  std::optional<DistanceField::Way> way(const FloorPoint& from) const override {
    const Vec3f start = asked_of(from);
    const Path found = finders->ask([&](const PathFinder& finder) {
      GoalBounds nothing{.least = {}, .start = start};
      return finder.path(start, goals, nothing).path;
    });
    if (!found.found()) return std::nullopt;
    DistanceField::Way way{found.length, from_habitat(found.points.back())};
    for (const Vec3f point : found.points) {
      if (is_here(from_habitat(point), from.point)) continue;
      way.next = from_habitat(point);
      break;
    }
    return way;
  }
};

HabitatFloor::HabitatFloor(NavMesh mesh) : draws_(std::make_unique<Draws>()) {
  const FloorQuery floor(mesh);
  polygons_ = Outlines(mesh, floor).made();
  finders_ = std::make_shared<const Finders>(std::move(mesh));
  finders_->ask([&](const PathFinder& finder) {
    for (std::size_t k = 0; k < finder.islands(); ++k) areas_m2_.push_back(finder.island_area(k));
  });
}

HabitatFloor::~HabitatFloor() = default;

const NavMeshSettings& HabitatFloor::settings() const noexcept { return finders_->mesh().settings; }

const mesh::FloorPolygons& HabitatFloor::polygons() const noexcept { return polygons_; }

std::optional<FloorPoint> HabitatFloor::nearest(Vec3f point, Reach reach) const {
  if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) return {};
  const Vec3f found = from_habitat(
      finders_->ask([&](const PathFinder& finder) { return finder.snap(to_habitat(point)); }));
  if (std::isnan(found.x)) return {};
  const Vec3f off = found - point;
  if (std::hypot(off.x, off.y) > reach.aside || std::abs(off.z) > reach.above_below) return {};
  return FloorPoint{found, 0, point};
}

double HabitatFloor::area_m2(std::size_t area) const {
  EN_CHECK_LT(area, areas());
  return areas_m2_[area];
}

std::size_t HabitatFloor::area_of(const FloorPoint& at) const {
  const int island =
      finders_->ask([&](const PathFinder& finder) { return finder.island(asked_of(at)); });
  EN_CHECK(island >= 0);
  return static_cast<std::size_t>(island);
}

const TriangleDraw& HabitatFloor::draw_of(int island) const {
  const std::lock_guard lock(draws_->mutex);
  const auto known = draws_->of_island.find(island);
  if (known != draws_->of_island.end()) return known->second;
  auto triangles =
      finders_->ask([&](const PathFinder& finder) { return world_triangles(finder, island); });
  return draws_->of_island.try_emplace(island, std::move(triangles)).first->second;
}

FloorPoint HabitatFloor::random_point(Rng& rng, std::optional<std::uint32_t> area) const {
  EN_CHECK_LT(area.value_or(0), areas());
  const Vec3f point = draw_of(area ? static_cast<int>(*area) : kAnyIsland).draw(rng).value();
  return {point, 0, point};
}

Walked HabitatFloor::move(Walker& /*walker*/, const FloorPoint& from, Vec3d by, Walls walls) const {
  const Vec3f start = asked_of(from);
  Vec3f there = start + to_habitat(to_float(Vec3d{by.x, by.y, 0}));
  const bool at_wall = finders_->ask([&](const PathFinder& finder) {
    return filter_move(there, start,
                       {&finder, walls == Walls::kSlide ? Moves::kSlide : Moves::kStop});
  });
  const Vec3f point = from_habitat(there);
  return {.end = {point, 0, point}, .at_wall = at_wall};
}

double HabitatFloor::distance(const FloorPoint& a, const FloorPoint& b) const {
  return finders_->ask(
      [&](const PathFinder& finder) { return finder.path(asked_of(a), asked_of(b)).length; });
}

std::optional<std::vector<Vec3f>> HabitatFloor::path(const FloorPoint& a,
                                                     const FloorPoint& b) const {
  Path found = finders_->ask(
      [&](const PathFinder& finder) { return finder.path(asked_of(a), asked_of(b)); });
  if (!found.found()) return std::nullopt;
  for (Vec3f& point : found.points) point = from_habitat(point);
  return std::move(found.points);
}

DistanceField HabitatFloor::field(std::span<const FloorPoint> goals) const {
  if (goals.empty()) throw ArgumentError("goals: none, at least one");
  auto kept = std::make_shared<Goals>();
  kept->finders = finders_;
  for (const FloorPoint& goal : goals) kept->goals.push_back(asked_of(goal));
  return DistanceField(std::move(kept));
}

}  // namespace enfilade::continuous::habitat
