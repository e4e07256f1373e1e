#include "enfilade/service/store/database.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ranges>
#include <system_error>

#include "enfilade/core/errors.h"
#include "enfilade/service/store/schema.h"

namespace enfilade::service::store {
namespace {

namespace fs = std::filesystem;

constexpr int kBusyMilliseconds = 10'000;  // a backup holds the file for far less

SQLite::Database open_file(const fs::path& file, int flags) {
  try {
    return SQLite::Database(file.string(), flags, kBusyMilliseconds);
  } catch (const SQLite::Exception& error) {
    throw FileError(
        fmt::format("{}: cannot be opened as a database: {}", file.string(), error.what()));
  }
}

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

Database::Database(const fs::path& file, std::function<std::int64_t()> clock)
    : file_(file.string()),
      clock_(std::move(clock)),
      db_(open_file(file, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)) {
  try {
    db_.exec("PRAGMA journal_mode = WAL");
    // Acknowledged changes survive a power failure, not only a crash of the process.
    db_.exec("PRAGMA synchronous = FULL");
    db_.exec("PRAGMA foreign_keys = ON");
    migrate();
  } catch (const SQLite::Exception& error) {
    throw FileError(fmt::format("{}: not a usable database: {}", file_, error.what()));
  }
}

void Database::migrate() {
  const int version = db_.execAndGet("PRAGMA user_version").getInt();
  const int newest = static_cast<int>(kMigrations.size());
  if (version > newest) {
    throw FileError(
        fmt::format("{}: its schema has version {}, and this program knows up to {}; "
                    "use the newer Enfilade that made it",
                    file_, version, newest));
  }
  for (int k = version; k < newest; ++k) {
    SQLite::Transaction transaction(db_, SQLite::TransactionBehavior::IMMEDIATE);
    db_.exec(kMigrations[static_cast<std::size_t>(k)]);
    db_.exec(fmt::format("PRAGMA user_version = {}", k + 1));
    transaction.commit();
  }
}

void back_up(const fs::path& database, const fs::path& copy) {
  SQLite::Database from = open_file(database, SQLite::OPEN_READWRITE);
  fs::path part = copy;
  part += ".part";
  std::error_code error;
  fs::remove(part, error);
  try {
    SQLite::Statement statement(from, "VACUUM INTO ?");
    statement.bind(1, part.string());
    statement.exec();
  } catch (const SQLite::Exception& failure) {
    throw FileError(fmt::format("{}: cannot be backed up to {}: {}", database.string(),
                                copy.string(), failure.what()));
  }
  fs::rename(part, copy, error);
  if (error) throw FileError(fmt::format("{}: {}", copy.string(), error.message()));
}

}  // namespace enfilade::service::store
