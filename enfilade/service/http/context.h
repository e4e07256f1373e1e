/// \file  What routes work with.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "enfilade/service/browsing/faces.h"
#include "enfilade/service/evaluation/submissions.h"
#include "enfilade/service/http/metrics.h"
#include "enfilade/service/server.h"
#include "enfilade/service/site.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::http {

/// A limit to how often something may come from one address in a minute. Any thread.
class RateLimit {
 public:
  explicit RateLimit(int most_a_minute) : most_(most_a_minute) {}
  /// Counts one. \throws ServiceError kRateLimited past the limit
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

/// Shared by all threads.
struct Context {
  Context(std::shared_ptr<const Site> its_site, ServerConfig its_config);

  std::shared_ptr<const Site> site;
  ServerConfig config;
  store::Database db;
  browsing::Faces faces;
  evaluation::Submissions submissions;
  Metrics metrics;
  RateLimit failures;       ///< unknown tokens and keys
  RateLimit registrations;  ///< new teams
  RateLimit joins;          ///< workers who join
};

}  // namespace enfilade::service::http
