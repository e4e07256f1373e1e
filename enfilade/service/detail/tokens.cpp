#include "enfilade/service/detail/tokens.h"

#include <fmt/format.h>

#include "enfilade/service/detail/database.h"
#include "enfilade/service/detail/http.h"
#include "enfilade/service/detail/secrets.h"

namespace enfilade::service::detail {
namespace {

constexpr std::size_t kLongestTeam = 80;
constexpr std::size_t kLongestContact = 200;
constexpr int kUniqueViolated = 2067;  // SQLITE_CONSTRAINT_UNIQUE

std::string insert_token(SQLite::Database& db, Role role, std::optional<std::int64_t> team,
                         const std::string& label, std::int64_t now,
                         std::optional<std::int64_t> expires) {
  // The prefix lets people, and scanners of published sources, see what leaked.
  const std::string token = new_secret("enfilade_");
  SQLite::Statement insert(db,
                           "INSERT INTO token (hash, role, team, label, created, expires) "
                           "VALUES (?, ?, ?, ?, ?, ?)");
  insert.bind(1, sha256(token));
  insert.bind(2, std::string(to_string(role)));
  if (team) insert.bind(3, *team);
  insert.bind(4, label);
  insert.bind(5, now);
  if (expires) insert.bind(6, *expires);
  insert.exec();
  return token;
}

constexpr const char* kPrincipal =
    "SELECT token.role, token.id, coalesce(token.team, 0), coalesce(team.name, token.label) "
    "FROM token LEFT JOIN team ON team.id = token.team ";
constexpr const char* kValid =
    " AND token.revoked IS NULL AND (token.expires IS NULL OR token.expires > ?2)";

std::optional<Principal> find_principal(Database& database, const std::string& query,
                                        std::string_view secret, std::int64_t now) {
  return database.with([&](SQLite::Database& db) -> std::optional<Principal> {
    SQLite::Statement select(db, query);
    select.bind(1, sha256(secret));
    select.bind(2, now);
    if (!select.executeStep()) return std::nullopt;
    const bool team = select.getColumn(0).getString() == "team";
    return Principal{team ? Role::kTeam : Role::kOrganiser, select.getColumn(1).getInt64(),
                     select.getColumn(2).getInt64(), select.getColumn(3).getString(), false};
  });
}

/// The length of the UTF-8 character that the text begins with; 0 if it begins with none.
std::size_t character_size(std::string_view text) {
  const auto byte = [&text](std::size_t k) {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0U;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t size = first >= 0xC2 && first < 0xE0   ? 2
                           : first >= 0xE0 && first < 0xF0 ? 3
                           : first >= 0xF0 && first < 0xF5 ? 4
                                                           : 0;
  for (std::size_t k = 1; k < size; ++k) {
    if ((byte(k) & 0xC0U) != 0x80U) return 0;
  }
  return size;
}

}  // namespace

std::string_view to_string(Role role) { return role == Role::kTeam ? "team" : "organiser"; }

bool is_label(std::string_view text, std::size_t most) {
  if (text.empty() || text.front() == ' ' || text.back() == ' ') return false;
  std::size_t characters = 0;
  for (; !text.empty(); ++characters) {
    const std::size_t size = character_size(text);
    const auto first = static_cast<unsigned char>(text.front());
    if (size == 0 || first < 0x20 || first == 0x7F) return false;
    // U+0080 to U+009F, and U+202A to U+202E and U+2066 to U+2069, which turn text around.
    const std::string_view c = text.substr(0, size);
    if (c >= "\xC2\x80" && c <= "\xC2\x9F" && size == 2) return false;
    if (size == 3 && ((c >= "\xE2\x80\xAA" && c <= "\xE2\x80\xAE") ||
                      (c >= "\xE2\x81\xA6" && c <= "\xE2\x81\xA9"))) {
      return false;
    }
    text.remove_prefix(size);
  }
  return characters <= most;
}

NewTeam add_team(Database& database, const std::string& name, const std::string& contact,
                 std::int64_t now) {
  if (!is_label(name, kLongestTeam)) {
    throw HttpError(422, "bad-name",
                    fmt::format("name: not 1 to {} printable characters", kLongestTeam));
  }
  if (!contact.empty() && !is_label(contact, kLongestContact)) {
    throw HttpError(422, "bad-contact",
                    fmt::format("contact: not up to {} printable characters", kLongestContact));
  }
  try {
    return database.transact([&](SQLite::Database& db) {
      SQLite::Statement insert(db, "INSERT INTO team (name, contact, created) VALUES (?, ?, ?)");
      insert.bind(1, name);
      insert.bind(2, contact);
      insert.bind(3, now);
      insert.exec();
      const std::int64_t id = db.getLastInsertRowid();
      return NewTeam{id, insert_token(db, Role::kTeam, id, name, now, std::nullopt)};
    });
  } catch (const SQLite::Exception& error) {
    if (error.getExtendedErrorCode() != kUniqueViolated) throw;
    throw HttpError(409, "name-taken", "name: another team has it");
  }
}

std::string add_organiser(Database& database, const std::string& label, std::int64_t now,
                          std::optional<std::int64_t> expires) {
  return database.transact([&](SQLite::Database& db) {
    return insert_token(db, Role::kOrganiser, std::nullopt, label, now, expires);
  });
}

std::optional<Principal> find_token(Database& database, std::string_view token, std::int64_t now) {
  return find_principal(database, std::string(kPrincipal) + "WHERE token.hash = ?1" + kValid, token,
                        now);
}

std::string start_session(Database& database, const Principal& who, std::int64_t now) {
  const std::string secret = new_secret("");
  database.transact([&](SQLite::Database& db) {
    SQLite::Statement clean(db, "DELETE FROM session WHERE expires <= ?");
    clean.bind(1, now);
    clean.exec();
    SQLite::Statement insert(db, "INSERT INTO session (hash, token, expires) VALUES (?, ?, ?)");
    insert.bind(1, sha256(secret));
    insert.bind(2, who.token);
    insert.bind(3, now + kSessionSeconds);
    insert.exec();
  });
  return secret;
}

std::optional<Principal> find_session(Database& database, std::string_view secret,
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

void end_sessions(Database& database, std::int64_t token) {
  database.transact([&](SQLite::Database& db) {
    SQLite::Statement remove(db, "DELETE FROM session WHERE token = ?");
    remove.bind(1, token);
    remove.exec();
  });
}

}  // namespace enfilade::service::detail
