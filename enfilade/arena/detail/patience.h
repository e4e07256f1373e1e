/// \file  Asking a server that may be busy or out of order.
#pragma once
#include <functional>
#include <string>
#include <string_view>

#include "enfilade/arena/answer_cache.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/core/errors.h"

namespace enfilade::arena::detail {

/// What was asked for cannot be had now; other things can.
class GivenUp : public Error {
 public:
  using Error::Error;
};

/// How long somebody waits for an answer.
struct Patience {
  int attempts = 6;       ///< requests before it is given up
  double first_wait = 1;  ///< seconds after the first that failed; doubled each time, 60 at most
  /// Waits so many seconds. \returns false if nobody wants the answer any more
  std::function<bool(double seconds)> pause;
};

/// Sends a body until an answer comes that `read` takes; it throws InvalidInput for what is no
/// answer. \throws GivenUp after the last attempt; InvalidInput for a refusal that waiting does not
/// change
KeptAnswer post_patiently(Endpoint& endpoint, std::string_view body, const RequestOrigin& origin,
                          const Patience& patience,
                          const std::function<void(std::string_view answer)>& read);

}  // namespace enfilade::arena::detail
