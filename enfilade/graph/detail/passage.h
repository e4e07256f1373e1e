/// \file  Whether a body can move straight from one viewpoint to another. Internal.
#pragma once
#include <vector>

#include "enfilade/graph/build.h"

namespace enfilade::graph::detail {

/// Asks one mesh many times. Any thread.
class Passage {
 public:
  /// \throws ArgumentError for options out of range
  Passage(const mesh::RayTracer& tracer, const mesh::WalkableFloor& floor,
          const EdgeOptions& options);

  /// The edge rule: near enough, visible, floor all the way, and room for the body.
  bool is_free(const PlacedViewpoint& a, const PlacedViewpoint& b) const;
  bool in_sight(const PlacedViewpoint& a, const PlacedViewpoint& b) const;

 private:
  std::vector<Vec3d> floor_profile(Vec3d a, Vec3d b) const;
  bool has_room(const std::vector<Vec3d>& way) const;

  const mesh::RayTracer& tracer_;
  const mesh::WalkableFloor& floor_;
  EdgeOptions options_;
};

}  // namespace enfilade::graph::detail
