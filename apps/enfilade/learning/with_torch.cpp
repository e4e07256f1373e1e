// Replaces without_torch.cpp in `enfilade-learn`.
#include <optional>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "enfilade/neural/seq2seq_agent.h"

namespace enfilade::apps {

bool can_learn() { return true; }

void hand_over_to_learn() {}

std::optional<neural::TorchReport> torch_report() { return neural::examine_torch(); }

std::unique_ptr<agents::Agent> load_trained_agent(const std::string& folder,
                                                  const std::string& features,
                                                  const tasks::EpisodeSet& episodes) {
  neural::set_threads(0);
  neural::Model model = neural::load_model(folder);
  std::optional<features::FeatureSet> file;
  if (!features.empty()) file = features::FeatureSet::open(features);
  models::DataFingerprint here;
  here.add_graphs(episodes);
  if (file) here.features = file->info();
  const auto warnings =
      differences(model.config.data, here, models::ModelFiles{folder}.config().string());
  if (!warnings.empty()) print_diagnostics(warnings);
  std::optional<neural::ViewFeatures> views;
  if (const auto* used = usable_features(model.config, file ? &*file : nullptr)) {
    views.emplace(*used, episodes);
  }
  return std::make_unique<neural::Seq2SeqAgent>(std::move(model), std::move(views));
}

}  // namespace enfilade::apps
