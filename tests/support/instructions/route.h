/// \file  For tests: a path through a home, followed in small steps: passed rooms and visible
/// objects.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/home.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::homes::instructions::testing {

struct Point {
  double x = 0, y = 0, z = 0;
};

/// From one heading (radians) to another, right positive.
double degrees_between(double from, double to);
/// How far a number is from an interval.
double outside(double v, double low, double high);

/// A change of room: from when one leaves a floor to when one stands on the other; in between one
/// is in the doorway.
struct Passage {
  double left = 0, when = 0;  ///< legs
  std::size_t from = 0, to = 0;
  std::optional<std::size_t> opening;
  bool slight = false;  ///< hardly over the threshold, and back
};

/// Points all over each object's surface.
class Surfaces {
 public:
  explicit Surfaces(const mesh::Mesh& mesh);
  std::span<const Vec3f> points(std::uint32_t object) const { return points_.at(object); }

 private:
  std::vector<std::vector<Vec3f>> points_;
};

/// Times are legs: 2.5 is half-way from the third viewpoint to the fourth.
class Route {
 public:
  Route(const Home& home, const mesh::RayTracer& tracer, const graph::NavGraph& graph,
        const Surfaces& surfaces, std::span<const ViewpointIndex> path, double heading);

  std::size_t legs() const { return eyes_.size() - 1; }
  double end() const { return static_cast<double>(legs()); }
  Point at(double when) const;
  unsigned storey(double z) const;
  /// The room at a point of the floor, or the nearest.
  std::size_t room(const Point& p) const;
  bool is_in(std::size_t room, const Point& p) const;
  void find_passages();
  double metres(double from, double to) const;
  double gap_to(const Opening& o, const Point& p) const;
  static bool leads(const Opening& o, std::size_t a, std::size_t b);
  std::optional<std::size_t> opening_at(const Point& p, std::size_t a, std::size_t b) const;
  /// The share of an object's surface, by points all over its triangles, that nothing hides. Its
  /// far side always hides itself.
  double share_in_view(std::size_t viewpoint, std::size_t thing) const;
  bool sees(std::size_t viewpoint, std::size_t thing) const;
  /// Well enough to recognise it as the meant object.
  bool sees_well(std::size_t viewpoint, std::size_t thing) const;
  static Point middle(const HomeThing& t);
  double bearing(std::size_t viewpoint, double facing, const HomeThing& t) const;
  double gap_to(const HomeThing& t, const Point& p) const;

 protected:
  const Home* home_;
  const mesh::RayTracer* tracer_;
  const Surfaces* surfaces_;
  double start_heading_;
  std::vector<Point> eyes_;
  std::vector<double> floors_, headings_, turns_;  ///< the last two of legs; degrees
  std::vector<Passage> passages_;
};

}  // namespace enfilade::homes::instructions::testing
