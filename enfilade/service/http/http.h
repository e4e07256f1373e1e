/// \file  Requests and responses as routes see them, whatever library carries them.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/accounts/tokens.h"

namespace enfilade::service::http {

/// Names of headers in lower case.
using Headers = std::map<std::string, std::string, std::less<>>;

struct Request {
  std::string method;  ///< "GET", "POST", "DELETE"; HEAD comes as GET
  std::string path;    ///< decoded, without the query
  std::map<std::string, std::string, std::less<>> query;  ///< decoded; of repeated ones the first
  Headers headers;
  std::string body;
  std::string address;                                         ///< of the client
  std::map<std::string, std::string, std::less<>> parameters;  ///< of the route's pattern
  std::optional<accounts::Principal> principal;                ///< who asks, if they said so

  std::string_view header(std::string_view name) const;  ///< "" if absent
  /// \pre the route's pattern has {name}
  const std::string& parameter(std::string_view name) const;
  /// A whole number of the query. \throws HttpError 400 if it is none, or out of range
  std::int64_t number(std::string_view name, std::int64_t otherwise, std::int64_t least,
                      std::int64_t most) const;
  std::string text(std::string_view name) const;  ///< of the query; "" if absent
};

struct Response {
  int status = 200;
  std::string type = "application/json";
  /// Shared, as faces and the pages' files are the same for everybody.
  std::shared_ptr<const std::string> body = std::make_shared<const std::string>();
  std::vector<std::pair<std::string, std::string>> headers;
  bool frameable = false;  ///< its own Content-Security-Policy says who may frame it
};
Response json_response(std::string json, int status = 200);
Response csv_response(std::string csv);

/// An answer that isn't what was hoped for. `code` is stable and short, for scripts.
class HttpError : public Error {
 public:
  HttpError(int status, std::string code, const std::string& message)
      : Error(message), status_(status), code_(std::move(code)) {}
  int status() const noexcept { return status_; }
  const std::string& code() const noexcept { return code_; }

 private:
  int status_;
  std::string code_;
};

/// {"error": {"code", "message"}}, with "diagnostics" if there are any: at most 200 of them, and
/// how many there were.
Response error_response(int status, std::string_view code, std::string_view message,
                        const std::vector<Diagnostic>& diagnostics = {});

/// Who may call a route.
enum class Access {
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
  std::function<Response(const Request&)> handle;
  std::size_t most_bytes = 16U << 10U;  ///< of the body
};

/// Finds routes. Filled before the first request; then read by any thread.
class Router {
 public:
  void add(Route route) { routes_.push_back(std::move(route)); }
  const std::vector<Route>& routes() const noexcept { return routes_; }

  struct Match {
    const Route* route = nullptr;  ///< null: none
    std::map<std::string, std::string, std::less<>> parameters;
    bool other_method = false;  ///< the path is there, for other methods
  };
  Match find(std::string_view method, std::string_view path) const;

 private:
  std::vector<Route> routes_;
};

/// A whole number and nothing else; none if `text` is not one, or out of range.
std::optional<std::int64_t> parse_number(std::string_view text);

/// The parts between slashes: "/a/b" -> a, b.
std::vector<std::string_view> split_path(std::string_view path);

}  // namespace enfilade::service::http
