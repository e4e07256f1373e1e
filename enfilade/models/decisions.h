/// \file  Decision files: how an agent that chooses among viewpoints chose, step by step.
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/models/attention.h"

namespace enfilade::models {

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

/// Reads "<split>.attention.json" of such an agent.
///
///     {instr_id: {"agent", "words": [...], "steps": [...]}}
///
/// A step is {"viewpoint", "heading", "elevation", "attention", "choices", "chosen", "way",
/// "map_share", "nodes", "object"}. Optional are `attention`, `way`, `map_share`, `nodes` and
/// `object`. A choice is {"viewpoint", "probability", "map", "view"}; `map` and `view` are
/// optional, and the viewpoint of stop is null. A node is {"viewpoint", "visited", "stop"}; `stop`
/// is optional. Other fields are ignored.
/// \throws FileError
/// \throws InvalidInput listing its faults (up to 1000) with their JSON paths:
/// - not JSON, fields that are missing or of a wrong type
/// - another number of weights than of words, a probability outside [0, 1.001]
/// - no choice, a chosen one that is not one of the choices
DecisionFile load_decisions(const std::filesystem::path& file);
/// The same for a text; `file` is its name in messages.
DecisionFile parse_decisions(std::string_view json, const std::string& file);

/// Content of "<split>.attention.json".
using RecordedSplit = std::variant<AttentionFile, DecisionFile>;
/// Reads either form: decisions if the first episode names its agent.
/// \throws as load_attention() and load_decisions()
RecordedSplit load_recorded_split(const std::filesystem::path& file);
/// The same for a text; `file` is its name in messages.
RecordedSplit parse_recorded_split(std::string_view json, const std::string& file);

/// The text of such a file, episodes in the order given, by instruction id. Probabilities and
/// weights are rounded to 0.0001, angles to six digits.
std::string decisions_json(std::span<const std::pair<std::string, EpisodeDecisions>> episodes);

}  // namespace enfilade::models
