/// \file  Walking through all episodes of a split, batch by batch.
#pragma once
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/packing.h"
#include "enfilade/neural/ranks.h"

namespace enfilade::neural::core {

/// Calls body(indices) for 0 .. total - 1 in their order, `batch_size` at a time; the last are
/// fewer. \throws ArgumentError for a batch_size of 0
template <class Body>
void for_each_batch(std::size_t total, std::size_t batch_size, const Body& body) {
  if (batch_size == 0) throw ArgumentError("batch size 0: at least 1 is needed");
  std::vector<std::size_t> indices;
  for (std::size_t first = 0; first < total; first += batch_size) {
    indices.resize(std::min(batch_size, total - first));
    std::iota(indices.begin(), indices.end(), first);
    body(std::span<const std::size_t>(indices));
  }
}

/// As for_each_batch(), where each process does every size()-th batch, beginning with that of its
/// rank.
/// \return the results of body() for all batches, as bytes, in their order, in all processes
/// \throws LostRank
template <class Body>
std::vector<std::string> share_batches(Ranks& ranks, std::size_t total, std::size_t batch_size,
                                       const Body& body) {
  const auto size = static_cast<std::size_t>(ranks.size());
  std::vector<std::string> own;
  std::size_t batches = 0;
  for_each_batch(total, batch_size, [&](std::span<const std::size_t> indices) {
    if (batches++ % size == static_cast<std::size_t>(ranks.rank())) own.push_back(body(indices));
  });
  if (ranks.alone()) return own;
  std::vector<std::vector<std::string>> by_rank;
  for (const std::string& bytes : ranks.gather(packed(own))) {
    by_rank.push_back(unpacked<std::vector<std::string>>(bytes));
  }
  std::vector<std::string> all;
  for (std::size_t k = 0; k < batches; ++k) all.push_back(std::move(by_rank[k % size][k / size]));
  return all;
}

/// The sum of a number a batch, added in the order of the batches.
template <class Body>
double sum_of_batches(Ranks& ranks, std::size_t total, std::size_t batch_size, const Body& body) {
  double sum = 0;
  for (const std::string& one : share_batches(
           ranks, total, batch_size,
           [&](std::span<const std::size_t> indices) { return packed(double{body(indices)}); })) {
    sum += unpacked<double>(one);
  }
  return sum;
}

}  // namespace enfilade::neural::core
