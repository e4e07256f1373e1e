// An agent of one's own, run over a split and scored: walks straight on, six moves.
#include <fmt/core.h>
#include <filesystem>

#include "enfilade/agents/run.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/small_building.h"
#include "enfilade/r2r/score.h"
#include "enfilade/scan/data_root.h"

namespace {

using namespace enfilade;

class StraightOn : public agents::Agent {
 public:
  std::string_view name() const override { return "straight-on"; }
  void start(std::span<const agents::Observation> batch) override {
    moves_.assign(batch.size(), 0);
  }
  void act(std::span<const agents::Observation> batch,
           std::span<agents::Decision> decisions) override {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const bool ahead = batch[i].navigable.size() > 1;
      if (moves_[i] == 6) {
        decisions[i] = agents::Decision::stop_here();
      } else {
        decisions[i] = ahead ? agents::Decision::go(1) : agents::Decision::turn(1);
        moves_[i] += ahead ? 1 : 0;
      }
    }
  }

 private:
  std::vector<int> moves_;
};

}  // namespace

int main() {
  // Real data: scan::DataRoot::from_environment() with ENFILADE_DATA set.
  const auto folder = std::filesystem::temp_directory_path() / "enfilade_example_own_agent";
  homes::write_small_dataset(folder);
  const scan::DataRoot data(folder);
  const r2r::EpisodeSet episodes =
      r2r::make_episodes(r2r::load_annotations(data.annotations("val_unseen"), "val_unseen"),
                         graph::GraphSet::open(data.connectivity()));

  StraightOn agent;
  const auto trajectories = agents::run_agent(agent, episodes);
  fmt::print("{} on synthetic buildings\n{}", agent.name(),
             r2r::to_table(r2r::compute_score(trajectories, episodes)));
  std::filesystem::remove_all(folder);
}
