#include "bench/peer/old_simulator.h"

#include <MatterSim.hpp>

namespace enfilade::bench {
namespace {

class Walker final : public OldSimulator {
 public:
  explicit Walker(const OldWalk& walk) : walk_(walk), sights_(walk.scans.size()) {
    simulator_.setDatasetPath(walk.images);
    simulator_.setNavGraphPath(walk.connectivity);
    simulator_.setCameraResolution(static_cast<int>(walk.camera.width),
                                   static_cast<int>(walk.camera.height));
    simulator_.setCameraVFOV(walk.camera.vertical_field_of_view.value);
    simulator_.setDiscretizedViewingAngles(true);
    simulator_.setDepthEnabled(walk.depth);
    simulator_.setBatchSize(static_cast<unsigned>(walk.scans.size()));
    simulator_.setCacheSize(static_cast<unsigned>(walk.cache_panoramas) + 1);  // holds one less
    simulator_.initialize();
    for (const std::vector<sim::Action>& step : walk.actions) steps_.emplace_back(step);
  }

  void walk(const Look& each) override {
    const std::vector<double> zeros(walk_.scans.size(), 0);
    simulator_.newEpisode(walk_.scans, walk_.viewpoints, zeros, zeros);
    if (each) look(0, each);
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      simulator_.makeAction(steps_[i].index, steps_[i].heading, steps_[i].elevation);
      if (each) look(i + 1, each);
    }
  }

 private:
  // One step's actions as it takes them.
  struct Step {
    explicit Step(const std::vector<sim::Action>& actions) {
      for (const sim::Action& action : actions) {
        index.push_back(action.index);
        heading.push_back(action.heading_change.value);
        elevation.push_back(action.elevation_change.value);
      }
    }
    std::vector<unsigned> index;
    std::vector<double> heading, elevation;
  };

  void look(std::size_t step, const Look& each) {
    const std::size_t pixels = std::size_t{walk_.camera.width} * walk_.camera.height;
    const auto& states = simulator_.getState();
    for (std::size_t i = 0; i < states.size(); ++i) {
      const mattersim::SimState& state = *states[i];
      sights_[i] = {state.location->ix,
                    state.heading,
                    state.elevation,
                    {state.rgb.ptr<std::uint8_t>(), 3 * pixels},
                    {state.depth.ptr<std::uint16_t>(), pixels}};
    }
    each(step, sights_);
  }

  OldWalk walk_;
  mattersim::Simulator simulator_;
  std::vector<Step> steps_;
  std::vector<OldSight> sights_;
};

}  // namespace

std::unique_ptr<OldSimulator> make_old_simulator(const OldWalk& walk) {
  return std::make_unique<Walker>(walk);
}

std::string old_simulator_description() {
#ifdef OSMESA_RENDERING
  return "old simulator (OSMesa)";
#else
  return "old simulator (EGL)";
#endif
}

bool old_simulator_built() { return true; }

}  // namespace enfilade::bench
