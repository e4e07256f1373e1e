#include "enfilade/core/nearest_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace enfilade {
namespace {

// Changes from one text to the other, none of which touches what another has changed.
std::size_t changes(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] =
          std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

std::vector<std::string_view> nearest_names(std::string_view text,
                                            std::span<const std::string_view> names) {
  std::vector<std::string_view> nearest;
  std::size_t fewest = text.size() + 1;
  for (const std::string_view name : names) {
    const std::size_t most = std::max<std::size_t>(1, name.size() / 3);
    const std::size_t longer = std::max(text.size(), name.size());
    // Each change adds or removes a byte at most; so foreign texts of any length cost nothing.
    if (longer - std::min(text.size(), name.size()) > most) continue;
    const std::size_t needed = changes(name, text);
    if (needed > most || needed > fewest) continue;
    if (needed < fewest) nearest.clear();
    fewest = needed;
    nearest.push_back(name);
  }
  return nearest;
}

std::string advice_on_name(std::string_view text, std::span<const std::string_view> names) {
  const std::vector<std::string_view> nearest = nearest_names(text, names);
  if (nearest.empty()) return fmt::format("allowed are {}", fmt::join(names, ", "));
  return fmt::format("the nearest {} \"{}\"", nearest.size() == 1 ? "is" : "are",
                     fmt::join(nearest, "\", \""));
}

}  // namespace enfilade
