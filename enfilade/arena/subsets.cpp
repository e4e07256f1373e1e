#include "enfilade/arena/subsets.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <string_view>
#include <tuple>

#include "enfilade/arena/detail/texts.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"

namespace enfilade::arena {

std::vector<std::size_t> spread_subset(const tasks::EpisodeSet& episodes, std::size_t count) {
  const std::size_t all = episodes.episodes.size();
  if (count == 0 || count > all) {
    throw ArgumentError(
        fmt::format("subset of {} episodes: split {} has {}", count, episodes.split, all));
  }
  std::vector<std::size_t> order(all);
  std::iota(order.begin(), order.end(), 0U);
  const auto place = [&episodes](std::size_t e) {
    const tasks::Episode& one = episodes.episodes[e];
    const tasks::ReferencePath& path = episodes.path_of(one);
    // Of hidden goals there is a start only, of length 0.
    return std::tuple(std::string_view(episodes.graphs->graph(path.scan).scan()),
                      path.viewpoints.size(),
                      tasks::length_of(path, episodes.graphs->graph(path.scan)),
                      std::string_view(one.instruction_id));
  };
  std::ranges::sort(order, {}, place);
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(order[(2 * k + 1) * all / (2 * count)]);
  std::ranges::sort(chosen);
  return chosen;
}

std::vector<std::size_t> listed_subset(const tasks::EpisodeSet& episodes,
                                       const std::filesystem::path& file) {
  std::map<std::string_view, std::size_t> by_id;
  for (std::size_t e = 0; e < episodes.episodes.size(); ++e) {
    by_id.emplace(episodes.episodes[e].instruction_id, e);
  }
  const std::string text = read_file(file);
  std::set<std::size_t> chosen;
  std::vector<Diagnostic> faults;
  std::size_t number = 0;
  for (std::size_t at = 0; at < text.size() && faults.size() < kMostFaultsKept;) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view id = detail::trimmed(std::string_view(text).substr(at, end - at));
    at = end + 1;
    ++number;
    if (id.empty() || id.front() == '#') continue;
    const auto refuse = [&](const char* code, const char* what) {
      faults.push_back({Severity::kError, file.string(), fmt::format("line {}", number), code,
                        fmt::format("{:?} {}", id.substr(0, 60), what)});
    };
    const auto found = by_id.find(id);
    if (found == by_id.end()) {
      refuse("unknown-episode", "is no episode of the split");
    } else if (!chosen.insert(found->second).second) {
      refuse("repeated-episode", "is there twice");
    }
  }
  if (faults.empty() && chosen.empty()) {
    faults.push_back({Severity::kError, file.string(), "", "no-episode", "no id in it"});
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return {chosen.begin(), chosen.end()};
}

std::vector<std::size_t> subset_named(const tasks::EpisodeSet& episodes,
                                      const std::string& subset) {
  constexpr std::size_t kUsual = 100, kDigits = 8;
  const std::size_t all = episodes.episodes.size();
  if (subset.empty()) return spread_subset(episodes, std::min(kUsual, all));
  if (subset == "all") {
    std::vector<std::size_t> which(all);
    std::iota(which.begin(), which.end(), 0U);
    return which;
  }
  const bool number = subset.find_first_not_of("0123456789") == std::string::npos;
  if (number && subset.size() < kDigits) return spread_subset(episodes, std::stoul(subset));
  return listed_subset(episodes, subset);
}

double chance_of(std::size_t count) { return 1.96 * std::sqrt(0.25 / static_cast<double>(count)); }

}  // namespace enfilade::arena
