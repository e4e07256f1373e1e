/// \file  What agents record of a split at every step. Attention files: the attention to the
/// instruction. Decision files: the probabilities of the viewpoints.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/models/train_config.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::models {

// --- attention ---

/// The state before one action.
struct AttentionStep {
  std::string action;                 ///< that was then taken: "forward", "end"
  std::vector<double> attention;      ///< one weight per word, in [0, 1]
  std::string viewpoint;              ///< where the agent was
  double heading = 0, elevation = 0;  ///< radians
};

/// One episode.
struct EpisodeAttention {
  std::vector<std::string> words;  ///< in reading order
  std::vector<AttentionStep> steps;
};

/// By instruction id.
using AttentionFile = std::map<std::string, EpisodeAttention>;

// --- decisions ---

/// One possible action of an agent.
struct Choice {
  std::string viewpoint;            ///< its target; empty: stop
  double probability = 0;           ///< in [0, 1]
  std::optional<double> map = {};   ///< the probability by the map alone; only for agents with a
                                    ///< map
  std::optional<double> view = {};  ///< by the views alone; no value for targets out of view
};

/// A viewpoint on the agent's map.
struct MapNode {
  std::string viewpoint;
  bool visited = false;             ///< or only seen
  std::optional<double> stop = {};  ///< probability of stop when it was last there
};

/// The state before one choice.
struct DecisionStep {
  std::string viewpoint;              ///< where the agent is
  double heading = 0, elevation = 0;  ///< radians, of its view
  std::vector<double> attention;      ///< one weight per word, in [0, 1]; empty: not recorded
  std::vector<Choice> choices;        ///< at least one
  std::size_t chosen = 0;             ///< index into `choices`
  /// Viewpoints on the way to the chosen one, that one included; empty: not recorded, or it stays.
  std::vector<std::string> way;
  std::optional<double> map_share;  ///< weight of the map in the common score, in [0, 1]
  std::vector<MapNode> nodes;       ///< the map so far; empty for an agent without one
  std::string object;               ///< the one that it would answer here; empty: none
};

/// One episode.
struct EpisodeDecisions {
  std::string agent;               ///< kind: "panoramic", "duet"
  std::vector<std::string> words;  ///< in reading order, as the agent has them
  std::vector<DecisionStep> steps;
};

/// By instruction id.
using DecisionFile = std::map<std::string, EpisodeDecisions>;

// --- files ---

/// Reads "<split>.attention.json" of such an agent.
///
///     {instr_id: {"agent", "words": [...], "steps": [...]}}
///
/// A step is {"viewpoint", "heading", "elevation", "attention", "choices", "chosen", "way",
/// "map_share", "nodes", "object"}. Optional are `attention`, `way`, `map_share`, `nodes` and
/// `object`. A choice is {"viewpoint", "probability", "map", "view"}; `map` and `view` are
/// optional, and the viewpoint of stop is null. A node is {"viewpoint", "visited", "stop"}; `stop`
/// is optional. Other fields are ignored.
/// \param file its name in messages
/// \throws InvalidInput listing its faults (up to 1000) with their JSON paths:
/// - not JSON, fields that are missing or of a wrong type, invalid ids (core/names.h)
/// - another number of weights than of words, a probability outside [0, 1.001]
/// - no choice, a chosen one that is not one of the choices
DecisionFile parse_decisions(std::string_view json, const std::string& file);

/// Content of "<split>.attention.json" in either form.
using RecordedSplit = std::variant<AttentionFile, DecisionFile>;
/// Reads decisions if the first episode names its agent, else attention.
///
///     {instr_id: {"words": [...], "steps": [{"action", "attention", "viewpoint", "heading",
///                                            "elevation"}]}}
///
/// \throws FileError; InvalidInput as parse_decisions(), without those of choices
RecordedSplit load_recorded_split(const std::filesystem::path& file);
/// The same for a text; `file` is its name in messages.
RecordedSplit parse_recorded_split(std::string_view json, const std::string& file);

/// The text of an attention file, episodes in the order given, by instruction id. Weights are
/// written with four digits after the point, angles with six digits.
std::string attention_json(std::span<const std::pair<std::string, EpisodeAttention>> episodes);
/// The text of a decision file, likewise. Probabilities and weights
/// are rounded to 0.0001, angles to six digits.
std::string decisions_json(std::span<const std::pair<std::string, EpisodeDecisions>> episodes);

// --- recording ---

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

  /// An episode with the names of its viewpoints. \pre `episodes` are the recorded ones
  EpisodeDecisions episode(std::size_t episode, const tasks::EpisodeSet& episodes) const;
  static constexpr std::size_t kShown = 60;  ///< count for shown_episodes(), as files have them
  /// decisions_json() of shown_episodes(). \pre as in episode(); a trajectory an episode
  std::string text(const tasks::EpisodeSet& episodes,
                   const std::vector<tasks::Trajectory>& trajectories,
                   std::size_t count = kShown) const;

 private:
  struct RecordedSteps {
    std::vector<std::string> words;
    std::vector<RecordedStep> steps;
  };
  AgentKind agent_;
  std::vector<RecordedSteps> recorded_;
};

/// The episodes of a split that are written with more than a trajectory: the first `count`. If the
/// split can be scored, also a third as many of the best by SPL, and of the worst by navigation
/// error. Among equal SPLs, those with the longest paths come first.
std::set<std::size_t> shown_episodes(const std::vector<tasks::Trajectory>& trajectories,
                                     const tasks::EpisodeSet& episodes, std::size_t count);

}  // namespace enfilade::models
