#include "enfilade/service/store/database.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <ranges>
#include <utility>

namespace enfilade::service::store {
namespace {

constexpr std::string_view kSchemeEnd = "://";

/// "USER:PASSWORD" of a URL. The last @ ends it, for passwords in which signs were not escaped.
std::string_view user_of(std::string_view url) {
  const std::string_view rest = url.substr(url.find(kSchemeEnd) + kSchemeEnd.size());
  const std::size_t at = rest.rfind('@');
  return at == std::string_view::npos ? std::string_view{} : rest.substr(0, at);
}

constexpr std::chrono::seconds kBetweenLooks{1};  // monitors ask less often, floods gain nothing

}  // namespace

std::string join_lines(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, "\n"));
}

std::vector<std::string> split_lines(std::string_view text) {
  std::vector<std::string> lines;
  for (const auto line : std::views::split(text, '\n'))
    lines.emplace_back(line.begin(), line.end());
  return lines;
}

Database::Database(const std::string& place, std::function<std::int64_t()> clock)
    : shown_(shown(place)), clock_(std::move(clock)) {
  try {
    connection_ = connect(place);
    migrate();
    if (const std::string table = missing_table(); !table.empty()) {
      throw FileError(
          fmt::format("{}: its table {} is missing; use its last backup", shown_, table));
    }
    check_writable();  // a standby of PostgreSQL can only be read
  } catch (const DatabaseError& error) {
    throw FileError(fmt::format("{}: not a usable database: {}", shown_, error.what()));
  }
}

void Database::check_readable() {
  const auto held = hold();
  connection_->check_readable();
}

void Database::check_writable() {
  change([this] { connection_->check_writable(); });
}

std::string Database::missing_table() {
  static const std::vector<std::string> kTables = schema_tables();
  const auto held = hold();
  const std::vector<std::string> found = connection_->tables();
  const auto missing = std::ranges::find_if_not(kTables, [&](const std::string& name) {
    return std::ranges::find(found, name) != found.end();
  });
  return missing == kTables.end() ? "" : *missing;
}

void Database::check_no_tables() {
  const std::vector<std::string> ours = schema_tables();
  for (const std::string& table : connection_->tables()) {
    if (std::ranges::find(ours, table) == ours.end()) continue;
    throw FileError(
        fmt::format("{}: another program has a table {} there; use a database or a schema of "
                    "Enfilade's own",
                    shown_, table));
  }
}

void Database::migrate() {
  const int newest = static_cast<int>(kMigrations.size());
  int version = connection_->version();
  while (version < newest) {
    version = transact([this] {  // another program may have done it by now
      const int found = connection_->version();
      if (found >= static_cast<int>(kMigrations.size())) return found;
      if (found == 0) check_no_tables();
      connection_->migrate(kMigrations[static_cast<std::size_t>(found)], found + 1);
      return found + 1;
    });
  }
  if (version > newest) {
    throw FileError(
        fmt::format("{}: its schema has version {}, and this program knows up to {}; "
                    "use the newer Enfilade that made it",
                    shown_, version, newest));
  }
}

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

std::optional<Trouble> trouble_of(const std::exception& error) noexcept {
  const auto* thrown = dynamic_cast<const DatabaseError*>(&error);
  if (thrown == nullptr) return std::nullopt;
  using Cause = DatabaseError::Cause;
  if (thrown->cause() == Cause::kDiskFull) return Trouble::kDiskFull;
  if (thrown->cause() == Cause::kUnreachable) return Trouble::kDatabaseUnreachable;
  return std::nullopt;
}

Health::Health(Database& db, std::uint64_t least_free_bytes, Report report)
    : db_(db), least_free_bytes_(least_free_bytes), report_(std::move(report)) {}

std::optional<Trouble> Health::trouble() {
  const std::scoped_lock lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (looked_.time_since_epoch().count() != 0 && now - looked_ < kBetweenLooks) return seen_;
  const std::optional<HealthFault> fault = look();
  const std::optional<Trouble> trouble =
      fault ? std::optional(fault->trouble) : std::optional<Trouble>();
  if (report_ && trouble != seen_) {
    report_(fault ? fmt::format("{}: {}", enum_name(fault->trouble), fault->details) : "");
  }
  seen_ = trouble;
  looked_ = std::chrono::steady_clock::now();
  return seen_;
}

std::string Health::missing_table() {
  const std::scoped_lock lock(mutex_);
  return missing_table_;
}

std::optional<Health::HealthFault> Health::look() {
  missing_table_.clear();
  const auto fault = [this](Trouble trouble, std::string_view details) {
    return HealthFault{trouble, fmt::format("{}: {}", db_.shown_place(), details)};
  };
  if (!db_.is_in_place()) {
    return fault(Trouble::kDatabaseReplaced,
                 "is no longer the file that was opened; start the server again");
  }
  // SQLite may still write: it uses its log again and again, whose room it has.
  if (const auto free = db_.free_bytes(); free && *free < least_free_bytes_) {
    return fault(Trouble::kDiskFull, fmt::format("{} bytes are free on its disk, at least {} "
                                                 "should be",
                                                 *free, least_free_bytes_));
  }
  Trouble otherwise = Trouble::kDatabaseUnreadable;
  try {
    db_.check_readable();
    missing_table_ = db_.missing_table();
    if (!missing_table_.empty()) {
      return fault(Trouble::kTableMissing, fmt::format("its table {} is missing", missing_table_));
    }
    otherwise = Trouble::kDatabaseUnwritable;
    db_.check_writable();
  } catch (const std::exception& error) {
    return fault(trouble_of(error).value_or(otherwise), error.what());
  }
  return std::nullopt;
}

}  // namespace enfilade::service::store
