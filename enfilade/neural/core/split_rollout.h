/// \file  Trajectories of an agent that chooses among viewpoints on a whole split, and their files.
#pragma once
#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/core/progress.h"
#include "enfilade/models/decision_recorder.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/results.h"

namespace enfilade::neural::core {

/// Trajectories as bytes for other processes.
std::string packed_trajectories(std::span<const tasks::Trajectory> trajectories);
/// Those of batches, one behind the other.
std::vector<tasks::Trajectory> unpacked_trajectories(std::span<const std::string> batches);

/// Rank 0 writes the decisions of the episodes that are shown; each process has recorded those that
/// it walked. \throws FileError; LostRank
void write_decisions(Ranks& ranks, const SplitRollout& options,
                     const models::DecisionRecorder& recorder, const tasks::EpisodeSet& episodes,
                     const std::vector<tasks::Trajectory>& trajectories);

/// Runs all episodes of a split by the kind's rollout_episodes(), and writes the files that
/// `options` names.
/// \tparam Recording  of how the kind chooses: made of a split, with observer() and recorder()
/// \return a trajectory per episode, in order
/// \throws FileError; ArgumentError for a batch size of 0
template <class Recording, class Network, class Split>
std::vector<tasks::Trajectory> rollout_and_write(Network& network, Split& split,
                                                 const SplitRollout& options,
                                                 const Progress& progress) {
  Ranks alone;
  Ranks& ranks = options.ranks != nullptr ? *options.ranks : alone;
  const tasks::EpisodeSet& set = split.episodes();
  const std::size_t total = set.episodes.size();
  std::optional<Recording> recording;
  if (!options.attention.empty()) recording.emplace(split);
  std::size_t walked = 0;
  std::vector<std::string> batches =
      share_batches(ranks, total, options.batch_size, [&](std::span<const std::size_t> episodes) {
        decltype(recording->observer(episodes)) observer;
        if (recording) observer = recording->observer(episodes);
        walked += episodes.size();
        const auto trajectories = rollout_episodes(network, split, episodes, observer);
        if (progress) {
          progress(std::min(total, walked * static_cast<std::size_t>(ranks.size())), total);
        }
        return packed_trajectories(trajectories);
      });
  std::vector<tasks::Trajectory> trajectories = unpacked_trajectories(batches);
  if (!options.results.empty() && ranks.is_first()) {
    make_folder(options.results.parent_path());
    write_file_atomically(options.results, to_json(trajectories, set));
  }
  if (recording) {
    write_decisions(ranks, options, recording->recorder(), set, trajectories);
  }
  return trajectories;
}

}  // namespace enfilade::neural::core
