#include "enfilade/service/accounts/tokens.h"

#include <fmt/format.h>

#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::accounts {
namespace {

using detail::Reason;
using detail::Refusal;

constexpr std::size_t kLongestTeam = 80;
constexpr std::size_t kLongestContact = 200;
constexpr const char* kTeams =
    "SELECT id, name, contact, created, approved, "
    "(SELECT count(*) FROM submission WHERE submission.team = team.id) FROM team ";

/// \param team, visit the owner, by role
std::string insert_token(store::Database& db, ClientRole role, const std::string& label,
                         std::optional<std::int64_t> expires, std::optional<std::int64_t> team,
                         std::optional<std::int64_t> visit = {}) {
  // By the prefix, people and scanners of published sources recognise a leaked token.
  std::string token = detail::new_secret("enfilade_");
  db.run(
      "INSERT INTO token (hash, role, team, label, created, expires, visit) "
      "VALUES (?, ?, ?, ?, ?, ?, ?)",
      detail::sha256(token), role, team, label, db.now(), expires, visit);
  return token;
}

/// \param from joined tables, and the condition on ?1, the hash of `secret`
std::optional<Principal> find_principal(store::Database& db, const std::string& from,
                                        std::string_view secret) {
  return db.find<Principal>(
      "SELECT token.role, token.id, coalesce(token.team, 0), coalesce(token.visit, 0), "
      "coalesce(team.name, token.label) FROM token LEFT JOIN team ON team.id = token.team " +
          from + " AND token.revoked IS NULL AND (token.expires IS NULL OR token.expires > ?2)",
      detail::sha256(secret), db.now());
}

}  // namespace

NewTeam add_team(store::Database& db, const std::string& name, const std::string& contact) {
  if (!detail::is_label(name, kLongestTeam)) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("name: not 1 to {} printable characters", kLongestTeam));
  }
  if (!contact.empty() && !detail::is_label(contact, kLongestContact)) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("contact: not up to {} printable characters", kLongestContact));
  }
  return db.transact([&] {
    if (find_team_named(db, name)) {
      throw Refusal(Reason::kConflict, "name: another team has it");
    }
    const std::int64_t id = db.insert("INSERT INTO team (name, contact, created) VALUES (?, ?, ?)",
                                      name, contact, db.now());
    return NewTeam{id, insert_token(db, ClientRole::kTeam, name, std::nullopt, id)};
  });
}

std::vector<Team> list_teams(store::Database& db) {
  return db.select<Team>(std::string(kTeams) + "ORDER BY id DESC");
}

std::optional<Team> find_team(store::Database& db, std::int64_t id) {
  return db.find<Team>(std::string(kTeams) + "WHERE id = ?", id);
}

std::optional<std::int64_t> find_team_named(store::Database& db, const std::string& name) {
  return db.find<std::int64_t>("SELECT id FROM team WHERE lower(name) = ?",
                               lower_case(name));
}

bool is_approved(store::Database& db, std::int64_t team) {
  return db.find_number("SELECT approved IS NOT NULL FROM team WHERE id = ?", team) != 0;
}

bool set_approved(store::Database& db, std::int64_t team, bool approved) {
  const std::optional<std::int64_t> at = approved ? std::optional(db.now()) : std::nullopt;
  return db.run("UPDATE team SET approved = ? WHERE id = ?", at, team) == 1;
}

std::string add_token(store::Database& db, ClientRole role, const std::string& label,
                      std::optional<std::int64_t> expires) {
  return db.transact([&] {
    std::optional<std::int64_t> team;
    if (role == ClientRole::kTeam) {
      team = find_team_named(db, label);
      if (!team) throw LookupError(fmt::format("{:?}: no team has this name", label));
    }
    return insert_token(db, role, label, expires, team);
  });
}

// A session is valid as long as its token is.
int revoke_tokens(store::Database& db, ClientRole role, const std::string& label) {
  return db.run(
      "UPDATE token SET revoked = ?1 WHERE role = ?2 AND revoked IS NULL AND "
      "(label = ?3 OR team = (SELECT id FROM team WHERE lower(name) = ?4))",
      db.now(), role, label, lower_case(label));
}

std::string add_worker_token(store::Database& db, std::int64_t visit, const std::string& label) {
  return db.transact([&] {
    db.run("DELETE FROM token WHERE role = 'worker' AND expires <= ?", db.now());
    return insert_token(db, ClientRole::kWorker, label, db.now() + kWorkerSeconds, {}, visit);
  });
}

std::optional<Principal> find_token(store::Database& db, std::string_view token) {
  return find_principal(db, "WHERE token.hash = ?1", token);
}

std::string start_session(store::Database& db, const Principal& principal) {
  std::string secret = detail::new_secret("");
  db.transact([&] {
    db.run("DELETE FROM session WHERE expires <= ?", db.now());
    db.run("INSERT INTO session (hash, token, expires) VALUES (?, ?, ?)", detail::sha256(secret),
           principal.token, db.now() + kSessionSeconds);
  });
  return secret;
}

std::optional<Principal> find_session(store::Database& db, std::string_view secret) {
  auto found = find_principal(db,
                              "JOIN session ON session.token = token.id "
                              "WHERE session.hash = ?1 AND session.expires > ?2",
                              secret);
  if (found) found->by_cookie = true;
  return found;
}

void end_sessions(store::Database& db, std::int64_t token) {
  db.run("DELETE FROM session WHERE token = ?", token);
}

}  // namespace enfilade::service::accounts
