/// \file  The part of the demo that learns: encoder, features, two agents, table, report.
#pragma once
#include <filesystem>

namespace enfilade::apps {

/// Runs the verbs `pretrain`, `features`, `train` (the panoramic agent), `table` and `report` over
/// a folder of synthetic homes, and prints each command line first. Existing output files that are
/// newer than their inputs stay. A stopped training is continued.
/// \returns the exit code of the first that failed, or 0
int learn_in_homes(const std::filesystem::path& homes, const std::filesystem::path& output);

}  // namespace enfilade::apps
