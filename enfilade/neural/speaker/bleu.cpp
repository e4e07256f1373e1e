#include "enfilade/neural/speaker/bleu.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace enfilade::neural::speaker {
namespace {

constexpr std::size_t kOrders = 4;

using Words = std::span<const std::string>;
using NgramCounts = std::map<std::vector<std::string>, std::size_t>;

NgramCounts count_ngrams(Words words, std::size_t order) {
  NgramCounts counts;
  for (std::size_t i = 0; i + order <= words.size(); ++i) {
    const Words ngram = words.subspan(i, order);
    ++counts[{ngram.begin(), ngram.end()}];
  }
  return counts;
}

std::size_t count_matches(const Generated& one, std::size_t order) {
  NgramCounts most;
  for (const auto& reference : one.references) {
    for (const auto& [ngram, count] : count_ngrams(reference, order)) {
      most[ngram] = std::max(most[ngram], count);
    }
  }
  std::size_t matches = 0;
  for (const auto& [ngram, count] : count_ngrams(one.words, order)) {
    const auto found = most.find(ngram);
    if (found != most.end()) matches += std::min(count, found->second);
  }
  return matches;
}

}  // namespace

double bleu_4(std::span<const Generated> corpus) {
  std::array<std::size_t, kOrders> matches{}, possible{};
  std::size_t written = 0, meant = 0;
  for (const Generated& one : corpus) {
    written += one.words.size();
    std::size_t shortest = one.references.front().size();
    for (const auto& reference : one.references) {
      shortest = std::min(shortest, reference.size());
    }
    meant += shortest;
    for (std::size_t n = 0; n < kOrders; ++n) {
      matches[n] += count_matches(one, n + 1);
      if (one.words.size() > n) possible[n] += one.words.size() - n;
    }
  }
  double logs = 0;
  for (std::size_t n = 0; n < kOrders; ++n) {
    if (matches[n] == 0) return 0;
    logs += std::log(static_cast<double>(matches[n]) / static_cast<double>(possible[n])) / kOrders;
  }
  const double ratio = static_cast<double>(written) / static_cast<double>(meant);
  return std::exp(logs + (ratio > 1 ? 0 : 1 - 1 / ratio));
}

}  // namespace enfilade::neural::speaker
