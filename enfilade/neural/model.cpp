#include "enfilade/neural/model.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::neural {

namespace fs = std::filesystem;

models::ModelFiles require_model(const fs::path& folder) {
  models::ModelFiles files{folder};
  for (const fs::path& file : {files.config(), files.weights()}) {
    if (fs::exists(file)) continue;
    throw FileError(fmt::format("{}: no {} in it, so it is no model; `enfilade train` makes one",
                                folder.string(), file.filename().string()));
  }
  return files;
}

Model load_model(const fs::path& folder, const std::string& device) {
  const models::ModelFiles files = require_model(folder);
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

}  // namespace enfilade::neural
