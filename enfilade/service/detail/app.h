/// \file  What answers requests, without the sockets that bring them.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "enfilade/service/detail/database.h"
#include "enfilade/service/detail/evaluation.h"
#include "enfilade/service/detail/faces.h"
#include "enfilade/service/detail/http.h"
#include "enfilade/service/detail/metrics.h"
#include "enfilade/service/server.h"
#include "enfilade/service/site.h"

namespace enfilade::service::detail {

/// At most so many of something from one address in a minute.
class RateLimit {
 public:
  explicit RateLimit(int most_a_minute) : most_(most_a_minute) {}
  /// Counts one. \throws HttpError 429 past the limit
  void take(const std::string& address, std::int64_t now);

 private:
  struct Window {
    std::int64_t minute = 0;
    int count = 0;
  };
  int most_;
  std::mutex mutex_;
  std::map<std::string, Window> windows_;
};

/// What routes work with. Shared by all threads.
struct Context {
  std::shared_ptr<const Site> site;
  std::shared_ptr<Database> database;
  ServerConfig config;
  Clock clock;
  Faces faces;
  Evaluation evaluation;
  Metrics metrics;
  RateLimit failures;       ///< tokens that nobody has
  RateLimit registrations;  ///< new teams
  RateLimit joins;          ///< workers who come
};

void add_scan_routes(Router& router, Context& context);
void add_episode_routes(Router& router, Context& context);
void add_account_routes(Router& router, Context& context);
void add_evaluation_routes(Router& router, Context& context);
void add_collection_routes(Router& router, Context& context);  ///< for organisers
void add_review_routes(Router& router, Context& context);
void add_work_routes(Router& router, Context& context);
void add_operation_routes(Router& router, Context& context);  ///< health, metrics, description

/// The routes, and what holds for all of them: who may call, errors as JSON, headers, compression,
/// counting. All functions may be called from any thread.
class App {
 public:
  App(std::shared_ptr<const Site> site, ServerConfig config);

  const Router& router() const noexcept { return router_; }
  /// Largest body that is worth reading for this request.
  std::size_t most_bytes(std::string_view method, std::string_view path) const;
  /// Never throws: whatever goes wrong is a response.
  Response handle(Request request);

 private:
  Response answer(Request& request, std::string_view& pattern);
  Response page(const Request& request) const;
  void identify(Request& request);

  Context context_;
  Router router_;
};

}  // namespace enfilade::service::detail
