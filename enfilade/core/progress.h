/// \file  Callback that reports progress of long work.
#pragma once
#include <cstddef>
#include <functional>

namespace enfilade {

/// Called with (done, total) from time to time, by one thread at a time. `done` never decreases;
/// the last call is (total, total). May be empty. An exception from it ends the work.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

}  // namespace enfilade
