/// \file  What an agent looked at in its instruction, step by step.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::report {

/// Before one action.
struct AttentionStep {
  std::string action;                 ///< that was taken then: "forward", "end"
  std::vector<double> attention;      ///< a weight a word, in [0, 1]
  std::string viewpoint;              ///< where the agent stood
  double heading = 0, elevation = 0;  ///< radians
};

/// Of one episode.
struct EpisodeAttention {
  std::vector<std::string> words;  ///< in reading order
  std::vector<AttentionStep> steps;
};

/// By instruction id.
using AttentionFile = std::map<std::string, EpisodeAttention>;

/// Reads "<split>.attention.json" of a model directory: {instr_id: {"words": [...], "steps":
/// [{"action", "attention", "viewpoint", "heading", "elevation"}]}}; other fields are ignored.
/// \throws FileError; InvalidInput listing every fault with its JSON path: not JSON, missing or
/// wrongly typed fields, as many weights as words not given, a weight outside [0, 1.001]
AttentionFile load_attention(const std::filesystem::path& file);
AttentionFile parse_attention(std::string_view json, const std::string& file);

}  // namespace enfilade::report
