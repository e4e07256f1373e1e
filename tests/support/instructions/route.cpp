#include "tests/support/instructions/route.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace enfilade::homes::instructions::testing {

double degrees_between(double from, double to) {
  double d = std::fmod(to - from, 2 * std::numbers::pi);
  if (d > std::numbers::pi) d -= 2 * std::numbers::pi;
  if (d < -std::numbers::pi) d += 2 * std::numbers::pi;
  return d * 180 / std::numbers::pi;
}

double outside(double v, double low, double high) { return std::max({low - v, 0.0, v - high}); }

Surfaces::Surfaces(const mesh::Mesh& mesh) : points_(mesh.objects.size()) {
  std::vector<std::vector<std::size_t>> triangles(mesh.objects.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t object = mesh.triangle_object[t];
    if (object < triangles.size()) triangles[object].push_back(t);
  }
  constexpr std::size_t kMost = 500, kPoints = 400;  // triangles, evenly picked; points, about
  for (std::size_t object = 0; object < triangles.size(); ++object) {
    const std::vector<std::size_t>& all = triangles[object];
    const std::size_t n = std::min(kMost, all.size());
    for (std::size_t k = 0; k < n; ++k) {
      const auto& corners = mesh.triangles[all[k * all.size() / n]];
      const auto rows =
          static_cast<int>(std::ceil(std::sqrt(2.0 * kPoints / static_cast<double>(n))));
      for (int i = 0; i < rows; ++i) {
        for (int j = 0; i + j < rows; ++j) {
          const double u = (i + 1.0 / 3) / rows, v = (j + 1.0 / 3) / rows;
          const Vec3f a = mesh.positions[corners[0]], p = mesh.positions[corners[1]] - a,
                      q = mesh.positions[corners[2]] - a;
          const auto s = static_cast<float>(u), t = static_cast<float>(v);
          points_[object].push_back(a +
                                    Vec3f{s * p.x + t * q.x, s * p.y + t * q.y, s * p.z + t * q.z});
        }
      }
    }
  }
}

Route::Route(const Home& home, const mesh::RayTracer& tracer, const graph::NavGraph& graph,
             const Surfaces& surfaces, std::span<const ViewpointIndex> path, double heading)
    : home_(&home), tracer_(&tracer), surfaces_(&surfaces), start_heading_(heading) {
  for (const ViewpointIndex v : path) {
    const Vec3f p = graph.position(v);
    eyes_.push_back({p.x, p.y, p.z});
    floors_.push_back(static_cast<double>(p.z) - static_cast<double>(graph.height(v)));
  }
  double facing = heading;
  for (std::size_t i = 0; i < legs(); ++i) {
    const Point a = eyes_[i], b = eyes_[i + 1];
    const bool level = std::hypot(b.x - a.x, b.y - a.y) > 1e-3;
    headings_.push_back(level ? std::atan2(b.x - a.x, b.y - a.y) : facing);
    turns_.push_back(degrees_between(facing, headings_.back()));
    facing = headings_.back();
  }
  find_passages();
}

Point Route::at(double when) const {
  const auto i = std::min(static_cast<std::size_t>(when), legs() - 1);
  const double s = when - static_cast<double>(i);
  const Point a = eyes_[i], b = eyes_[i + 1];
  return {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y),
          floors_[i] + s * (floors_[i + 1] - floors_[i])};
}

unsigned Route::storey(double z) const {
  unsigned found = 0;
  for (unsigned s = 0; s < home_->plan.storeys.size(); ++s) {
    if (home_->plan.storeys[s].floor < z + 0.5) found = s;
  }
  return found;
}

std::size_t Route::room(const Point& p) const {
  std::size_t best = 0;
  double least = 1e9;
  for (std::size_t i = 0; i < home_->plan.rooms.size(); ++i) {
    const PlanRoom& r = home_->plan.rooms[i];
    if (r.storey != storey(p.z)) continue;
    const double d =
        std::hypot(outside(p.x, r.floor.x0, r.floor.x1), outside(p.y, r.floor.y0, r.floor.y1));
    if (d < least) {
      least = d;
      best = i;
    }
  }
  return best;
}

