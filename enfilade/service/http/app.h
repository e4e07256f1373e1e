/// \file  Answers requests, whatever transport they come by.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "enfilade/service/detail/hosts.h"
#include "enfilade/service/http/context.h"
#include "enfilade/service/http/router.h"

namespace enfilade::service::http {

/// Reads a request's body. \throws HttpError 413 if it has more than `most` bytes; 400, 408, 503
using BodyReader = std::function<std::string(std::size_t most)>;

/// The routes, and their shared parts: access, errors as JSON, headers, compression, counting. All
/// functions may be called from any thread.
class App {
 public:
  /// \throws FileError for the database; ArgumentError for one of ServerConfig::public_names
  App(std::shared_ptr<const Site> site, ServerConfig config);

  const Router& router() const noexcept { return router_; }
  /// Never throws: errors become responses.
  /// \param read_body called at most once, after the client is known to be allowed to send a body;
  /// empty: there is no body
  Response handle(Request request, const BodyReader& read_body = {});

 private:
  Response answer(Request& request, const BodyReader& read_body, std::string_view& pattern);
  void check_host(const Request& request) const;
  void check_origin(const Request& request) const;
  void identify(Request& request);

  Context context_;
  detail::OwnNames own_names_;
  Router router_;
};

}  // namespace enfilade::service::http
