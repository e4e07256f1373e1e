/// \file  Walking a whole split with an agent that chooses among viewpoints, and what is written of
/// it.
#pragma once
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/core/progress.h"
#include "enfilade/neural/detail/batches.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/results.h"

namespace enfilade::neural::detail {

/// Walks all episodes of a split by the kind's walk_episodes(), and writes the files that `options`
/// names. \tparam Recording of how the kind chooses: made of a split, with observer() and
/// recorder() \return a trajectory per episode, in order \throws FileError; ArgumentError for a
/// batch size of 0
template <class Recording, class Network, class Split>
std::vector<tasks::Trajectory> walk_and_write(Network& network, Split& split,
                                              const SplitWalk& options, const Progress& progress) {
  const std::size_t total = split.episodes().episodes.size();
  std::vector<tasks::Trajectory> trajectories;
  std::optional<Recording> recording;
  if (!options.attention.empty()) recording.emplace(split);
  for_each_batch(total, options.batch_size, [&](std::span<const std::size_t> episodes) {
    decltype(recording->observer(episodes)) observer;
    if (recording) observer = recording->observer(episodes);
    for (tasks::Trajectory& one : walk_episodes(network, split, episodes, observer)) {
      trajectories.push_back(std::move(one));
    }
    if (progress) progress(trajectories.size(), total);
  });
  if (!options.results.empty()) {
    make_folder(options.results.parent_path());
    write_file_atomically(options.results, to_json(trajectories, split.episodes()));
  }
  if (recording) recording->recorder().write(options.attention, split.episodes(), trajectories);
  return trajectories;
}

}  // namespace enfilade::neural::detail
