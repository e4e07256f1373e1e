/// \file  How long work tells its caller how far it is.
#pragma once
#include <cstddef>
#include <functional>

namespace enfilade {

/// Called with (done, total) now and then during long work, from one thread at a time, `done`
/// never falling; (total, total) comes last. May be empty. An exception from it ends the work.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

}  // namespace enfilade
