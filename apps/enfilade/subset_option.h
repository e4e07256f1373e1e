/// \file  `--subset`: which episodes of a split a verb is about.
#pragma once
#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>
#include <vector>

#include "enfilade/tasks/annotations.h"

namespace enfilade::apps {

/// Adds `--subset N|FILE|all`.
void add_subset_option(CLI::App& verb, std::string& subset);

/// The episodes of that option; of an empty one 100, or as many as there are.
/// \throws as arena::spread_subset(), arena::listed_subset()
std::vector<std::size_t> subset_of(const tasks::EpisodeSet& episodes, const std::string& subset);

}  // namespace enfilade::apps
