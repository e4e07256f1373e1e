/// \file  Parts of a split for evaluations in which each step costs money.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/arena/world.h"

namespace enfilade::arena {

/// `count` episodes of a split, spread evenly over its buildings and, in each, over the lengths of
/// the paths. In the order of scan, length and instruction id, it takes one from the middle of each
/// of `count` equal parts. No random number is involved, so "216" always means the same subset.
/// \returns indices, ascending
/// \throws ArgumentError for 0 or more than the number of episodes
std::vector<std::size_t> spread_subset(const World& world, std::size_t count);

/// Those of a file with an instruction id a line, in the order of the split.
/// \throws FileError; InvalidInput naming the lines of ids that the split does not have, or that
/// are there twice
std::vector<std::size_t> listed_subset(const World& world, const std::filesystem::path& file);

/// A user's choice: a number as spread_subset(); "all"; empty: 100, or all if there are fewer; else
/// a file as listed_subset().
/// \throws as these
std::vector<std::size_t> subset_named(const World& world, const std::string& subset);

/// Uncertainty of a share of `count` episodes: half of the 95 % interval of a binomial at one half,
/// 1.96 sqrt(1 / 4n). For example 0.067 for 216.
/// \pre count > 0
double chance_of(std::size_t count);

}  // namespace enfilade::arena
