/// \file  Errors as responses: the one place where what went wrong becomes a status and a code.
#pragma once
#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/http/messages.h"

namespace enfilade::service::http {

/// A request that is wrong as a message of HTTP: its form, its size, its sender. What the service
/// itself refuses is a detail::ServiceError.
class HttpError : public Error {
 public:
  HttpError(int status, const std::string& message) : Error(message), status_(status) {}
  int status() const noexcept { return status_; }

 private:
  int status_;
};

/// {"error": {"code", "message"}}, with "diagnostics" if there are any: at most 200 of them, and
/// how many there were. The code is the status' own: 404 is "not-found".
Response error_response(int status, std::string_view message,
                        const std::vector<Diagnostic>& diagnostics = {});

/// Of whatever a route threw. \param fault what went wrong in the server itself (status 500), for
/// its log alone: it may name files of this machine
Response error_response(const std::exception_ptr& thrown, std::string& fault);

}  // namespace enfilade::service::http
