// Replaces without_torch.cpp in `enfilade-learn`.
#include <optional>
#include <string>

#include "apps/common/program.h"
#include "apps/enfilade/continuous/scenes.h"
#include "apps/enfilade/learning/learn.h"
#include "enfilade/neural/continuous_agent.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/trained_agent.h"

namespace enfilade::apps {

bool can_learn() { return true; }

void hand_over_to_learn() {}

std::optional<neural::TorchReport> torch_report() { return neural::examine_torch(); }

std::unique_ptr<agents::Agent> load_trained_agent(const std::string& folder,
                                                  const std::string& features,
                                                  const tasks::EpisodeSet& episodes) {
  neural::set_threads(0);
  auto agent = neural::load_trained_agent(folder);
  std::optional<features::FeatureSet> file;
  if (!features.empty()) {
    file = without_class_scores(features::FeatureSet::open(features),
                                agent->config().training.network.features);
  }
  models::DataFingerprint here;
  here.add_graphs(episodes);
  if (file) here.features = file->info();
  const auto warnings =
      differences(agent->config().data, here, models::ModelFiles{folder}.config().string());
  if (!warnings.empty()) print_diagnostics(warnings);
  agent->enter(episodes, file ? &*file : nullptr);
  return agent;
}

std::unique_ptr<agents::ContinuousAgent> load_continuous_agent(
    const std::string& folder, const dataset::Dataset& data, const MeshSource& meshes,
    const tasks::ContinuousEpisodes& episodes, int threads) {
  neural::ContinuousSight sight{.scene_of = {}, .encoder = {}, .threads = threads};
  // By value: the agent outlives this call.
  sight.scene_of = [data, meshes, threads](const std::string& scan) {
    return scene_of_scan(data, meshes, scan, threads);
  };
  auto agent = neural::load_continuous_agent(folder, sight);
  models::DataFingerprint here;
  here.add(episodes);
  const auto warnings =
      differences(agent->config().data, here, models::ModelFiles{folder}.config().string());
  if (!warnings.empty()) print_diagnostics(warnings);
  return agent;
}

}  // namespace enfilade::apps
