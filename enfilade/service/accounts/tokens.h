/// \file  Access: teams, tokens, and sessions of browsers.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "enfilade/service/server.h"

namespace enfilade::service::store {
class Database;
}

namespace enfilade::service::accounts {

using ClientRole = TokenRole;

/// The client behind a token or a session.
struct Principal {
  ClientRole role = ClientRole::kTeam;
  std::int64_t token = 0;  ///< id of the token
  std::int64_t team = 0;   ///< of teams, else 0
  std::int64_t visit = 0;  ///< of workers, else 0
  std::string name;        ///< the team's name, or the token's label.
  /// Identified by a cookie, which browsers send with requests of other sites too: a request that
  /// changes something must prove more.
  bool by_cookie = false;

  auto columns() { return std::tie(role, token, team, visit, name); }
};

struct Team {
  std::int64_t id = 0;
  std::string name, contact;
  std::int64_t created = 0;
  std::optional<std::int64_t> approved;  ///< when; none: it is not
  std::int64_t submissions = 0;

  auto columns() { return std::tie(id, name, contact, created, approved, submissions); }
};

struct NewTeam {
  std::int64_t id = 0;
  std::string token;  ///< shown once; only its hash is stored
};

inline constexpr std::int64_t kSessionSeconds = 12L * 3600;
/// How long a worker's token is valid: longer than one sitting, and joining again gives another.
inline constexpr std::int64_t kWorkerSeconds = 24L * 3600;
inline constexpr const char* kSessionCookie = "enfilade_session";

/// \throws Refusal kConflict if the name is taken, kInvalidInput if it is not 1 to 80
/// printable characters, or the contact is neither empty nor up to 200 of them
NewTeam add_team(store::Database& db, const std::string& name, const std::string& contact);
/// All teams, the newest first.
std::vector<Team> list_teams(store::Database& db);
std::optional<Team> find_team(store::Database& db, std::int64_t id);
/// The id of the team of that name, in capitals or not.
std::optional<std::int64_t> find_team_named(store::Database& db, const std::string& name);
/// Whether an organiser lets the team submit to phases with secret goals. New teams are not
/// approved. \returns false for a team that does not exist
bool is_approved(store::Database& db, std::int64_t team);
/// Approves a team, or withdraws the approval, at once. Its submissions stay, but without approval
/// they are not shown if goals are secret.
/// \returns whether there is such a team
bool set_approved(store::Database& db, std::int64_t team, bool approved);
/// \returns the token, shown once
/// \param label for a team its name
/// \param expires seconds since 1970; no value: never
/// \pre role is not kWorker
/// \throws LookupError for an unknown team
std::string add_token(store::Database& db, ClientRole role, const std::string& label,
                      std::optional<std::int64_t> expires);
/// Revokes all with that label, and with them the sessions that they began. \returns how many
int revoke_tokens(store::Database& db, ClientRole role, const std::string& label);
/// For a visit, valid for kWorkerSeconds; deletes workers' tokens that have expired. \returns the
/// token
std::string add_worker_token(store::Database& db, std::int64_t visit, const std::string& label);
/// None for a token that is unknown, expired or revoked.
std::optional<Principal> find_token(store::Database& db, std::string_view token);
/// Logs a browser in with that token. \returns the cookie's secret
std::string start_session(store::Database& db, const Principal& principal);
std::optional<Principal> find_session(store::Database& db, std::string_view secret);
/// Logs out all browsers that are logged in with that token.
void end_sessions(store::Database& db, std::int64_t token);

}  // namespace enfilade::service::accounts
