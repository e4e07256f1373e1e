/// \file  Parts of a split that are worth walking where each step costs money.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/arena/world.h"

namespace enfilade::arena {

/// `count` episodes of a split, spread evenly over its buildings and, in each, over the lengths of
/// the paths: in the order of scan, length and instruction id, one from the middle of each of
/// `count` equal parts. No random number has a part in it, so everybody's "216" is the same.
/// \returns indices, ascending \throws ArgumentError for 0 or more than there are
std::vector<std::size_t> spread_subset(const World& world, std::size_t count);

/// Those of a file with an instruction id a line, in the order of the split.
/// \throws FileError; InvalidInput naming the lines of ids that the split does not have, or that
/// are there twice
std::vector<std::size_t> listed_subset(const World& world, const std::filesystem::path& file);

/// What users write: a number as spread_subset(); "all"; empty: 100, or as many as there are; else
/// a file as listed_subset(). \throws as these
std::vector<std::size_t> subset_named(const World& world, const std::string& subset);

/// How far a share of so many episodes may be from the truth by chance: half of the 95 % interval
/// of a binomial at one half, 1.96 sqrt(1 / 4n). 0.067 of 216. \pre count > 0
double chance_of(std::size_t count);

}  // namespace enfilade::arena
