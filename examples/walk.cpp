// Walk two agents through a building: make a graph, start, look around, go.
#include <fmt/core.h>

#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/small_building.h"
#include "enfilade/sim/simulator.h"

int main() {
  using namespace enfilade;

  // Real buildings: graph::GraphSet::open("data/connectivity").
  std::vector<graph::NavGraph> buildings;
  buildings.emplace_back(homes::make_small_building(1, "synth").connectivity);
  const auto graphs = graph::GraphSet::of(std::move(buildings));

  sim::SimulatorConfig config = sim::SimulatorConfig::room_to_room();
  config.batch_size = 2;
  sim::Simulator simulator(graphs, config);
  sim::StateBuffer buffer(config.batch_size, config.max_navigable);
  const sim::StateSpans state = buffer.spans();

  const std::vector<ScanIndex> scans(config.batch_size, ScanIndex(0));
  simulator.new_random_episodes(scans, state);
  std::vector<sim::Action> actions(config.batch_size);
  for (int step = 0; step < 12; ++step) {
    for (std::size_t agent = 0; agent < config.batch_size; ++agent) {
      // Forward if something is ahead, else turn right.
      const bool ahead = state.navigable_count[agent] > 1;
      actions[agent] = ahead ? sim::Action{1, {}, {}} : sim::Action{0, degrees(30), {}};
    }
    simulator.step(actions, state);
    for (std::size_t agent = 0; agent < config.batch_size; ++agent) {
      fmt::print("step {:2}, agent {}: viewpoint {:2}, heading {:3.0f} degrees, {} ways to go\n",
                 state.step[agent], agent, state.viewpoint[agent].value,
                 to_degrees(Radians(state.heading[agent])), state.navigable_count[agent] - 1);
    }
  }
}
