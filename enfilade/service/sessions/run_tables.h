/// \file  Runs as tables: the episodes of one, its measures, two runs beside each other.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "enfilade/service/sessions/known_episodes.h"
#include "enfilade/service/sessions/run_folder.h"

namespace enfilade::service::sessions {

/// What a run's episodes are ordered by.
enum class EpisodeSort : std::uint8_t {
  kEpisode,  ///< the id: by length, then by letters
  kSuccess,
  kSpl,
  kNavError,
  kSteps,
  kMistakes,
  kUnanswered,
  kTokens,  ///< in and out
};
constexpr std::array<std::string_view, 8> names_of(EpisodeSort /*enum*/) {
  return {"episode", "success", "spl", "nav_error", "steps", "mistakes", "unanswered", "tokens"};
}

/// Which of a run's episodes are listed.
enum class EpisodeShow : std::uint8_t {
  kAll,
  kFailures,   ///< without success
  kSuccesses,  ///< with success
  kMistakes,   ///< with a mistake, or an answer without a call
  kUnstopped,  ///< that did not end by a stop
};
constexpr std::array<std::string_view, 5> names_of(EpisodeShow /*enum*/) {
  return {"all", "failures", "successes", "mistakes", "unstopped"};
}

/// A page of a run's episodes.
struct EpisodeQuery {
  std::size_t offset = 0, limit = 500;
  EpisodeSort sort = EpisodeSort::kEpisode;
  bool descending = false;  ///< unknown values are last either way
  EpisodeShow show = EpisodeShow::kAll;
};

/// {"matching", "list"}, the latter with entries of {"episode", "instruction"?, "ending",
/// "reason"?, "steps", "mistakes", "unanswered", "prompt_tokens", "answer_tokens", "success"?,
/// "spl"?, "nav_error"?}, or "problem" from "ending" on.
/// \throws Refusal kInvalidInput for failures and successes without outcomes
nlohmann::ordered_json episode_list(const Run& run, KnownEpisodes& known,
                                    const EpisodeQuery& query);

/// Sums and means over the episodes that the run has: {"ended", "steps", "mistakes", "unanswered",
/// "prompt_tokens", "answer_tokens", "seconds"?, "money"?, "scored", "scores"}. Seconds and money
/// are those of usage.json, which `enfilade ask` writes at its end. `scores` are the columns of
/// scorer_of() with their "mean", shares or metres, over the scored episodes; empty without
/// outcomes.
nlohmann::ordered_json measures_json(const Run& run, KnownEpisodes& known);

/// Two runs of a split over the episodes that both have: {"episodes", "only_first", "only_second",
/// "outcomes", "columns", "differing", "list"}. A column has "episodes", the means "first" and
/// "second", their "difference" (second - first) with its interval of 95 %, and "p". Interval
/// and "p" are those of tasks::paired_bootstrap() with a path's instructions as a group. `list` is
/// a page of the episodes that differ: in success, or without outcomes in where or how they end.
/// \throws Refusal kInvalidInput if the two are of different splits
nlohmann::ordered_json compare_json(const Run& first, const Run& second, KnownEpisodes& known,
                                    std::size_t offset, std::size_t limit);

}  // namespace enfilade::service::sessions
