/// \file  Who may do what: teams, tokens, sessions.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace enfilade::service::store {
class Database;
}

namespace enfilade::service::accounts {

enum class Role : std::uint8_t { kTeam, kOrganiser, kReviewer, kWorker };
std::string_view to_string(Role role);  ///< "team", "organiser", "reviewer", "worker"

/// Who stands behind a token or a session.
struct Principal {
  Role role = Role::kTeam;
  std::int64_t token = 0;  ///< row of the table
  std::int64_t team = 0;   ///< of teams, else 0
  std::int64_t visit = 0;  ///< of workers, else 0
  std::string name;        ///< the team's, or the token's label
  /// By a cookie, which browsers send unasked: what changes something then needs more than that.
  bool by_cookie = false;
};

struct NewTeam {
  std::int64_t id = 0;
  std::string token;  ///< shown once; only its hash is kept
};

/// How long a log-in in a browser lasts.
inline constexpr std::int64_t kSessionSeconds = 12L * 3600;
/// How long a worker's token is good: longer than anybody sits at it, and joining gives another.
inline constexpr std::int64_t kWorkerSeconds = 24L * 3600;
inline constexpr const char* kSessionCookie = "enfilade_session";

// All \throw Error with SQLite's words if the database fails. `now`: seconds since 1970.

/// \throws HttpError 409 if the name is taken, 422 if it is not 1 to 80 printable characters
NewTeam add_team(store::Database& database, const std::string& name, const std::string& contact,
                 std::int64_t now);
/// \returns the token, shown once  \param label of a team its name  \param expires seconds since
/// 1970; none: never  \pre role is not kWorker  \throws LookupError if there is no such team
std::string add_token(store::Database& database, Role role, const std::string& label,
                      std::int64_t now, std::optional<std::int64_t> expires);
/// Those with that label; with them go the sessions that they began. \returns how many
int revoke_tokens(store::Database& database, Role role, const std::string& label, std::int64_t now);
/// For a visit, kWorkerSeconds long; forgets those of workers that have expired. \returns the token
std::string add_worker_token(store::Database& database, std::int64_t visit,
                             const std::string& label, std::int64_t now);
/// Nothing for a token that is unknown, expired or revoked.
std::optional<Principal> find_token(store::Database& database, std::string_view token,
                                    std::int64_t now);
/// A browser's log-in with that token. \returns the cookie's secret
std::string start_session(store::Database& database, const Principal& who, std::int64_t now);
std::optional<Principal> find_session(store::Database& database, std::string_view secret,
                                      std::int64_t now);
/// Of all browsers where that token is logged in.
void end_sessions(store::Database& database, std::int64_t token);

}  // namespace enfilade::service::accounts
