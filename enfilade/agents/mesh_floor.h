/// \file  The floor of continuous episodes, from navigation meshes.
#pragma once
#include <memory>
#include <optional>
#include <span>

#include "enfilade/continuous/buildings.h"
#include "enfilade/tasks/derive_continuous.h"

namespace enfilade::agents {

/// When a path from one node to the next counts as impossible for a body.
struct DetourLimit {
  /// The shortest path may be this many times the straight line ...
  double times = 2;
  double metres = 3;  ///< ... and this much longer: the edge leads over an obstacle
};

/// Nodes on the navigation meshes of buildings. Any thread.
class MeshFloor final : public tasks::EpisodeFloor {
 public:
  /// Habitat's nodes lie up to 1.6 m beside their viewpoints.
  static constexpr continuous::Reach kReach{1.6F, 0.8F};

  /// \throws ArgumentError if `buildings` is null
  explicit MeshFloor(std::shared_ptr<const continuous::Buildings> buildings,
                     const DetourLimit& limit = {});

  /// The point of the floor nearest to where the connectivity file has it. No value where none is
  /// in kReach, or where the building has no mesh.
  std::optional<Vec3d> node_of(const graph::NavGraph& graph,
                               ViewpointIndex viewpoint) const override;
  tasks::WalkedNodes walk(const graph::NavGraph& graph,
                          std::span<const Vec3d> nodes) const override;

 private:
  std::shared_ptr<const continuous::Buildings> buildings_;
  DetourLimit limit_;
};

}  // namespace enfilade::agents
