/// \file  The routes of the API, one function per group, the state that they share, and how a
/// request finds its route. Exceptions of handlers (HttpError, detail::Refusal, InvalidInput)
/// become responses: see error_response().
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/net/hosts.h"
#include "enfilade/service/browsing/pictures.h"
#include "enfilade/service/browsing/site_json.h"
#include "enfilade/service/evaluation/breakdown.h"
#include "enfilade/service/evaluation/submissions.h"
#include "enfilade/service/http/messages.h"
#include "enfilade/service/server.h"
#include "enfilade/service/sessions/painters.h"
#include "enfilade/service/sessions/replays.h"
#include "enfilade/service/sessions/sessions.h"
#include "enfilade/service/site.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::http {

/// Counts requests by route and status. All functions may be called from any thread.
class Metrics {
 public:
  /// \param route its pattern: paths would be too many  \param seconds until the answer was ready
  void count(std::string_view route, int status, double seconds);
  void begin() noexcept { ++in_flight_; }
  void end() noexcept { --in_flight_; }

  /// \param gauges more of them, as (name, value)
  std::string text(const std::map<std::string, double>& gauges) const;

  static constexpr std::array<double, 8> kBounds{0.001, 0.005, 0.01, 0.05, 0.1, 0.5, 1, 5};

 private:
  struct Times {
    std::array<std::uint64_t, kBounds.size() + 1> buckets{};
    double sum = 0;
  };
  mutable std::mutex mutex_;
  std::map<std::pair<std::string, int>, std::uint64_t> counts_;
  std::map<std::string, Times> times_;
  std::atomic<int> in_flight_{0};
};

/// Resident bytes of this process; 0 if the system doesn't report them.
std::uint64_t resident_bytes();

/// Limits how often a client address may do something in a minute of the clock. All functions may
/// be called from any thread.
class RateLimit {
 public:
  explicit RateLimit(int most_a_minute) : most_(most_a_minute) {}
  /// Counts one attempt of an address. \param now seconds since 1970
  /// \throws HttpError 429 if that is more than the limit
  void count(const std::string& address, std::int64_t now);

 private:
  struct Window {
    std::int64_t minute = 0;
    int count = 0;
  };
  int most_;
  std::mutex mutex_;
  std::map<std::string, Window> windows_;
};

/// Gives faults to ServerConfig::log: of the scoring thread, of disk and database. Empty without a
/// log. \param method in place of a request's  \param status of a fault; an empty one: 200
std::function<void(std::string_view)> fault_log(const ServerConfig& config, std::string_view method,
                                                int status);

/// Shared state of the handlers of all routes. Each App owns one: it lives until the last request
/// is answered. Any thread may use it at any time: the members that change do their own locking,
/// `site` and `config` never change.
/// \throws FileError (from its constructor) if the database can't be opened, or the runs are not a
/// folder
struct RouteContext {
  std::shared_ptr<const Site> site;
  ServerConfig config;
  store::Database db{config.database, config.clock};
  browsing::Faces faces{site->panoramas()};
  browsing::Stills stills{site};
  browsing::Pieces pieces{site};
  store::Health health{db, config.least_free_bytes, fault_log(config, "HEALTH", 503)};
  evaluation::Submissions submissions{
      site, db, fault_log(config, "SCORE", 500),
      config.accept_leak ? evaluation::Leaks::kAccepted : evaluation::Leaks::kRefused};
  evaluation::Breakdowns breakdowns{site, submissions};
  browsing::Roaming roaming{site};
  std::shared_ptr<sessions::Painters> painters = std::make_shared<sessions::Painters>(site);
  sessions::Sessions arena_sessions{site, db, painters};
  sessions::Replays replays{site, config.runs, painters};
  Metrics metrics{};
  RateLimit failures{config.most_attempts};       ///< unknown tokens and keys
  RateLimit registrations{config.most_attempts};  ///< new teams
  RateLimit joins{config.most_joins};             ///< workers who join
  RateLimit begun_sessions{config.most_joins};    ///< of the arena
};

/// Clients that may call a route.
enum class Access : std::uint8_t {
  kPublic,
  kTeam,       ///< needs a team's token
  kOrganiser,  ///< needs an organiser's
  kReviewer,   ///< needs a reviewer's or an organiser's
  kWorker,     ///< needs a worker's
};

struct HttpRoute {
  std::string method;
  std::string pattern;  ///< "/api/v1/scans/{scan}": a {name} takes one part of the path
  Access access = Access::kPublic;
  std::function<Response(RouteContext&, const Request&)> handle;
  std::size_t most_bytes = 16U << 10U;  ///< of the body
};

/// \throws HttpError 401 or 403 if the request's sender may not call the route
void check_access(const HttpRoute& route, const Request& request);

/// Finds routes. Filled before the first request; then read by any thread.
class Router {
 public:
  void add(HttpRoute route) { routes_.push_back(std::move(route)); }
  const std::vector<HttpRoute>& routes() const noexcept { return routes_; }

  struct Match {
    const HttpRoute* route = nullptr;  ///< null: none
    Texts parameters;
    std::vector<std::string> methods;  ///< without a route: those that the path has routes for
  };
  Match find(std::string_view method, std::string_view path) const;

 private:
  std::vector<HttpRoute> routes_;
};

/// Scans (graphs, faces, plans, meshes and floors), splits and episodes.
void add_browsing_routes(Router& router);
/// Sessions of the arena (episodes stepped call by call), and its runs, shown step by step.
void add_session_routes(Router& router);
/// Teams, and logging in to the pages; phases, submissions, leaderboards.
/// \param most_bytes of a results file
void add_evaluation_routes(Router& router, std::size_t most_bytes);
/// Collections, for organisers, workers and reviewers. \param most_bytes of a new collection
void add_collection_routes(Router& router, std::size_t most_bytes);
/// Health, metrics and the API's description.
void add_operation_routes(Router& router);

/// A built page or asset of the web client. \throws HttpError 404
Response page(RouteContext& context, const Request& request);
bool is_page(std::string_view path);  ///< whether page() has that page
/// What the header of every page says of its server.
struct HeaderFacts {
  bool synthetic = false;
  bool runs = false;  ///< there are runs to look at: /replay
};
/// Gives an error the form of a page, for people, if a browser sent the request. Scripts and the
/// API's clients get JSON.
void show_to_people(const Request& request, const HeaderFacts& served, Response& error);

using net::BodyReader;

/// The routes, and their shared parts: access, errors as JSON, headers, compression, counting. All
/// functions may be called from any thread.
class App {
 public:
  /// \throws FileError for the database; ArgumentError for one of ServerConfig::public_names;
  /// InvalidInput as Ledger
  App(std::shared_ptr<const Site> site, ServerConfig config);

  const Router& router() const noexcept { return router_; }
  /// Never throws: errors become responses.
  /// \param read_body called at most once, after the client is known to be allowed to send a body;
  /// empty: there is no body
  Response handle(Request request, const BodyReader& read_body = {});
  /// Counts and logs a request that the connection's limits refused: no route has seen it.
  void count_refusal(const net::Request& request, const net::Response& response);

 private:
  Response answer(Request& request, const BodyReader& read_body, std::string_view& pattern);
  void check_host(const Request& request) const;
  void check_origin(const Request& request) const;
  void identify(Request& request);

  RouteContext context_;
  net::OwnNames own_names_;
  Router router_;
};

}  // namespace enfilade::service::http
