#include "apps/enfilade/continuous/walked_episode.h"

#include <fmt/format.h>

namespace enfilade::apps {

const tasks::ContinuousEpisode* find_episode(const tasks::ContinuousEpisodes& episodes,
                                             const std::string& id) {
  for (const tasks::ContinuousEpisode& e : episodes.episodes) {
    if (tasks::text_of(e.id) == id) return &e;
  }
  return nullptr;
}

tasks::ContinuousResult walk_of(const std::string& results,
                                const tasks::ContinuousEpisodes& episodes,
                                const tasks::ContinuousEpisode& episode) {
  for (tasks::ContinuousResult& walk :
       tasks::load_continuous_results(results, episodes, tasks::Coverage::kPart)) {
    if (&episodes.episodes.at(walk.episode) == &episode) return std::move(walk);
  }
  throw UsageError(
      fmt::format("{}: has no walk of episode {}", results, tasks::text_of(episode.id)));
}

}  // namespace enfilade::apps
