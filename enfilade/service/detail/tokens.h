/// \file  Who may do what: teams, tokens, sessions.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace enfilade::service::detail {

class Database;

enum class Role : std::uint8_t { kTeam, kOrganiser };
std::string_view to_string(Role role);  ///< "team", "organiser"

/// Who stands behind a token or a session.
struct Principal {
  Role role = Role::kTeam;
  std::int64_t token = 0;  ///< row of the table
  std::int64_t team = 0;   ///< 0 for organisers
  std::string name;        ///< the team's, or the token's label
  /// By a cookie, which browsers send unasked: what changes something then needs more than that.
  bool by_cookie = false;
};

struct NewTeam {
  std::int64_t id = 0;
  std::string token;  ///< shown once; only its hash is kept
};

/// How long a log-in in a browser lasts.
inline constexpr std::int64_t kSessionSeconds = 12 * 3600;
inline constexpr const char* kSessionCookie = "enfilade_session";

// All \throw Error with SQLite's words if the database fails. `now`: seconds since 1970.

/// \throws HttpError 409 if the name is taken, 422 if it is not 1 to 80 printable characters
NewTeam add_team(Database& database, const std::string& name, const std::string& contact,
                 std::int64_t now);
/// \returns the token, shown once  \param expires seconds since 1970; none: never
std::string add_organiser(Database& database, const std::string& label, std::int64_t now,
                          std::optional<std::int64_t> expires);
/// Nothing for a token that is unknown, expired or revoked.
std::optional<Principal> find_token(Database& database, std::string_view token, std::int64_t now);
/// A browser's log-in with that token. \returns the cookie's secret
std::string start_session(Database& database, const Principal& who, std::int64_t now);
std::optional<Principal> find_session(Database& database, std::string_view secret,
                                      std::int64_t now);
/// Of all browsers where that token is logged in.
void end_sessions(Database& database, std::int64_t token);

/// UTF-8, 1 to `most` characters, none of them a control character, no blank at either end.
bool is_label(std::string_view text, std::size_t most);

}  // namespace enfilade::service::detail
