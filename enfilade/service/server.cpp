#include "enfilade/service/server.h"

#include <fmt/format.h>
#include <malloc.h>
#include <filesystem>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/service/accounts/tokens.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/web_files.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service {
namespace {

void check_exists(const std::string& database) {
  if (!store::is_url(database) && !std::filesystem::exists(database)) {
    throw FileError(fmt::format("{}: there is no such database", database));
  }
}

}  // namespace

void give_back_large_memory() noexcept {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 20);  // given a value, it no longer rises to the largest freed
#endif
}

bool has_password(const std::string& database) { return store::has_password(database); }

std::string shown_database(const std::string& database) { return store::shown(database); }

bool has_web_client() noexcept { return !http::web_files().empty(); }

std::string create_token(const std::string& database, TokenRole role, const std::string& label,
                         std::optional<int> days) {
  constexpr std::size_t kLongestLabel = 80;
  if (!detail::is_label(label, kLongestLabel)) {
    throw ArgumentError(
        fmt::format("label: {:?}, not 1 to {} printable characters", label, kLongestLabel));
  }
  store::Database db(database);
  std::optional<std::int64_t> expires;
  if (days) expires = db.now() + std::int64_t{*days} * 24 * 3600;
  return accounts::add_token(db, role, label, expires);
}

int revoke_tokens(const std::string& database, TokenRole role, const std::string& label) {
  check_exists(database);
  store::Database db(database);
  return accounts::revoke_tokens(db, role, label);
}

std::string create_team(const std::string& database, const std::string& name) {
  store::Database db(database);
  const accounts::NewTeam team = accounts::add_team(db, name, "");
  accounts::set_approved(db, team.id, true);
  return team.token;
}

void set_approval(const std::string& database, const std::string& team, Approval approval) {
  check_exists(database);
  store::Database db(database);
  const auto id = accounts::find_team_named(db, team);
  if (!id) throw LookupError(fmt::format("{:?}: no team has this name", team));
  accounts::set_approved(db, *id, approval == Approval::kGiven);
}

void back_up_database(const std::string& database, const std::filesystem::path& copy) {
  if (store::is_url(database)) {
    throw ArgumentError(fmt::format("{}: PostgreSQL has its own program for that: pg_dump",
                                    store::shown(database)));
  }
  check_exists(database);
  store::back_up(database, copy);
}

std::int64_t copy_to_postgres(const std::string& file, const std::string& url,
                              const Progress& progress) {
  if (store::is_url(file)) {
    throw ArgumentError(fmt::format("{}: a file is copied, not a database", store::shown(file)));
  }
  if (!store::is_url(url)) {
    throw ArgumentError(fmt::format(
        "{}: a file is copied into PostgreSQL, postgresql://USER@HOST/NAME; `backup` makes a file",
        url));
  }
  check_exists(file);
  return store::transfer(file, url, progress);
}

}  // namespace enfilade::service
