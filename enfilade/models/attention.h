/// \file  Attention files: an agent's attention to its instruction, step by step.
#pragma once
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace enfilade::models {

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

/// Reads "<split>.attention.json" of a model directory: {instr_id: {"words": [...], "steps":
/// [{"action", "attention", "viewpoint", "heading", "elevation"}]}}; other fields are ignored.
/// \throws FileError
/// \throws InvalidInput listing its faults (up to 1000) with their JSON paths:
/// - not JSON, fields that are missing or of a wrong type
/// - another number of weights than of words, a weight outside [0, 1.001]
AttentionFile load_attention(const std::filesystem::path& file);
/// The same for a text; `file` is its name in messages.
AttentionFile parse_attention(std::string_view json, const std::string& file);

/// The text of such a file, episodes in the order given, by instruction id. Weights are written
/// with four digits after the point, angles with six digits.
std::string attention_json(std::span<const std::pair<std::string, EpisodeAttention>> episodes);

}  // namespace enfilade::models
