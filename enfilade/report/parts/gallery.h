/// \file  The page's gallery: some episodes of one run, step by step.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/models/decisions.h"
#include "enfilade/report/parts/picture_parts.h"
#include "enfilade/report/scored_runs.h"

namespace enfilade::report::parts {

/// One run, and its records beside its trajectories.
struct RunRecord {
  const ScoredRun* run = nullptr;
  std::optional<models::RecordedSplit> recorded;
};

/// The subject of the gallery.
struct GalleryRun : RunRecord {
  std::string no_attention;  ///< a sentence: why nothing is recorded.
  /// Shown beside it, if it or any of them chooses among viewpoints: other models on the same split
  /// with records.
  std::vector<RunRecord> others;

  bool shows_decisions() const;  ///< whether any chooses among viewpoints
};

/// The run with most to show; no value if there is none. The first of these rules that differs:
/// - a trained model, not another agent
/// - a model that chooses among viewpoints
/// - student-forcing
/// - val_unseen, then val_seen
/// - success, if the model chooses among viewpoints
///
/// \throws as load_recorded_split()
std::optional<GalleryRun> choose_run(const ScoredRuns& runs, const RunDirectory& found);

/// `each` of the best, of the worst and at random; one episode per path. Only those with records,
/// if there are any. The best are successes by the shortest path, from afar; the worst stopped
/// farthest from the goal.
std::vector<ChosenEpisode> choose_episodes(const GalleryRun& gallery,
                                           const tasks::EpisodeSet& episodes, std::size_t each);

/// {"agent", "split", "buildings", "frames", "panoramas", "episodes"}.
nlohmann::ordered_json gallery_part(const GalleryRun& gallery, const tasks::EpisodeSet& episodes,
                                    const std::vector<ChosenEpisode>& chosen,
                                    const dataset::Dataset& data);

}  // namespace enfilade::report::parts
