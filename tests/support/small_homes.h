/// \file  Model homes small enough to make within a test.
#pragma once
#include <cstddef>
#include <filesystem>

#include "enfilade/homes/home_set.h"

namespace enfilade::tests {

/// Homes without pictures, 24 to 34 viewpoints each, with at most 30 paths a home; \p homes is 3 or
/// more. Takes about 0.3 s a home.
inline void write_small_homes(const std::filesystem::path& folder, std::size_t homes = 3) {
  homes::HomeSetOptions options = homes::home_set_preset("graphs");
  options.homes = homes;
  homes::write_homes(folder, options);
  homes::write_home_paths(folder, {.per_home = 30});
}

}  // namespace enfilade::tests
