#include "enfilade/service/store/database.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <ranges>
#include <system_error>

#include "enfilade/core/errors.h"
#include "enfilade/service/store/schema.h"

namespace enfilade::service::store {
namespace {

namespace fs = std::filesystem;

constexpr int kBusyMilliseconds = 10'000;  // a backup holds the file for far less

constexpr std::size_t kMostStatements = 500;

constexpr mode_t kOwnersRights = S_IRUSR | S_IWUSR | S_IXUSR;

// "ENFI": by it, `file` and other programs tell the database from any other one of SQLite's.
constexpr int kApplicationId = 0x454e4649;

// Makes an empty file that only its owner may read, unless there is one: SQLite itself would go by
// the umask. It gives its -wal and -shm the rights of the database. A file that is there is not
// opened: closing it would drop the locks that SQLite has on it in this process.
void create_private(const fs::path& file) {
  const int descriptor =
      ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (descriptor >= 0) ::close(descriptor);  // else SQLite will say what is wrong
}

void close_to_others(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return;
  constexpr mode_t kAllRights = S_IRWXU | S_IRWXG | S_IRWXO;
  if ((status.st_mode & kAllRights & ~kOwnersRights) == 0) return;
  if (::chmod(file.c_str(), status.st_mode & kOwnersRights) != 0) {
    throw FileError(fmt::format(
        "{}: others on this machine may read it, and its rights cannot be changed ({}); its owner "
        "can: chmod 600",
        file.string(), std::generic_category().message(errno)));
  }
}

fs::path with_suffix(fs::path file, const char* suffix) { return file += suffix; }

std::pair<std::uint64_t, std::uint64_t> identity_of(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino};
}

SQLite::Database open_file(const fs::path& file, int flags) {
  try {
    return SQLite::Database(file.string(), flags, kBusyMilliseconds);
  } catch (const SQLite::Exception& error) {
    throw FileError(
        fmt::format("{}: cannot be opened as a database: {}", file.string(), error.what()));
  }
}

SQLite::Database open_or_create(const fs::path& file) {
  create_private(file);
  return open_file(file, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
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
    : file_(file),
      clock_(std::move(clock)),
      db_(open_or_create(file)),
      identity_(identity_of(file)) {
  try {
    db_.exec("PRAGMA journal_mode = WAL");
    // Acknowledged changes survive a power failure, not only a crash of the process.
    db_.exec("PRAGMA synchronous = FULL");
    db_.exec("PRAGMA foreign_keys = ON");
    migrate();
    check_writable();  // SQLite opens a file that it may not write as one to read
  } catch (const SQLite::Exception& error) {
    throw FileError(fmt::format("{}: not a usable database: {}", file_.string(), error.what()));
  }
  for (const char* suffix : {"", "-wal", "-shm"}) close_to_others(with_suffix(file_, suffix));
}

void Database::EndUse::operator()(SQLite::Statement* statement) const noexcept {
  statement->tryReset();
  statement->clearBindings();
}

// \pre no other statement is in use
SQLite::Statement& Database::prepared(const std::string& sql) {
  const auto known = statements_.find(sql);
  if (known != statements_.end()) return known->second;
  if (statements_.size() == kMostStatements) statements_.clear();  // some text has values in it
  return statements_.try_emplace(sql, db_, sql).first->second;
}

bool Database::is_in_place() const { return identity_of(file_) == identity_; }

void Database::check_readable() const {
  // This connection has pages in memory, and would not notice that the file has been overwritten.
  SQLite::Database fresh = open_file(file_, SQLite::OPEN_READWRITE);
  SQLite::Statement tables(fresh, "SELECT name FROM sqlite_schema WHERE type = 'table'");
  while (tables.executeStep()) {
    const std::string name = tables.getColumn(0).getString();
    SQLite::Statement(fresh, fmt::format("SELECT * FROM \"{}\" LIMIT 1", name)).executeStep();
  }
}

// SQLite writes the page even if it stays the same. The schema's version would do too, but another
// program may be changing that.
void Database::check_writable() { run(fmt::format("PRAGMA application_id = {}", kApplicationId)); }

void Database::migrate() {
  const int version = db_.execAndGet("PRAGMA user_version").getInt();
  const int newest = static_cast<int>(kMigrations.size());
  if (version > newest) {
    throw FileError(
        fmt::format("{}: its schema has version {}, and this program knows up to {}; "
                    "use the newer Enfilade that made it",
                    file_.string(), version, newest));
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
  const fs::path part = with_suffix(copy, ".part");
  std::error_code error;
  fs::remove(part, error);
  create_private(part);  // VACUUM INTO takes an empty file
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
