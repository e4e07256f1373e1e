/// \file  Asking a server that may be busy or out of order.
#pragma once
#include <functional>
#include <string>
#include <string_view>

#include "enfilade/arena/answer_cache.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/core/errors.h"

namespace enfilade::arena::detail {

/// The response cannot be had now; others may be.
class GivenUp : public Error {
 public:
  using Error::Error;
};

/// Attempts and back-off of requests.
struct Patience {
  int attempts = 6;       ///< requests before it is given up
  double first_wait = 1;  ///< seconds after the first failure; doubled each time, at most 60.
  /// Waits for a number of seconds. \returns false if the response is no longer needed
  std::function<bool(double seconds)> pause;
};

/// Sends a body until a response comes that `read` accepts; it throws InvalidInput for others.
/// \throws GivenUp after the last attempt
/// \throws InvalidInput for a refusal that waiting does not change
KeptAnswer post_patiently(Endpoint& endpoint, std::string_view body, const RequestOrigin& origin,
                          const Patience& patience,
                          const std::function<void(std::string_view answer)>& read);

}  // namespace enfilade::arena::detail
