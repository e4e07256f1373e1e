#include "enfilade/service/detail/clock.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <chrono>
#include <ctime>

namespace enfilade::service::detail {

Clock system_clock() {
  return [] {
    return std::chrono::duration_cast<std::chrono::seconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
  };
}

std::string iso_time(std::int64_t seconds) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

}  // namespace enfilade::service::detail
