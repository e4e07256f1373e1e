// An agent of one's own, run over a split and scored: walks straight on, six moves.
#include <enfilade/enfilade.h>

#include <iostream>
#include <vector>

namespace {

using namespace enfilade;

class StraightOn : public Agent {
 public:
  std::string_view name() const override { return "straight-on"; }
  void start(std::span<const Observation> batch) override { moves_.assign(batch.size(), 0); }
  void act(std::span<const Observation> batch, std::span<Decision> decisions) override {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const bool ahead = batch[i].navigable.size() > 1;
      if (moves_[i] == 6) {
        decisions[i] = Decision::stop_here();
      } else {
        decisions[i] = ahead ? Decision::go(1) : Decision::turn(1);
        moves_[i] += ahead ? 1 : 0;
      }
    }
  }

 private:
  std::vector<int> moves_;  // by slot
};

}  // namespace

int main() {
  const auto episodes = Dataset("homes").episodes("val_unseen");  // made as in render.cpp
  StraightOn agent;
  std::cout << agent.name() << " on synthetic buildings\n"
            << to_table(compute_score(run_agent(agent, episodes), episodes));
}
