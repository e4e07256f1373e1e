#include "apps/enfilade/subset_option.h"

#include <algorithm>
#include <numeric>

#include "apps/common/program.h"
#include "enfilade/arena/subsets.h"

namespace enfilade::apps {

void add_subset_option(CLI::App& verb, std::string& subset) {
  add_value(verb, "--subset", subset, "N|FILE|all",
            "N episodes, spread over buildings and lengths (papers: 100, 216, 1000; default: 100, "
            "or as many as there are); or a file with an instruction id a line; or all");
}

std::vector<std::size_t> subset_of(const tasks::EpisodeSet& episodes, const std::string& subset) {
  constexpr std::size_t kUsual = 100, kDigits = 8;
  const std::size_t all = episodes.episodes.size();
  if (subset.empty()) return arena::spread_subset(episodes, std::min(kUsual, all));
  if (subset == "all") {
    std::vector<std::size_t> which(all);
    std::iota(which.begin(), which.end(), 0U);
    return which;
  }
  const bool number = subset.find_first_not_of("0123456789") == std::string::npos;
  if (number && subset.size() < kDigits) return arena::spread_subset(episodes, std::stoul(subset));
  return arena::listed_subset(episodes, subset);
}

}  // namespace enfilade::apps
