/// \file  Walking through all episodes of a split, batch by batch.
#pragma once
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::neural::detail {

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

}  // namespace enfilade::neural::detail
