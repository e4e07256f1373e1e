/// \file  What answers requests, without the sockets that bring them.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "enfilade/service/browsing/faces.h"
#include "enfilade/service/detail/clock.h"
#include "enfilade/service/evaluation/evaluation.h"
#include "enfilade/service/http/http.h"
#include "enfilade/service/http/metrics.h"
#include "enfilade/service/server.h"
#include "enfilade/service/site.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::http {

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
  std::shared_ptr<store::Database> database;
  ServerConfig config;
  detail::Clock clock;
  browsing::Faces faces;
  evaluation::Evaluation evaluation;
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

/// Reads a request's body. \throws HttpError 413 if it has more than `most` bytes; 400, 408, 503
using BodyReader = std::function<std::string(std::size_t most)>;

/// The routes, and what holds for all of them: who may call, errors as JSON, headers, compression,
/// counting. All functions may be called from any thread.
class App {
 public:
  App(const std::shared_ptr<const Site>& site, ServerConfig config);

  const Router& router() const noexcept { return router_; }
  /// Never throws: whatever goes wrong is a response. \param read_body called at most once, when it
  /// is known that the asker may send one; none: there is no body
  Response handle(Request request, const BodyReader& read_body = {});

 private:
  Response answer(Request& request, const BodyReader& read_body, std::string_view& pattern);
  Response page(const Request& request) const;
  void identify(Request& request);

  Context context_;
  Router router_;
};

}  // namespace enfilade::service::http
