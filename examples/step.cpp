// Step: two agents walk through a building; each goes forward if something is ahead, else turns.
#include <enfilade/enfilade.h>

#include <cstdio>
#include <vector>

int main() {
  using namespace enfilade;
  const Dataset d("homes");  // made as in render.cpp
  SimulatorConfig config = SimulatorConfig::room_to_room();
  config.batch_size = 2;
  Simulator simulator(d.graphs(), config);
  simulator.new_random_episodes(
      std::vector{d.graphs()->at("home0001"), d.graphs()->at("home0002")});

  std::vector<Action> actions(config.batch_size);
  for (int step = 0; step < 12; ++step) {
    for (std::size_t agent = 0; agent < config.batch_size; ++agent) {
      const bool ahead = simulator.state().navigable_count[agent] > 1;
      actions[agent] = ahead ? Action{1, {}, {}} : Action{0, 30_deg, {}};
    }
    simulator.step(actions);
  }
  for (std::size_t agent = 0; agent < config.batch_size; ++agent) {
    std::printf("agent %zu: step %u, viewpoint %u, heading %.0f degrees\n", agent,
                simulator.state().step[agent], simulator.state().viewpoint[agent].value,
                to_degrees(Radians(simulator.state().heading[agent])));
  }
}
