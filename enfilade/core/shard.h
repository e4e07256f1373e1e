/// \file  A share of a job.
#pragma once
#include <cstddef>

namespace enfilade {

/// The share that one of several machines does: of `count` shares, the items `index`, `index` +
/// `count`, ..., all from 0. \pre index < count
struct Shard {
  std::size_t index = 0;
  std::size_t count = 1;  ///< 1: the whole job
};

}  // namespace enfilade