bool Route::is_in(std::size_t room, const Point& p) const {
  const PlanRoom& r = home_->plan.rooms[room];
  return r.storey == storey(p.z) && r.floor.contains(p.x, p.y);
}

void Route::find_passages() {
  constexpr int kSteps = 100;
  std::size_t before = room(at(0));
  double left = 0;  // when one was last seen there
  for (std::size_t k = 1; k <= legs() * kSteps; ++k) {
    const double when = static_cast<double>(k) / kSteps;
    const Point p = at(when);
    const std::size_t now = room(p);
    const bool last = k == legs() * kSteps;
    if (now == before && is_in(now, p)) left = when;
    if (now == before || !(last || is_in(now, p))) continue;
    passages_.push_back(
        {left, when, before, now, opening_at(at((left + when) / 2), before, now), false});
    before = now;
    left = when;
  }
  // Who only puts a foot over the threshold need not say so.
  for (std::size_t k = 0; k + 1 < passages_.size(); ++k) {
    Passage &p = passages_[k], &q = passages_[k + 1];
    if (p.from == q.to && metres(p.left, q.when) < 1) p.slight = q.slight = true;
  }
}

double Route::metres(double from, double to) const {
  double sum = 0;
  for (double when = from; when < to; when += 0.01) {
    const Point a = at(when), b = at(when + 0.01);
    sum += std::hypot(b.x - a.x, b.y - a.y);
  }
  return sum;
}

double Route::gap_to(const Opening& o, const Point& p) const {
  const double along = o.along_x ? p.x : p.y, across = o.along_x ? p.y : p.x;
  return std::hypot(outside(along, o.from, o.to), across - o.wall);
}

bool Route::leads(const Opening& o, std::size_t a, std::size_t b) {
  return o.room1 && ((o.room0 == a && *o.room1 == b) || (o.room0 == b && *o.room1 == a));
}

std::optional<std::size_t> Route::opening_at(const Point& p, std::size_t a, std::size_t b) const {
  for (std::size_t k = 0; k < home_->plan.openings.size(); ++k) {
    const Opening& o = home_->plan.openings[k];
    if (leads(o, a, b) && gap_to(o, p) < 0.4) return k;
  }
  return std::nullopt;
}

double Route::share_in_view(std::size_t viewpoint, std::size_t thing) const {
  const Point eye = eyes_[viewpoint];
  const Vec3f origin{static_cast<float>(eye.x), static_cast<float>(eye.y),
                     static_cast<float>(eye.z)};
  std::size_t all = 0, seen = 0;
  for (const Vec3f target : surfaces_->points(home_->things[thing].object)) {
    const mesh::Hit hit = tracer_->trace(mesh::Ray{origin, target - origin});
    ++all;
    if (hit && tracer_->mesh().triangle_object[hit.triangle] == home_->things[thing].object) ++seen;
  }
  return all == 0 ? 0 : static_cast<double>(seen) / static_cast<double>(all);
}

bool Route::sees(std::size_t viewpoint, std::size_t thing) const {
  return share_in_view(viewpoint, thing) > 0;
}

bool Route::sees_well(std::size_t viewpoint, std::size_t thing) const {
  const Point e = eyes_[viewpoint];
  return gap_to(home_->things[thing], e) < 7 && share_in_view(viewpoint, thing) > 0.15;
}

Point Route::middle(const HomeThing& t) {
  return {(t.low.x + t.high.x) / 2, (t.low.y + t.high.y) / 2, 0};
}

double Route::bearing(std::size_t viewpoint, double facing, const HomeThing& t) const {
  const Point m = middle(t), e = eyes_[viewpoint];
  return degrees_between(facing, std::atan2(m.x - e.x, m.y - e.y));
}

double Route::gap_to(const HomeThing& t, const Point& p) const {
  return std::hypot(outside(p.x, t.low.x, t.high.x), outside(p.y, t.low.y, t.high.y));
}

}  // namespace enfilade::homes::instructions::testing
