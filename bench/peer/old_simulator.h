/// \file  The old simulator, MatterSim v0.2 (peteanderson80/Matterport3DSimulator), driven along a
/// walk of ours.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/geometry/camera.h"
#include "enfilade/sim/simulator.h"

namespace enfilade::bench {

/// What it needs to walk as we did.
struct OldWalk {
  Camera camera;
  bool depth = false;                ///< draw it beside colour
  std::string images, connectivity;  ///< folders: `<scan>/matterport_skybox_images`, graphs
  std::size_t cache_panoramas = 0;   ///< that it keeps as textures; all, so that none is made twice
  std::vector<std::string> scans, viewpoints;     ///< of the start, by agent
  std::vector<std::vector<sim::Action>> actions;  ///< by step and agent
};

/// What it shows to one agent; valid until it goes on.
struct OldSight {
  std::uint32_t viewpoint = 0;  ///< place in the connectivity file
  double heading = 0, elevation = 0;
  std::span<const std::uint8_t> bgr;
  std::span<const std::uint16_t> depth;  ///< quarter millimetres; zeros if not drawn
};

/// One for a process: a second would share the first one's paths and break its OpenGL context.
class OldSimulator {
 public:
  virtual ~OldSimulator() = default;
  /// From the start to the end; `each`, where given, sees the start as step 0. Everything is drawn.
  using Look = std::function<void(std::size_t step, std::span<const OldSight> agents)>;
  virtual void walk(const Look& each) = 0;
};

/// Null where this build has none. \throws what it throws
std::unique_ptr<OldSimulator> make_old_simulator(const OldWalk& walk);

/// "old simulator (OSMesa)", or why this build has none.
std::string old_simulator_description();
/// Whether this build has it.
bool old_simulator_built();

}  // namespace enfilade::bench
