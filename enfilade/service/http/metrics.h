/// \file  Counts of requests and their times, in Prometheus' text format.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

namespace enfilade::service::http {

/// Counts requests by route and status. All functions may be called from any thread.
class Metrics {
 public:
  /// \param route its pattern: paths would be too many  \param seconds until the answer was ready
  void count(std::string_view route, int status, double seconds);
  void begin() noexcept { ++in_flight_; }
  void end() noexcept { --in_flight_; }

  /// \param gauges more of them, as (name, value)
  std::string text(const std::map<std::string, double>& gauges) const;

  static constexpr std::array<double, 8> kBounds{0.001, 0.005, 0.01, 0.05, 0.1, 0.5, 1, 5};

 private:
  struct Times {
    std::array<std::uint64_t, kBounds.size() + 1> buckets{};
    double sum = 0;
  };
  mutable std::mutex mutex_;
  std::map<std::pair<std::string, int>, std::uint64_t> counts_;
  std::map<std::string, Times> times_;
  std::atomic<int> in_flight_{0};
};

/// Resident bytes of this process; 0 if the system doesn't report them.
std::uint64_t resident_bytes();

}  // namespace enfilade::service::http
