/// \file  Records an agent's choices on a split, and writes a selection of them.
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/models/decisions.h"
#include "enfilade/models/train_config.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::models {

/// exp(logits) divided by their sum; 0 for minus infinity. \pre one of them is finite
std::vector<float> probabilities(std::span<const float> logits);

/// A Choice as an agent has it.
struct RecordedChoice {
  std::optional<ViewpointIndex> viewpoint = {};  ///< none: stop
  float probability = 0;                         ///< in [0, 1]
  std::optional<float> map = {}, view = {};      ///< of each branch, if it offers the choice
};

/// A MapNode as an agent has it.
struct RecordedNode {
  ViewpointIndex viewpoint;
  bool visited = false;
  std::optional<float> stop = {};  ///< probability of stop when it was last there
};

/// A DecisionStep as an agent has it.
struct RecordedStep {
  ViewpointIndex viewpoint;
  Radians heading, elevation;
  std::vector<float> attention = {};  ///< one weight per word; empty: not recorded
  std::vector<RecordedChoice> choices = {};
  std::size_t chosen = 0;
  std::vector<ViewpointIndex> way = {};  ///< to the chosen one, that one included
  std::optional<float> map_share = {};
  std::vector<RecordedNode> nodes = {};
  std::string object = {};
};

/// By episode of a set. Some 1 kB a step. One thread at a time.
class DecisionRecorder {
 public:
  /// \param episodes how many the set has
  DecisionRecorder(AgentKind agent, std::size_t episodes);

  /// The words of the instruction; before its steps. \pre episode < episodes
  void read(std::size_t episode, std::vector<std::string> words);
  /// Adds the next step of an episode.
  /// \pre episode < episodes; `attention` is empty or has a weight per word; there is a choice, and
  /// `chosen` is one
  void add(std::size_t episode, RecordedStep step);

  std::size_t steps(std::size_t episode) const;  ///< recorded so far. \pre episode < episodes
  /// An episode with the names of its viewpoints. \pre `episodes` are the recorded ones
  EpisodeDecisions episode(std::size_t episode, const tasks::EpisodeSet& episodes) const;
  static constexpr std::size_t kShown = 60;  ///< count for shown_episodes(), as files have them
  /// Writes the file of shown_episodes(). \pre as in episode(); a trajectory an episode
  /// \throws FileError
  void write(const std::filesystem::path& file, const tasks::EpisodeSet& episodes,
             const std::vector<tasks::Trajectory>& trajectories, std::size_t count = kShown) const;

 private:
  struct Episode {
    std::vector<std::string> words;
    std::vector<RecordedStep> steps;
  };
  AgentKind agent_;
  std::vector<Episode> recorded_;
};

/// The episodes of a split that are written with more than a trajectory: the first `count`. If the
/// split can be scored, also a third as many of the best by SPL, and of the worst by navigation
/// error. Among equal SPLs, those with the longest paths come first.
std::set<std::size_t> shown_episodes(const std::vector<tasks::Trajectory>& trajectories,
                                     const tasks::EpisodeSet& episodes, std::size_t count);

}  // namespace enfilade::models
