/// \file  A split of a benchmark, and the trajectories through it, in either world.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks {

/// Size of an episode's path, for choosing a part of a split.
struct PathSize {
  std::string scan;
  std::size_t places = 0;  ///< viewpoints, or points of the reference path; hidden goals: the start
  double length = 0;       ///< metres
};

/// The episodes of a split. Copies share them; any thread.
///
///     const tasks::Split split = data.split(tasks::benchmark("r2r-ce"), "val_unseen");
class Split {
 public:
  /// On graphs. \throws ArgumentError for null
  explicit Split(std::shared_ptr<const EpisodeSet> episodes);
  explicit Split(EpisodeSet episodes)
      : Split(std::make_shared<const EpisodeSet>(std::move(episodes))) {}
  /// In continuous space. \param experts  null: there are none
  /// \throws ArgumentError for null episodes \pre benchmark.continuous()
  Split(const Benchmark& benchmark, std::shared_ptr<const ContinuousEpisodes> episodes,
        std::shared_ptr<const ExpertWalks> experts = {});

  const Benchmark& benchmark() const noexcept { return *benchmark_; }
  const std::string& name() const noexcept;  ///< "val_seen"
  std::size_t size() const noexcept;         ///< episodes
  bool goals_hidden() const noexcept;        ///< of any episode
  /// \name Of an episode \pre episode < size()
  /// @{
  std::string id(std::size_t episode) const;      ///< its instruction id, or its id as text
  PathSize path_size(std::size_t episode) const;  ///< its scan, and its path's places and metres
  /// @}

  /// Null in continuous space.
  const std::shared_ptr<const EpisodeSet>& on_graph() const noexcept { return graph_; }
  /// \name Null on graphs
  /// @{
  const std::shared_ptr<const ContinuousEpisodes>& continuous() const noexcept { return floor_; }
  /// Empty where there are none.
  const std::shared_ptr<const ExpertWalks>& experts() const noexcept { return experts_; }
  /// @}

 private:
  const Benchmark* benchmark_;
  std::shared_ptr<const EpisodeSet> graph_;
  std::shared_ptr<const ContinuousEpisodes> floor_;
  std::shared_ptr<const ExpertWalks> experts_;
};

/// Called before a split is run or scored: means over no episode are no numbers.
/// \param file  of its episodes \throws InvalidInput if the split has none
void require_episodes(const Split& split, const std::string& file);

/// Results of a split of either world, in the order of its episodes.
using Trajectories = std::variant<std::vector<Trajectory>, std::vector<ContinuousResult>>;
std::size_t size(const Trajectories& trajectories) noexcept;

/// Reads a results file of a split. \param warnings  those of Results are added
/// \throws as parse_results(), parse_continuous_results()
Trajectories parse_trajectories(std::string_view text, const std::string& file, const Split& split,
                                Coverage coverage = Coverage::kAll,
                                std::vector<Diagnostic>* warnings = nullptr);
/// \throws as above; FileError
Trajectories load_trajectories(const std::filesystem::path& file, const Split& split,
                               Coverage coverage = Coverage::kAll);
/// The episodes that have a trajectory, as part_of(const EpisodeSet&, ...); in continuous space the
/// split itself, of which any part can be scored.
Split part_of(const Split& split, Trajectories& trajectories);
/// The text of a results file, in the benchmark's form. \throws as the functions of each world
std::string to_json(const Trajectories& trajectories, const Split& split);

}  // namespace enfilade::tasks
