#include "apps/enfilade/learning/rank_options.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <string>

#include "apps/common/program.h"
#include "apps/enfilade/version.h"
#include "enfilade/core/threads.h"
#include "enfilade/neural/device.h"

namespace enfilade::apps {

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
