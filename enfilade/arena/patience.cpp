#include "enfilade/arena/detail/patience.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <utility>

namespace enfilade::arena::detail {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLongestWait = 60;     // seconds between two attempts, unless the server says more
constexpr double kMostAskedWait = 600;  // more than that is no wait

}  // namespace

KeptAnswer post_patiently(Endpoint& endpoint, std::string_view body, const RequestOrigin& origin,
                          const Patience& patience,
                          const std::function<void(std::string_view answer)>& read) {
  double wait = patience.first_wait;
  for (int attempt = 1;; ++attempt) {
    const auto begin = Clock::now();
    std::string failed;
    double asked_wait = 0;
    try {
      std::string answer = endpoint.post(body, origin);
      read(answer);
      const std::chrono::duration<double> seconds = Clock::now() - begin;
      return {std::move(answer), seconds.count(), attempt};
    } catch (const EndpointError& error) {
      if (!error.passes()) {
        throw InvalidInput(
            {{Severity::kError, "endpoint", origin.episode, "refused", error.what()}});
      }
      failed = error.what();
      asked_wait = std::min(error.wait().value_or(0), kMostAskedWait);
    } catch (const InvalidInput& error) {
      failed = error.what();
    }
    if (attempt >= patience.attempts || !patience.pause(std::max(wait, asked_wait))) {
      throw GivenUp(fmt::format("no answer in {} attempts; the last: {}", attempt, failed));
    }
    wait = std::min(2 * wait, kLongestWait);
  }
}

}  // namespace enfilade::arena::detail
