#include "enfilade/service/accounts/tokens.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>

#include "enfilade/service/detail/secrets.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/http.h"
#include "enfilade/service/store/database.h"
#include "enfilade/service/store/sql.h"

namespace enfilade::service::accounts {
namespace {

constexpr std::size_t kLongestTeam = 80;
constexpr std::size_t kLongestContact = 200;
constexpr std::array<std::string_view, 4> kRoles{"team", "organiser", "reviewer", "worker"};

/// Whose a token is, by role; 0: nobody's.
struct Owner {
  std::int64_t team = 0;
  std::int64_t visit = 0;
};

std::string insert_token(SQLite::Database& db, Role role, Owner owner, const std::string& label,
                         std::int64_t now, std::optional<std::int64_t> expires) {
  // The prefix lets people, and scanners of published sources, see what leaked.
  std::string token = detail::new_secret("enfilade_");
  SQLite::Statement insert(db,
                           "INSERT INTO token (hash, role, team, label, created, expires, visit) "
                           "VALUES (?, ?, ?, ?, ?, ?, ?)");
  insert.bind(1, detail::sha256(token));
  insert.bind(2, std::string(to_string(role)));
  if (owner.team != 0) insert.bind(3, owner.team);
  insert.bind(4, label);
  insert.bind(5, now);
  if (expires) insert.bind(6, *expires);
  if (owner.visit != 0) insert.bind(7, owner.visit);
  insert.exec();
  return token;
}

constexpr const char* kPrincipal =
    "SELECT token.role, token.id, coalesce(token.team, 0), coalesce(token.visit, 0), "
    "coalesce(team.name, token.label) FROM token LEFT JOIN team ON team.id = token.team ";
constexpr const char* kValid =
    " AND token.revoked IS NULL AND (token.expires IS NULL OR token.expires > ?2)";

std::optional<Principal> find_principal(store::Database& database, const std::string& query,
                                        std::string_view secret, std::int64_t now) {
  return database.with([&](SQLite::Database& db) -> std::optional<Principal> {
    SQLite::Statement select(db, query);
    select.bind(1, detail::sha256(secret));
    select.bind(2, now);
    if (!select.executeStep()) return std::nullopt;
    const auto role = std::ranges::find(kRoles, select.getColumn(0).getString());
    return Principal{static_cast<Role>(role - kRoles.begin()), select.getColumn(1).getInt64(),
                     select.getColumn(2).getInt64(),           select.getColumn(3).getInt64(),
                     select.getColumn(4).getString(),          false};
  });
}

}  // namespace

std::string_view to_string(Role role) { return kRoles[static_cast<std::size_t>(role)]; }

NewTeam add_team(store::Database& database, const std::string& name, const std::string& contact,
                 std::int64_t now) {
  if (!detail::is_label(name, kLongestTeam)) {
    throw http::HttpError(422, "bad-name",
                          fmt::format("name: not 1 to {} printable characters", kLongestTeam));
  }
  if (!contact.empty() && !detail::is_label(contact, kLongestContact)) {
    throw http::HttpError(
        422, "bad-contact",
        fmt::format("contact: not up to {} printable characters", kLongestContact));
  }
  try {
    return database.transact([&](SQLite::Database& db) {
      store::run(db, "INSERT INTO team (name, contact, created) VALUES (?, ?, ?)", name, contact,
                 now);
      const std::int64_t id = db.getLastInsertRowid();
      return NewTeam{id, insert_token(db, Role::kTeam, {.team = id}, name, now, std::nullopt)};
    });
  } catch (const SQLite::Exception& error) {
    if (error.getExtendedErrorCode() != store::kUniqueViolated) throw;
    throw http::HttpError(409, "name-taken", "name: another team has it");
  }
}

std::string add_token(store::Database& database, Role role, const std::string& label,
                      std::int64_t now, std::optional<std::int64_t> expires) {
  return database.transact([&](SQLite::Database& db) {
    Owner owner;
    if (role == Role::kTeam) {
      owner.team = store::find_number(db, "SELECT id FROM team WHERE name = ?", label);
      if (owner.team == 0) throw LookupError(fmt::format("{:?}: no team has this name", label));
    }
    return insert_token(db, role, owner, label, now, expires);
  });
}

// A session is good as long as its token is.
int revoke_tokens(store::Database& database, Role role, const std::string& label,
                  std::int64_t now) {
  return database.transact([&](SQLite::Database& db) {
    store::run(db,
               "UPDATE token SET revoked = ?1 WHERE role = ?2 AND revoked IS NULL AND "
               "(label = ?3 OR team = (SELECT id FROM team WHERE name = ?3))",
               now, std::string(to_string(role)), label);
    return db.getChanges();
  });
}

std::string add_worker_token(store::Database& database, std::int64_t visit,
                             const std::string& label, std::int64_t now) {
  return database.transact([&](SQLite::Database& db) {
    store::run(db, "DELETE FROM token WHERE role = 'worker' AND expires <= ?", now);
    return insert_token(db, Role::kWorker, {.visit = visit}, label, now, now + kWorkerSeconds);
  });
}

std::optional<Principal> find_token(store::Database& database, std::string_view token,
                                    std::int64_t now) {
  return find_principal(database, std::string(kPrincipal) + "WHERE token.hash = ?1" + kValid, token,
                        now);
}

std::string start_session(store::Database& database, const Principal& who, std::int64_t now) {
  std::string secret = detail::new_secret("");
  database.transact([&](SQLite::Database& db) {
    store::run(db, "DELETE FROM session WHERE expires <= ?", now);
    store::run(db, "INSERT INTO session (hash, token, expires) VALUES (?, ?, ?)",
               detail::sha256(secret), who.token, now + kSessionSeconds);
  });
  return secret;
}

std::optional<Principal> find_session(store::Database& database, std::string_view secret,
                                      std::int64_t now) {
  auto found = find_principal(database,
                              std::string(kPrincipal) +
                                  "JOIN session ON session.token = token.id "
                                  "WHERE session.hash = ?1 AND session.expires > ?2" +
                                  kValid,
                              secret, now);
  if (found) found->by_cookie = true;
  return found;
}

void end_sessions(store::Database& database, std::int64_t token) {
  database.transact(
      [&](SQLite::Database& db) { store::run(db, "DELETE FROM session WHERE token = ?", token); });
}

}  // namespace enfilade::service::accounts
