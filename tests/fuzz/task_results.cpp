// What the results' reader accepts of any benchmark, each of its scorers must take. The first byte
// says which benchmark.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/score_table.h"
#include "tests/fuzz/fixture.h"

namespace {

using namespace enfilade;
using tasks::Task;

std::vector<tasks::EpisodeSet> all_episodes() {
  std::vector<tasks::EpisodeSet> all;
  for (std::uint8_t task = 0; task <= static_cast<std::uint8_t>(Task::kSoon); ++task) {
    all.push_back(fuzz::episodes_of(static_cast<Task>(task)));
  }
  return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto kEpisodes = all_episodes();
  if (size == 0) return 0;
  const auto& episodes = kEpisodes[data[0] % kEpisodes.size()];
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    const tasks::Results results = tasks::parse_results(text, "<fuzz>", episodes);
    for (const tasks::Scorer& scorer : tasks::benchmark(episodes.task).scorers) {
      const auto score = tasks::compute_score(results.trajectories, episodes, scorer,
                                              {.threads = 1, .bootstrap_samples = 10});
      EN_CHECK_EQ(score.means.size(), scorer.metrics.size());
      to_json(score, true);
    }
  } catch (const Error&) {
  }
  return 0;
}
