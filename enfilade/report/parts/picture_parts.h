/// \file  The parts of the page that show buildings: examples, panoramas, floor plans.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/r2r/annotations.h"
#include "enfilade/report/scored_runs.h"

namespace enfilade::report::parts {

/// A few paths of a split at random, each with its instructions and the view from its start.
/// `splits`: whole files; val_unseen is taken if it is there.
nlohmann::ordered_json examples_part(const std::vector<r2r::Annotations>& splits,
                                     const dataset::Dataset& data, std::size_t count);

/// The panorama of each building's viewpoint with most neighbours, of at most `most` buildings,
/// spread evenly over the list.
nlohmann::ordered_json panoramas_part(const dataset::Dataset& data, std::size_t most);

/// An episode of the page's gallery.
struct ChosenEpisode {
  std::string kind;         ///< "best", "worst", "random"
  std::size_t episode = 0;  ///< of the split
};

/// Floor plans with the reference path and the agent's, of these episodes of a run.
nlohmann::ordered_json plans_part(const ScoredRun& run, const r2r::EpisodeSet& episodes,
                                  const std::vector<ChosenEpisode>& chosen);

}  // namespace enfilade::report::parts
