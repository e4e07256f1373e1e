/// \file  `--subset`: which episodes of a split a verb is about.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace enfilade::apps {

/// Adds `--subset N|FILE|all`, which arena::subset_named() reads.
void add_subset_option(CLI::App& verb, std::string& subset);

}  // namespace enfilade::apps
