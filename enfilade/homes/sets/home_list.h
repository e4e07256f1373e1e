/// \file  `homes.json`: the list of a folder of synthetic homes.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/homes/home_set.h"

namespace enfilade::homes::sets {

struct HomeList {
  HomeSetOptions options;  ///< `threads` is not kept
  std::vector<HomeEntry> homes;
};

std::string to_json(const HomeList& list);
/// \throws InvalidInput
HomeList parse_home_list(std::string_view json, const std::string& file);

/// The first option that differs, as text with both values; empty if none does.
std::string difference(const HomeSetOptions& a, const HomeSetOptions& b);

}  // namespace enfilade::homes::sets
