#include "apps/enfilade/continuous/split_episodes.h"

#include <fmt/format.h>

#include <string_view>

#include "apps/common/program.h"
#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/mesh_floor.h"

namespace enfilade::apps {

SplitEpisodes derive_split(const tasks::Annotations& annotations, const graph::GraphSet& graphs,
                           const std::shared_ptr<const continuous::Buildings>& buildings,
                           const agents::ContinuousSetup& setup, const std::string& split,
                           const tasks::DeriveOptions& options) {
  SplitEpisodes made{
      tasks::derive_continuous(annotations, graphs, agents::MeshFloor(buildings), options), {}};
  tasks::ContinuousEpisodes& episodes = made.derived.episodes;
  const std::string_view floor = buildings->floor_name();
  if (floor != continuous::name_of(continuous::FloorKind::kEnfilade)) {
    episodes.others.emplace_back("floor", fmt::format("\"{}\"", floor));
  }
  if (goals_hidden(episodes)) return made;
  const agents::ContinuousRunOptions run{.batch_size = 64, .seed = 1, .simulator = setup.simulator};
  made.experts =
      agents::record_experts(episodes, buildings, run, progress_bar("experts, " + split));
  return made;
}

}  // namespace enfilade::apps
