/// \file  The clock of the service.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

namespace enfilade::service::detail {

/// Seconds since 1970, UTC. Tests bring a clock of their own.
using Clock = std::function<std::int64_t()>;
Clock system_clock();

/// "2026-11-21T16:15:09Z"
std::string iso_time(std::int64_t seconds);

}  // namespace enfilade::service::detail
