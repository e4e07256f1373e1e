#include "enfilade/service/http/context.h"

#include <utility>

#include "enfilade/service/detail/errors.h"

namespace enfilade::service::http {

void RateLimit::count(const std::string& address, std::int64_t now) {
  constexpr std::size_t kMostAddresses = 10'000;
  const std::int64_t minute = now / 60;
  const std::scoped_lock lock(mutex_);
  if (windows_.size() > kMostAddresses) windows_.clear();
  Window& window = windows_[address];
  if (window.minute != minute) window = {minute, 0};
  if (++window.count > most_) {
    throw detail::ServiceError(detail::ErrorCode::kRateLimited,
                               "too many attempts from this address; wait a minute");
  }
}

Context::Context(std::shared_ptr<const Site> its_site, ServerConfig its_config)
    : site(std::move(its_site)),
      config(std::move(its_config)),
      db(config.database, config.clock ? config.clock : detail::system_clock()),
      faces(site->panoramas()),
      submissions(site, db),
      failures(config.most_attempts),
      registrations(config.most_attempts),
      joins(config.most_joins) {}

}  // namespace enfilade::service::http
