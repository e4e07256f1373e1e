#include "enfilade/service/store/connection.h"

#include <fmt/format.h>

#include "enfilade/service/store/postgres.h"
#include "enfilade/service/store/sqlite.h"

namespace enfilade::service::store {
namespace {

constexpr std::string_view kSchemeEnd = "://";

/// "USER:PASSWORD" of a URL. The last @ ends it, for passwords in which signs were not escaped.
std::string_view user_of(std::string_view url) {
  const std::string_view rest = url.substr(url.find(kSchemeEnd) + kSchemeEnd.size());
  const std::size_t at = rest.rfind('@');
  return at == std::string_view::npos ? std::string_view{} : rest.substr(0, at);
}

}  // namespace

bool is_url(std::string_view place) {
  return place.starts_with("postgresql://") || place.starts_with("postgres://");
}

bool has_password(std::string_view place) {
  return is_url(place) && (user_of(place).find(':') != std::string_view::npos ||
                           place.find("password=") != std::string_view::npos);
}

std::string shown(std::string_view place) {
  if (!is_url(place)) return std::string(place);
  const std::string_view user = user_of(place);
  const std::size_t begin = place.find(kSchemeEnd) + kSchemeEnd.size();
  const std::string whole =
      fmt::format("{}{}{}", place.substr(0, begin), user.substr(0, user.find(':')),
                  place.substr(begin + user.size()));
  return whole.substr(0, whole.find('?'));
}

std::unique_ptr<Connection> connect(const std::string& place) {
  if (!is_url(place)) return open_sqlite(place);
#ifdef EN_WITH_POSTGRES
  return connect_to_postgres(place);
#else
  throw FileError(
      fmt::format("{}: this build has no PostgreSQL; build Enfilade again where libpq is "
                  "(on Debian and Ubuntu: apt-get install libpq-dev)",
                  shown(place)));
#endif
}

}  // namespace enfilade::service::store
