/// \file  A model's endpoint: a server on the network.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/arena/session.h"
#include "enfilade/core/errors.h"

namespace enfilade::arena {

/// A request that got no answer.
class EndpointError : public Error {
 public:
  /// \param status  of HTTP; 0: no connection, or no whole answer in time
  EndpointError(int status, const std::string& message, std::optional<double> wait = {})
      : Error(message), status_(status), wait_(wait) {}
  int status() const noexcept { return status_; }
  /// Seconds after which the server accepts a retry (`Retry-After`).
  std::optional<double> wait() const noexcept { return wait_; }
  /// Whether the same request may succeed later: no connection, 408, 409, 425, 429, 5xx.
  bool passes() const noexcept;

 private:
  int status_;
  std::optional<double> wait_;
};

/// Where a request comes from. It is no part of the body, so the model does not get it.
struct RequestOrigin {
  std::string episode;      ///< "r2r/val_unseen/1_0"
  std::vector<Call> calls;  ///< accepted calls of the episode
};

/// Something that answers chat requests.
class Endpoint {
 public:
  virtual ~Endpoint() = default;
  Endpoint(const Endpoint&) = delete;
  Endpoint& operator=(const Endpoint&) = delete;
  /// The body of the answer to a body. Any thread. \throws EndpointError
  virtual std::string post(std::string_view body, const RequestOrigin& origin) = 0;

 protected:
  Endpoint() = default;
};

/// A server on the network. Only in builds with EN_WITH_WEB.
struct HttpEndpointConfig {
  std::string url;       ///< "http://127.0.0.1:8000/v1": /chat/completions is added
  std::string key = {};  ///< sent as `Authorization: Bearer`, and never shown; empty: none
  double timeout = 120;  ///< seconds to wait for an answer, (0, 3600]
};
/// Keeps a connection per thread, and sends the origin as `X-Enfilade-Episode` and
/// `X-Enfilade-Calls` ("go_to B; stop").
/// \throws ArgumentError naming the field, for a URL that is not http:// or https://, or that has a
/// user, a password or a query
/// \throws ArgumentError for a key with bytes that are not printable ASCII
std::unique_ptr<Endpoint> make_http_endpoint(const HttpEndpointConfig& config);

}  // namespace enfilade::arena
