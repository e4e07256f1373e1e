/// \file  Which episodes of a split a session verb is about, and how long each may be.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "enfilade/arena/world.h"

namespace enfilade::apps {

/// Adds `--subset N|FILE|all`, which arena::subset_named() reads.
void add_subset_option(CLI::App& verb, std::string& subset);
/// Adds `--steps N`; 0: as the benchmark has it.
void add_steps_option(CLI::App& verb, std::uint32_t& steps);
/// The limits that it gives.
arena::Limits limits_of(const arena::World& world, std::uint32_t steps);

}  // namespace enfilade::apps
