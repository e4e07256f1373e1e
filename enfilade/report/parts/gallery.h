/// \file  The page's gallery: some episodes of one run, step by step.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/models/attention.h"
#include "enfilade/report/parts/picture_parts.h"
#include "enfilade/report/scored_runs.h"

namespace enfilade::report::parts {

/// What the gallery is about.
struct GalleryRun {
  const ScoredRun* run = nullptr;
  std::optional<models::AttentionFile> attention;
  std::string no_attention;  ///< a sentence: why there is none
};

/// The run that most is to be seen of: of a model rather than of an agent that learns nothing (of
/// student-forcing rather than another), on val_unseen rather than another split. None if there is
/// no run. \throws as load_attention()
std::optional<GalleryRun> choose_run(const ScoredRuns& runs, const RunDirectory& found);

/// `each` of the best (arrived, by the shortest way, from afar), of the worst (stopped farthest
/// from the goal) and at random; of each path once. Of those with attention, if any has.
std::vector<ChosenEpisode> choose_episodes(const GalleryRun& gallery,
                                           const tasks::EpisodeSet& episodes, std::size_t each);

/// {"agent", "split", "buildings", "frames", "episodes"}.
nlohmann::ordered_json gallery_part(const GalleryRun& gallery, const tasks::EpisodeSet& episodes,
                                    const std::vector<ChosenEpisode>& chosen,
                                    const dataset::Dataset& data);

}  // namespace enfilade::report::parts
