/// \file  Requests that the service refuses.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/core/errors.h"

namespace enfilade::service::detail {

/// A refused request, with its status of HTTP: 404 also for what this client may not see, 409 if
/// the present state does not allow it. The message is for the client: it names nothing of this
/// machine, and no secret.
class Refusal : public Error {
 public:
  /// \param code the word that scripts match, if a client goes on differently than after other
  /// refusals with this status: "lease-expired"; empty: the word of the status
  Refusal(int status, const std::string& message, std::string_view code = {})
      : Error(message), status_(status), code_(code) {}
  int status() const noexcept { return status_; }
  std::string_view code() const noexcept { return code_; }

 private:
  int status_;
  std::string_view code_;
};

}  // namespace enfilade::service::detail
