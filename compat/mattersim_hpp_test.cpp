#include "MatterSim.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/store.h"
#include "tests/support/panoramas.h"
#include "tests/support/temporary_folder.h"

namespace EN_UNIT {

using enfilade::Radians;
using enfilade::ScanIndex;
using enfilade::ViewpointIndex;
using mattersim::SimState;
using mattersim::SimStatePtr;
using mattersim::Simulator;

// Twelve viewpoints in a row, with pictures, made here.
class MatterSimHpp : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new enfilade::tests::TemporaryFolder("mattersim_hpp");
    const auto panoramas = enfilade::scan::testing::memory_panoramas("row", 12, 16);
    enfilade::scan::save_connectivity(folder_->path() / "connectivity",
                                      enfilade::scan::testing::row_of_viewpoints("row", 12));
    enfilade::scan::pack(*panoramas, folder_->path() / "store", {});
    graphs_ = enfilade::graph::GraphSet::open_shared(folder_->path() / "connectivity");
  }
  static void TearDownTestSuite() {
    graphs_.reset();
    delete folder_;
  }

  static std::string path(const char* name) { return (folder_->path() / name).string(); }
  static const std::string& scan() { return graphs_->scans()[0]; }
  static const enfilade::graph::NavGraph& graph() { return graphs_->graph(ScanIndex(0)); }
  static void set_up(Simulator& sim, unsigned int agents = 1) {
    sim.setNavGraphPath(path("connectivity"));
    sim.setDatasetPath(path("store"));
    sim.setRenderingEnabled(false);
    sim.setBatchSize(agents);
  }
  static std::vector<std::string> scans(std::size_t n) {
    return std::vector<std::string>(n, scan());
  }

  static inline enfilade::tests::TemporaryFolder* folder_ = nullptr;
  static inline std::shared_ptr<const enfilade::graph::GraphSet> graphs_;
};

void expect_equal(const SimState& state, const enfilade::sim::StateSpans& now, std::size_t agent,
                  const enfilade::graph::NavGraph& graph) {
  EXPECT_EQ(state.heading, now.heading[agent]);
  EXPECT_EQ(state.elevation, now.elevation[agent]);
  EXPECT_EQ(state.viewIndex, now.view_index[agent]);
  EXPECT_EQ(state.step, now.step[agent]);
  EXPECT_EQ(state.location->ix, now.viewpoint[agent].value);
  EXPECT_EQ(state.location->viewpointId, graph.id(now.viewpoint[agent]));
  ASSERT_EQ(state.navigableLocations.size(), now.navigable_count[agent]);
  EXPECT_EQ(state.navigableLocations[0], state.location);
  for (std::size_t k = 1; k < state.navigableLocations.size(); ++k) {
    const std::size_t row = agent * now.max_navigable() + k;
    const mattersim::Viewpoint& there = *state.navigableLocations[k];
    EXPECT_EQ(there.ix, now.navigable_viewpoint[row].value);
    EXPECT_EQ(there.rel_heading, now.navigable_rel_heading[row]);
    EXPECT_EQ(there.rel_elevation, now.navigable_rel_elevation[row]);
    EXPECT_EQ(there.rel_distance, now.navigable_distance[row]);
    EXPECT_EQ(there.x, graph.position(ViewpointIndex(std::size_t{there.ix})).x);
  }
}

TEST_F(MatterSimHpp, WalksAsTheNativeSimulatorToTheBit) {
  constexpr std::size_t kAgents = 3;
  for (const bool discretized : {false, true}) {
    Simulator sim;
    set_up(sim, kAgents);
    sim.setDiscretizedViewingAngles(discretized);
    sim.initialize();
    auto config = enfilade::sim::SimulatorConfig::mattersim();
    config.batch_size = kAgents;
    if (discretized) config.viewing = enfilade::sim::Viewing::kDiscretized;
    enfilade::sim::Simulator native(graphs_, config);
    native.new_random_episodes(std::vector<ScanIndex>(kAgents, ScanIndex(0)));
    sim.newRandomEpisode(scans(kAgents));
    const std::vector<SimStatePtr> states = sim.getState();
    enfilade::Rng rng(1);
    for (int step = 0; step < 100; ++step) {
      std::vector<enfilade::sim::Action> actions;
      std::vector<unsigned int> index;
      std::vector<double> heading, elevation;
      for (std::size_t i = 0; i < kAgents; ++i) {
        expect_equal(*states[i], native.state(), i, graph());
        const auto chosen =
            static_cast<std::uint32_t>(rng.below(native.state().navigable_count[i]));
        const double right = rng.uniform() - 0.5, up = rng.uniform() - 0.5;
        actions.push_back({chosen, Radians(right), Radians(up)});
        index.push_back(chosen);
        heading.push_back(right);
        elevation.push_back(up);
      }
      native.step(actions);
      sim.makeAction(index, heading, elevation);
    }
    EXPECT_EQ(sim.getState(), states) << "the same objects at every call";
  }
}

TEST_F(MatterSimHpp, GivesTheOldHeadingsAtEveryRandomStart) {
  Simulator sim;
  set_up(sim, 3);
  for (int call = 0; call < 2; ++call) {
    sim.newRandomEpisode(scans(3));  // initializes by itself
    const double wanted[] = {0.826476, 2.881784, 1.375761};
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(sim.getState()[i]->heading, wanted[i], 1e-6);
  }
}

