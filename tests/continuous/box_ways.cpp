#include "tests/continuous/box_ways.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <queue>

namespace enfilade::tests {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr int kArc = 4;          // nodes of a quarter of a circle
constexpr double kTouch = 1e-6;  // metres: lines between nodes of one arc touch it

double apart(PlanPoint a, PlanPoint b) { return std::hypot(a.x - b.x, a.y - b.y); }

// Whether the part of p + t d within |.| <= half on one axis leaves anything of [t0, t1].
bool clip(double p, double d, double half, double& t0, double& t1) {
  if (std::abs(d) < 1e-15) return std::abs(p) <= half;
  const double a = (-half - p) / d, b = (half - p) / d;
  t0 = std::max(t0, std::min(a, b));
  t1 = std::min(t1, std::max(a, b));
  return t0 <= t1;
}

}  // namespace

BoxWays::BoxWays(const homes::Home& home, std::size_t storey, const mesh::Body& body)
    : radius_(body.radius) {
  const double floor = home.plan.storeys.at(storey).floor;
  for (const homes::Obstacle& o : home.obstacles) {
    if (o.z1 - floor <= body.step || o.z0 - floor >= body.height) continue;
    boxes_.push_back({o.x, o.y, o.half_x, o.half_y, std::cos(o.turned), std::sin(o.turned),
                      std::hypot(o.half_x, o.half_y) + radius_});
  }
  for (const Box& box : boxes_) add_arcs(box);
  lines_.resize(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    for (std::size_t j = i + 1; j < nodes_.size(); ++j) {
      if (!is_free(nodes_[i], nodes_[j])) continue;
      lines_[i].emplace_back(j, apart(nodes_[i], nodes_[j]));
      lines_[j].emplace_back(i, apart(nodes_[i], nodes_[j]));
    }
  }
}

// A little outside of the arc, so that lines between neighbours touch it.
void BoxWays::add_arcs(const Box& box) {
  constexpr double kQuarter = std::numbers::pi / 2;
  const double out = radius_ / std::cos(kQuarter / kArc / 2);
  for (int corner = 0; corner < 4; ++corner) {
    const double cx = corner == 0 || corner == 3 ? box.half_x : -box.half_x;
    const double cy = corner < 2 ? box.half_y : -box.half_y;
    for (int k = 0; k < kArc; ++k) {
      const double angle = corner * kQuarter + (k + 0.5) * kQuarter / kArc;
      const double x = cx + out * std::cos(angle), y = cy + out * std::sin(angle);
      const PlanPoint node{box.x + box.cos * x - box.sin * y, box.y + box.sin * x + box.cos * y};
      if (is_free(node)) nodes_.push_back(node);
    }
  }
}

double BoxWays::distance(const Box& box, PlanPoint a, PlanPoint b) {
  const auto local = [&](PlanPoint p) {
    const double x = p.x - box.x, y = p.y - box.y;
    return PlanPoint{box.cos * x + box.sin * y, -box.sin * x + box.cos * y};
  };
  const PlanPoint u = local(a), v = local(b);
  const double dx = v.x - u.x, dy = v.y - u.y;
  double t0 = 0, t1 = 1;
  if (clip(u.x, dx, box.half_x, t0, t1) && clip(u.y, dy, box.half_y, t0, t1)) return 0;
  const auto to_box = [&](PlanPoint p) {
    return std::hypot(std::max(0.0, std::abs(p.x) - box.half_x),
                      std::max(0.0, std::abs(p.y) - box.half_y));
  };
  double least = std::min(to_box(u), to_box(v));
  const double squared = dx * dx + dy * dy;
  for (const auto& [sx, sy] : {std::pair{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
    const double x = sx * box.half_x, y = sy * box.half_y;
    const double t =
        squared > 0 ? std::clamp(((x - u.x) * dx + (y - u.y) * dy) / squared, 0.0, 1.0) : 0;
    least = std::min(least, std::hypot(u.x + t * dx - x, u.y + t * dy - y));
  }
  return least;
}

bool BoxWays::is_free(PlanPoint a, PlanPoint b) const {
  const auto [west, east] = std::minmax(a.x, b.x);
  const auto [south, north] = std::minmax(a.y, b.y);
  for (const Box& box : boxes_) {
    if (box.x + box.reach < west || box.x - box.reach > east || box.y + box.reach < south ||
        box.y - box.reach > north) {
      continue;
    }
    if (distance(box, a, b) < radius_ - kTouch) return false;
  }
  return true;
}

double BoxWays::distance(PlanPoint from, PlanPoint to) const {
  if (is_free(from, to)) return apart(from, to);
  using Open = std::pair<double, std::size_t>;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  std::vector<double> metres(nodes_.size(), kFar), rest(nodes_.size(), kFar);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (is_free(from, nodes_[n])) open.emplace(metres[n] = apart(from, nodes_[n]), n);
    if (is_free(to, nodes_[n])) rest[n] = apart(to, nodes_[n]);
  }
  double best = kFar;
  while (!open.empty()) {
    const auto [here, n] = open.top();
    open.pop();
    if (here >= best) break;
    if (here > metres[n]) continue;
    best = std::min(best, here + rest[n]);
    for (const auto& [other, line] : lines_[n]) {
      if (here + line < metres[other]) open.emplace(metres[other] = here + line, other);
    }
  }
  return best;
}

}  // namespace enfilade::tests
