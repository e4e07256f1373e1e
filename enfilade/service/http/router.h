/// \file  Finds the handler of a request.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/service/http/messages.h"

namespace enfilade::service::http {

struct Context;

/// Clients that may call a route.
enum class Access : std::uint8_t {
  kPublic,
  kTeam,       ///< needs a team's token
  kOrganiser,  ///< needs an organiser's
  kReviewer,   ///< needs a reviewer's or an organiser's
  kWorker,     ///< needs a worker's
};

struct Route {
  std::string method;
  std::string pattern;  ///< "/api/v1/scans/{scan}": a {name} takes one part of the path
  Access access = Access::kPublic;
  std::function<Response(Context&, const Request&)> handle;
  std::size_t most_bytes = 16U << 10U;  ///< of the body
};

/// \throws HttpError 401 or 403 if the request's sender may not call the route
void check_access(const Route& route, const Request& request);

/// Finds routes. Filled before the first request; then read by any thread.
class Router {
 public:
  void add(Route route) { routes_.push_back(std::move(route)); }
  const std::vector<Route>& routes() const noexcept { return routes_; }

  struct Match {
    const Route* route = nullptr;  ///< null: none
    Texts parameters;
    std::vector<std::string> methods;  ///< without a route: those that the path has routes for
  };
  Match find(std::string_view method, std::string_view path) const;

 private:
  std::vector<Route> routes_;
};

}  // namespace enfilade::service::http
