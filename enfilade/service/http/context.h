/// \file  The state that all routes share.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "enfilade/service/browsing/faces.h"
#include "enfilade/service/browsing/stills.h"
#include "enfilade/service/detail/addresses.h"
#include "enfilade/service/evaluation/submissions.h"
#include "enfilade/service/http/messages.h"
#include "enfilade/service/http/metrics.h"
#include "enfilade/service/server.h"
#include "enfilade/service/site.h"
#include "enfilade/service/store/database.h"
#include "enfilade/service/store/health.h"

namespace enfilade::service::http {

/// Limits how often a client address may do something in a minute of the clock. All functions may
/// be called from any thread.
class RateLimit {
 public:
  explicit RateLimit(int most_a_minute) : most_(most_a_minute) {}
  /// Counts one attempt of an address. \param now seconds since 1970
  /// \throws HttpError 429 if that is more than the limit
  void count(const std::string& address, std::int64_t now) {
    constexpr std::size_t kMostAddresses = 10'000;
    const std::int64_t minute = now / 60;
    const std::scoped_lock lock(mutex_);
    if (windows_.size() > kMostAddresses) {
      std::erase_if(windows_, [minute](const auto& one) { return one.second.minute != minute; });
    }
    if (windows_.size() > kMostAddresses) windows_.clear();
    Window& window = windows_[detail::address_group(address)];
    if (window.minute != minute) window = {minute, 0};
    if (++window.count > most_) {
      throw HttpError(429, "too many attempts from this address; wait a minute");
    }
  }

 private:
  struct Window {
    std::int64_t minute = 0;
    int count = 0;
  };
  int most_;
  std::mutex mutex_;
  std::map<std::string, Window> windows_;
};

/// Gives failures of the scoring thread to ServerConfig::log; empty without a log.
inline evaluation::Submissions::Report scoring_log(const ServerConfig& config) {
  if (!config.log) return {};
  return [log = config.log](std::string_view fault) {
    RequestRecord record;
    record.address = "-";
    record.method = "SCORE";
    record.status = 500;
    record.fault = fault;
    log(record);
  };
}

/// Gives troubles of disk and database to ServerConfig::log; empty without a log.
inline store::Health::Report health_log(const ServerConfig& config) {
  if (!config.log) return {};
  return [log = config.log](std::string_view fault) {
    RequestRecord record;
    record.address = "-";
    record.method = "HEALTH";
    record.status = fault.empty() ? 200 : 503;
    record.fault = fault;
    log(record);
  };
}

/// Shared state of the handlers of all routes. Each App owns one: it lives until the last request
/// is answered. Any thread may use it at any time: the members that change do their own locking,
/// `site` and `config` never change.
/// \throws FileError (from its constructor) if the database can't be opened
struct Context {
  std::shared_ptr<const Site> site;
  ServerConfig config;
  store::Database db{config.database, config.clock};
  browsing::Faces faces{site->panoramas()};
  browsing::Stills stills{site};
  store::Health health{db, config.least_free_bytes, health_log(config)};
  evaluation::Submissions submissions{site, db, scoring_log(config)};
  Metrics metrics{};
  RateLimit failures{config.most_attempts};       ///< unknown tokens and keys
  RateLimit registrations{config.most_attempts};  ///< new teams
  RateLimit joins{config.most_joins};             ///< workers who join
  RateLimit plays{config.most_joins};             ///< sessions of the arena that begin
};

}  // namespace enfilade::service::http
