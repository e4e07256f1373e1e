// Replaces without_torch.cpp in `enfilade-learn`.
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/mesh_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/threads.h"
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

void add_rank_options(CLI::App& verb, RankOptions& options) {
  add_whole_number(verb, "--timeout", options.timeout,
                   "Seconds that a process waits for the others, before it ends");
}

neural::Ranks join_ranks(const std::optional<neural::RankPlace>& place, const RankOptions& options,
                         int threads) {
  const int beside = place ? place->local_size : 1;
  const int own = threads > 0 ? threads : std::max(1, available_threads() / beside);
  neural::set_threads(own);
  if (!place) return {};
  neural::Ranks ranks(*place, std::chrono::seconds(options.timeout));
  const neural::TorchKind torch = neural::torch_kind();
  ranks.agree({{"enfilade", version_with_commit()},
               {"libtorch", torch.version},
               {"instructions of the processor", torch.instructions},
               {"threads", std::to_string(own)}});
  return ranks;
}

std::string device_of(const std::string& device, const std::optional<neural::RankPlace>& place) {
  if (device != "cuda" || !place || place->local_size == 1) return device;
  return fmt::format("cuda:{}", place->local_rank % std::max(neural::card_count(), 1));
}

}  // namespace enfilade::apps
