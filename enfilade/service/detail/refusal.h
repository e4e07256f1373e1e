/// \file  Requests that a rule of the service refuses, in the service's own terms.
#pragma once
#include <cstdint>
#include <string>

#include "enfilade/core/errors.h"

namespace enfilade::service::detail {

enum class Reason : std::uint8_t {
  kInvalidInput,      ///< a value that is not allowed
  kForbidden,         ///< not allowed for this client: approval or a free place is missing
  kConsentRequired,   ///< the worker has not agreed to the consent text yet
  kCollectionClosed,  ///< the collection takes no new workers
  kNotFound,          ///< it does not exist, or this client may not see it
  kConflict,          ///< the current state does not allow it
  kAlreadySubmitted,  ///< the task was submitted before
  kAlreadyReturned,   ///< the task was returned before
  kLeaseExpired,      ///< the task's lease ended, and another worker has its place
  kRateLimited,       ///< too many requests
};

/// A refused request; error_response() of http gives each reason its status. The message is for the
/// client: it names nothing of this machine, and no secret.
class Refusal : public Error {
 public:
  Refusal(Reason reason, const std::string& message) : Error(message), reason_(reason) {}
  Reason reason() const noexcept { return reason_; }

 private:
  Reason reason_;
};

}  // namespace enfilade::service::detail
