// What the results' reader accepts, scoring and the writer must take.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "tests/fuzz/fixture.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  static const tasks::EpisodeSet kEpisodes = fuzz::episodes();
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const tasks::Results results = tasks::parse_results(text, "<fuzz>", kEpisodes);
    for (const auto& m : tasks::score_trajectories(results.trajectories, kEpisodes, {}, 1)) {
      EN_CHECK(std::isfinite(m.nav_error) && m.spl >= 0 && m.spl <= 1);
    }
    const std::string written = to_json(results.trajectories, kEpisodes);
    EN_CHECK_EQ(to_json(tasks::parse_results(written, "<fuzz>", kEpisodes).trajectories, kEpisodes),
                written);
  } catch (const Error&) {
  }
  return 0;
}
