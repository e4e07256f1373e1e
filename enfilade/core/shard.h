/// \file  One share of a job that several machines divide.
#pragma once
#include <cstddef>

namespace enfilade {

/// Share `index` of `count`: the items index, index + count, index + 2 count, ... Everything counts
/// from 0. \pre index < count
struct Shard {
  std::size_t index = 0;
  std::size_t count = 1;  ///< 1: the whole job
};

}  // namespace enfilade