TEST_F(MatterSimHpp, AMoveKeepsTheObjectOfTheList) {
  Simulator sim;
  set_up(sim);
  sim.setRestrictedNavigation(false);
  sim.newEpisode({scan()}, {graph().id(ViewpointIndex(0))}, {0}, {0});
  const SimStatePtr state = sim.getState().at(0);
  ASSERT_GT(state->navigableLocations.size(), 1U);
  const mattersim::ViewpointPtr there = state->navigableLocations[1];
  EXPECT_GT(there->rel_distance, 0);
  sim.makeAction({1}, {0.5}, {0});
  EXPECT_EQ(state->location, there);
  EXPECT_EQ(there->rel_distance, 0);
  EXPECT_EQ(state->step, 1U);
}

TEST_F(MatterSimHpp, DrawsWhatTheRendererDraws) {
  Simulator sim;
  set_up(sim, 2);
  sim.setRenderingEnabled(true);
  sim.setDepthEnabled(true);
  sim.setCameraResolution(40, 30);
  sim.setPreloadingEnabled(true);
  const std::string start = graph().id(ViewpointIndex(0));
  sim.newEpisode(scans(2), {start, start}, {0, 1}, {0, 0.1});
  const mattersim::Mat rgb = sim.getState()[1]->rgb, depth = sim.getState()[1]->depth;
  ASSERT_EQ(rgb.rows, 30);
  ASSERT_EQ(rgb.cols, 40);
  ASSERT_EQ(rgb.elemSize(), 3U);
  ASSERT_EQ(depth.elemSize(), 2U);
  const auto panoramas = enfilade::scan::PanoramaSet::open(
      {{folder_->path() / "store"}, folder_->path() / "connectivity"}, graphs_->scans());
  enfilade::render::RendererConfig config;
  config.legacy.clamped_edges = true;
  const auto renderer = enfilade::render::make_renderer(
      std::make_shared<enfilade::render::FaceCache>(panoramas), config);
  std::vector<std::byte> wanted(rgb.total() * 3);
  enfilade::render::Outputs outputs;
  outputs.colour = {enfilade::render::ColourFormat::kBgr8, {}, wanted};
  const std::vector views{
      enfilade::render::View{ScanIndex(0), ViewpointIndex(0), Radians(1), Radians(0.1)}};
  renderer->render({40, 30, Radians(0.8)}, views, outputs);
  EXPECT_EQ(std::memcmp(wanted.data(), rgb.data, wanted.size()), 0);
  std::set<std::uint16_t> depths;
  for (int row = 0; row < depth.rows; ++row) {
    for (int column = 0; column < depth.cols; ++column) {
      depths.insert(depth.at<std::uint16_t>(row, column));
    }
  }
  EXPECT_GT(depths.size(), 100U);
  const std::vector<unsigned char> before(rgb.data, rgb.data + rgb.total() * 3);
  sim.makeAction({0, 0}, {1, 1}, {0, 0});
  EXPECT_NE(std::memcmp(before.data(), rgb.data, before.size()), 0) << "drawn over in place";
  sim.setCameraResolution(20, 10);
  sim.makeAction({0, 0}, {0, 0}, {0, 0});
  EXPECT_EQ(sim.getState()[0]->rgb.cols, 20);
  EXPECT_THAT(sim.timingInfo(), ::testing::HasSubstr("frames: 6"));
}

TEST_F(MatterSimHpp, RefusesWithTheOldTypes) {
  Simulator sim;
  set_up(sim);
  const std::string start = graph().id(ViewpointIndex(0));
  EXPECT_FALSE(sim.setElevationLimits(0.1, 0.2));
  EXPECT_TRUE(sim.setElevationLimits(-0.5, 0.5));
  EXPECT_TRUE(sim.getState().empty());
  EXPECT_THROW(sim.makeAction({0}, {0}, {0}), std::runtime_error);
  EXPECT_THROW(sim.newEpisode({"nowhere"}, {start}, {0}, {0}), std::out_of_range);
  EXPECT_THROW(sim.newEpisode({scan()}, {"nowhere"}, {0}, {0}), std::invalid_argument);
  EXPECT_THROW(sim.newEpisode({scan()}, {start}, {}, {0}), std::out_of_range);
  EXPECT_THROW(sim.newEpisode({scan()}, {start}, {std::nan("")}, {0}), std::invalid_argument);
  sim.newEpisode({scan()}, {start}, {0}, {2});
  EXPECT_EQ(sim.getState()[0]->elevation, 0.5);
  EXPECT_THROW(sim.makeAction({99}, {0}, {0}), std::domain_error);
  EXPECT_EQ(sim.getState()[0]->step, 0U);
  sim.setCameraResolution(-1, 10);
  EXPECT_THROW(sim.makeAction({0}, {0}, {0}), std::invalid_argument);
  sim.setCameraResolution(20, 10);
  EXPECT_THROW(sim.makeAction({0}, {std::nan("")}, {0}), std::invalid_argument);
  sim.makeAction({0}, {0}, {0});
  EXPECT_EQ(sim.getState()[0]->step, 1U);
  sim.close();
  EXPECT_TRUE(sim.getState().empty());
  sim.setNavGraphPath("/nowhere");
  EXPECT_THROW(sim.newEpisode({scan()}, {start}, {0}, {0}), std::invalid_argument);
  sim.setCameraResolution(0, 10);
  EXPECT_THROW(sim.initialize(), std::invalid_argument);
}

}  // namespace EN_UNIT
