/// \file  What the service refuses to do, in its own terms. http/errors.h gives each a status.
#pragma once
#include <cstdint>
#include <string>

#include "enfilade/core/errors.h"

namespace enfilade::service::detail {

enum class ErrorCode : std::uint8_t {
  kInvalidInput,      ///< a value that is not allowed
  kForbidden,         ///< this client may not do it
  kConsentRequired,   ///< the worker has not agreed to the consent text yet
  kCollectionClosed,  ///< the collection takes no new workers
  kNotFound,          ///< there is none, or it is not this client's to see
  kConflict,          ///< the present state does not allow it
  kAlreadySubmitted,  ///< the task was submitted before
  kAlreadyReturned,   ///< the task was given back before
  kLeaseExpired,      ///< the task's lease ended, and another worker has its place
  kRateLimited,       ///< too often
};

/// A request that a rule of the service refuses. The message is for the client: it names nothing of
/// this machine, and no secret.
class ServiceError : public Error {
 public:
  ServiceError(ErrorCode code, const std::string& message) : Error(message), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace enfilade::service::detail
