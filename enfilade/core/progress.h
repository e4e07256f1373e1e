/// \file  Long work: its progress, and its shares on several machines.
#pragma once
#include <cstddef>
#include <functional>

namespace enfilade {

/// Called with (done, total) from time to time, by one thread at a time. `done` never decreases;
/// the last call is (total, total). May be empty. An exception from it ends the work.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

/// Share `index` of `count`: the items index, index + count, index + 2 count, ... Everything counts
/// from 0. \pre index < count
struct Shard {
  std::size_t index = 0;
  std::size_t count = 1;  ///< 1: the whole job
};

}  // namespace enfilade
