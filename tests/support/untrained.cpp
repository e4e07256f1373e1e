#include "tests/support/untrained.h"

#include <fmt/format.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/neural/duet/duet_network.h"
#include "enfilade/neural/panoramic/panoramic_network.h"

namespace enfilade::tests {

void write_untrained(const models::ModelConfig& config, const std::filesystem::path& folder) {
  const models::TrainConfig& training = config.training;
  const models::ModelFiles files{folder};
  if (training.agent != models::AgentKind::kDuet &&
      training.agent != models::AgentKind::kPanoramic) {
    throw ArgumentError(
        fmt::format("agent {}: panoramic or duet is written untrained", to_string(training.agent)));
  }
  make_folder(folder);
  const auto write = [&](const neural::core::Weights& weights) {
    models::write_state(files.weights(), neural::core::as_arrays(weights), 0);
  };
  if (training.agent == models::AgentKind::kDuet) {
    write(neural::duet::DuetNetwork(duet_sizes(training), training.seed).weights());
  } else {
    write(neural::panoramic::PanoramicNetwork(panoramic_sizes(training), training.seed).weights());
  }
  write_file_atomically(files.config(), to_json(config));
}

}  // namespace enfilade::tests
