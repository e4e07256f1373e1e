#include "enfilade/arena/subsets.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <string_view>
#include <tuple>

#include "enfilade/arena/detail/texts.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"

namespace enfilade::arena {

std::vector<std::size_t> spread_subset(const World& world, std::size_t count) {
  const std::size_t all = world.size();
  if (count == 0 || count > all) {
    throw ArgumentError(
        fmt::format("subset of {} episodes: split {} has {}", count, world.split(), all));
  }
  std::vector<std::size_t> order(all);
  std::iota(order.begin(), order.end(), 0U);
  std::vector<std::tuple<std::string, std::size_t, double, std::string>> keys;
  for (std::size_t e = 0; e < all; ++e) {
    PathSize size = world.path_size(e);
    keys.emplace_back(std::move(size.scan), size.places, size.length, world.episode_id(e));
  }
  std::ranges::sort(order, {}, [&keys](std::size_t e) -> const auto& { return keys[e]; });
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(order[(2 * k + 1) * all / (2 * count)]);
  std::ranges::sort(chosen);
  return chosen;
}

std::vector<std::size_t> listed_subset(const World& world, const std::filesystem::path& file) {
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
    const auto found = world.find(id);
    if (!found) {
      refuse("unknown-episode", "is no episode of the split");
    } else if (!chosen.insert(*found).second) {
      refuse("repeated-episode", "is there twice");
    }
  }
  if (faults.empty() && chosen.empty()) {
    faults.push_back({Severity::kError, file.string(), "", "no-episode", "no id in it"});
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return {chosen.begin(), chosen.end()};
}

std::vector<std::size_t> subset_named(const World& world, const std::string& subset) {
  constexpr std::size_t kUsual = 100, kDigits = 8;
  const std::size_t all = world.size();
  if (subset.empty()) return spread_subset(world, std::min(kUsual, all));
  if (subset == "all") {
    std::vector<std::size_t> which(all);
    std::iota(which.begin(), which.end(), 0U);
    return which;
  }
  const bool number = subset.find_first_not_of("0123456789") == std::string::npos;
  if (number && subset.size() < kDigits) return spread_subset(world, std::stoul(subset));
  return listed_subset(world, subset);
}

double chance_of(std::size_t count) { return 1.96 * std::sqrt(0.25 / static_cast<double>(count)); }

}  // namespace enfilade::arena
