#include "enfilade/service/http/metrics.h"

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <fstream>
#include <iterator>

namespace enfilade::service::http {

void Metrics::count(std::string_view route, int status, double seconds) {
  const std::scoped_lock lock(mutex_);
  ++counts_[{std::string(route), status}];
  Times& times = times_[std::string(route)];
  const auto bound = std::ranges::lower_bound(kBounds, seconds);
  ++times.buckets[static_cast<std::size_t>(bound - kBounds.begin())];
  times.sum += seconds;
}

std::string Metrics::text(const std::map<std::string, double>& gauges) const {
  std::string out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "# TYPE enfilade_requests_in_flight gauge\nenfilade_requests_in_flight {}\n",
                 in_flight_.load());
  for (const auto& [name, value] : gauges) {
    fmt::format_to(to, "# TYPE {} gauge\n{} {}\n", name, name, value);
  }
  const std::scoped_lock lock(mutex_);
  fmt::format_to(to, "# TYPE enfilade_requests_total counter\n");
  for (const auto& [key, count] : counts_) {
    fmt::format_to(to, "enfilade_requests_total{{route=\"{}\",status=\"{}\"}} {}\n", key.first,
                   key.second, count);
  }
  fmt::format_to(to, "# TYPE enfilade_request_seconds histogram\n");
  for (const auto& [route, times] : times_) {
    std::uint64_t below = 0;
    for (std::size_t k = 0; k < times.buckets.size(); ++k) {
      below += times.buckets[k];
      const std::string bound = k < kBounds.size() ? fmt::format("{}", kBounds[k]) : "+Inf";
      fmt::format_to(to, "enfilade_request_seconds_bucket{{route=\"{}\",le=\"{}\"}} {}\n", route,
                     bound, below);
    }
    fmt::format_to(to, "enfilade_request_seconds_sum{{route=\"{}\"}} {}\n", route, times.sum);
    fmt::format_to(to, "enfilade_request_seconds_count{{route=\"{}\"}} {}\n", route, below);
  }
  return out;
}

std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t pages = 0;
  statm >> pages >> pages;  // the second field
  return statm ? pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace enfilade::service::http
