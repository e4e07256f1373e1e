#include "enfilade/neural/seq2seq/model.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::neural::seq2seq {

namespace fs = std::filesystem;

Model load_model(const fs::path& folder, const std::string& device) {
  const models::ModelFiles files = models::require_model(folder);
  models::ModelConfig config = models::load_model_config(files.config());
  if (config.training.agent != models::AgentKind::kSeq2Seq) {
    throw ArgumentError(fmt::format("{}: an agent {}, not seq2seq", folder.string(),
                                    to_string(config.training.agent)));
  }
  tasks::Vocabulary vocabulary = models::load_vocabulary(files, config.training.network);
  const models::StateFile state = models::open_state(files.weights());
  Network network(config.training.network, config.training.seed, device);
  network.load_weights(state.file);
  return {std::move(config), std::move(vocabulary), state.iteration, std::move(network)};
}

}  // namespace enfilade::neural::seq2seq
