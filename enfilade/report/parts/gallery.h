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

/// One run, and what is recorded of it beside its trajectories.
struct RunRecord {
  const ScoredRun* run = nullptr;
  std::optional<models::RecordedSplit> recorded;
};

/// What the gallery is about.
struct GalleryRun : RunRecord {
  std::string no_attention;  ///< a sentence: why there is nothing recorded
  /// To be seen beside it, if it or any of them chooses among viewpoints: other models on the same
  /// split of which something is recorded.
  std::vector<RunRecord> others;

  bool shows_decisions() const;  ///< whether any chooses among viewpoints
};

/// The run that most is to be seen of: of a model rather than of an agent that learns nothing (of
/// one that chooses among viewpoints, of these the one that arrives most often; then of
/// student-forcing rather than another), on val_unseen rather than another split. None if there is
/// no run. \throws as load_recorded_split()
std::optional<GalleryRun> choose_run(const ScoredRuns& runs, const RunDirectory& found);

/// `each` of the best (arrived, by the shortest way, from afar), of the worst (stopped farthest
/// from the goal) and at random; of each path once. Of those with something recorded, if there
/// are any.
std::vector<ChosenEpisode> choose_episodes(const GalleryRun& gallery,
                                           const tasks::EpisodeSet& episodes, std::size_t each);

/// {"agent", "split", "buildings", "frames", "panoramas", "episodes"}.
nlohmann::ordered_json gallery_part(const GalleryRun& gallery, const tasks::EpisodeSet& episodes,
                                    const std::vector<ChosenEpisode>& chosen,
                                    const dataset::Dataset& data);

}  // namespace enfilade::report::parts
