// Submissions to a server, of every benchmark: {"benchmark": 0, "results": ...}. What the check
// accepts is scored without an error, by each of the benchmark's scorers, and again from what we
// write.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/service/evaluation/submissions.h"
#include "enfilade/service/phases.h"
#include "enfilade/service/site.h"
#include "tests/fuzz/fixture.h"
#include "tests/fuzz/json_mutator.h"
#include "tests/support/room_world.h"

namespace {

using namespace enfilade;
using fuzz::Json;
using service::SecretEpisodes;

/// Episodes of each row of tasks::benchmarks().
std::vector<SecretEpisodes> all_episodes() {
  std::vector<SecretEpisodes> all;
  for (const tasks::Benchmark& benchmark : tasks::benchmarks()) {
    if (benchmark.continuous()) {
      const arena::FloorWorld room = arena::testing::room(0, benchmark.name);
      all.push_back({room.episodes(), room.buildings()});
    } else {
      all.push_back({tasks::Split(fuzz::episodes_of(benchmark.task))});
    }
  }
  return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto kEpisodes = all_episodes();
  const Json input = fuzz::parse_input(data, size);
  if (!input.is_object() || !input.contains("results") || !input.contains("benchmark") ||
      !input["benchmark"].is_number_unsigned()) {
    return -1;
  }
  const SecretEpisodes& episodes =
      kEpisodes[input["benchmark"].get<std::uint64_t>() % kEpisodes.size()];
  const std::string results = fuzz::text_of(input["results"]);
  try {
    service::evaluation::check_results(episodes, results);
  } catch (const InvalidInput&) {
    return 0;
  }
  const std::string written =
      to_json(tasks::parse_trajectories(results, "<fuzz>", episodes.split), episodes.split);
  service::Phase phase;
  phase.benchmark = &episodes.split.benchmark();
  for (const tasks::Scorer& scorer : phase.benchmark->scorers) {
    phase.scorer = &scorer;
    phase.primary = phase.measures().front().name;
    const auto scored = service::evaluation::score_results(phase, episodes, results);
    EN_CHECK(!std::isinf(scored.primary));
    EN_CHECK_EQ(scored.ends.size(), 4 * episodes.split.size());
    // Not all measures: DUET's count the steps as the file groups them.
    const double again = service::evaluation::score_results(phase, episodes, written).primary;
    EN_CHECK(again == scored.primary || std::isnan(scored.primary));
  }
  return 0;
}
