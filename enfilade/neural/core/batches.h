/// \file  Walking through all episodes of a split, batch by batch.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/progress.h"
#include "enfilade/models/decisions.h"
#include "enfilade/neural/core/packing.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/results.h"

namespace enfilade::neural::core {

/// Calls body(indices) for 0 .. total - 1 in their order, `batch_size` at a time; the last are
/// fewer. Each process does every size()-th batch, beginning with that of its rank.
/// \return the results of body() for all batches, as bytes, in their order, in all processes
/// \throws ArgumentError for a batch_size of 0; LostRank
template <class Body>
std::vector<std::string> share_batches(Ranks& ranks, std::size_t total, std::size_t batch_size,
                                       const Body& body) {
  if (batch_size == 0) throw ArgumentError("batch size 0: at least 1 is needed");
  const auto size = static_cast<std::size_t>(ranks.size());
  std::vector<std::string> own;
  std::vector<std::size_t> indices;
  std::size_t batches = 0;
  for (std::size_t first = 0; first < total; first += batch_size) {
    if (batches++ % size != static_cast<std::size_t>(ranks.rank())) continue;
    indices.resize(std::min(batch_size, total - first));
    std::iota(indices.begin(), indices.end(), first);
    own.push_back(body(std::span<const std::size_t>(indices)));
  }
  if (ranks.alone()) return own;
  std::vector<std::vector<std::string>> by_rank;
  for (const std::string& bytes : ranks.gather(packed(own))) {
    by_rank.push_back(unpacked<std::vector<std::string>>(bytes));
  }
  std::vector<std::string> all;
  for (std::size_t k = 0; k < batches; ++k) all.push_back(std::move(by_rank[k % size][k / size]));
  return all;
}

/// The mean over episodes, by the sum over each batch.
template <class Body>
double mean_of_batches(Ranks& ranks, std::size_t total, std::size_t batch_size, const Body& body) {
  double sum = 0;
  for (const std::string& one : share_batches(
           ranks, total, batch_size,
           [&](std::span<const std::size_t> indices) { return packed(double{body(indices)}); })) {
    sum += unpacked<double>(one);
  }
  return sum / static_cast<double>(total);
}

/// Consecutive batches from repeated passes over n episodes, each pass shuffled. A batch may
/// contain the end of one pass and the beginning of the next. Pass p is shuffled by (seed, p). So a
/// batch is a function of the iteration, and a checkpoint need not store an order.
class EpisodeOrder {
 public:
  /// \pre episodes, batch_size > 0
  EpisodeOrder(std::size_t episodes, std::size_t batch_size, std::uint64_t seed);
  /// The batch of an iteration, counted from 0; valid until the next call.
  std::span<const std::size_t> batch(std::uint64_t iteration);

 private:
  void shuffle(std::uint64_t pass);

  std::uint64_t seed_;
  std::uint64_t pass_ = 0;  // that order_ is of
  std::vector<std::size_t> order_, batch_;
};

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
    options.write(options.results, to_json(trajectories, set));
  }
  if (recording) {
    write_decisions(ranks, options, recording->recorder(), set, trajectories);
  }
  return trajectories;
}

}  // namespace enfilade::neural::core
