/// \file  The part of the demo that learns: encoder, features, two agents, table, report.
#pragma once
#include <filesystem>

namespace enfilade::apps {

/// Runs the verbs `pretrain`, `features`, `train` (the panoramic agent), `table`
/// and `report` over a folder of model homes, as a person would type them, and prints each line
/// first. What an earlier demo left in `output` and is newer than what it was made of stays;
/// training that was stopped goes on. \returns the exit code of the first that failed, or 0
int learn_in_homes(const std::filesystem::path& homes, const std::filesystem::path& output);

}  // namespace enfilade::apps
