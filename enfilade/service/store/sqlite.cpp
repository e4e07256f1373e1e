#include "enfilade/service/store/database.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "enfilade/core/names.h"

namespace enfilade::service::store {
namespace {

namespace fs = std::filesystem;

constexpr int kSqliteBusy = 5, kSqliteFull = 13;  // SQLITE_BUSY and SQLITE_FULL of <sqlite3.h>

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

std::vector<std::string> tables_of(SQLite::Database& db) {
  SQLite::Statement tables(
      db, "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'");
  std::vector<std::string> names;
  while (tables.executeStep()) names.push_back(tables.getColumn(0).getString());
  return names;
}

/// A file for SQLite's reading alone, of which nothing is locked, and nothing is left beside it.
std::string immutable(const fs::path& file) {
  std::string address = "file:";
  for (const char c : file.string()) {
    const bool special = c == '%' || c == '?' || c == '#';
    address += special ? fmt::format("%{:02x}", c) : std::string(1, c);
  }
  return address + "?immutable=1";
}

/// What is another program's about a database; empty for one of ours, and for one of nobody's.
std::string foreign_part(SQLite::Database& db) {
  db.exec("BEGIN");  // so that what another process writes is seen as a whole
  const int id = db.execAndGet("PRAGMA application_id").getInt();
  if (id == kApplicationId) return "";
  if (id != 0) return fmt::format("its application_id is {}", id);
  const std::vector<std::string> tables = tables_of(db);
  if (tables.empty()) return "";
  const int version = db.execAndGet("PRAGMA user_version").getInt();
  // The first two versions of the schema had no id.
  const auto is_there = [&](const std::string& name) {
    return std::ranges::find(tables, name) != tables.end();
  };
  const bool old = version >= 1 && std::ranges::all_of(schema_tables(1), is_there);
  return old ? "" : fmt::format("it has a table {}", quote(tables.front()));
}

/// What is another program's about a file that is there. \throws SQLite::Exception
std::string foreign_part(const fs::path& file) {
  // A connection that only reads would leave the files of a log behind. So it reads no log, unless
  // one is in use, or may have all that there is.
  const auto part_of = [](const std::string& name, int flags) {
    SQLite::Database db(name, SQLite::OPEN_READONLY | flags, kBusyMilliseconds);
    return foreign_part(db);
  };
  if (fs::exists(with_suffix(file, "-shm"))) return part_of(file.string(), 0);
  const std::string part = part_of(immutable(file), SQLite::OPEN_URI);
  return part.empty() && fs::exists(with_suffix(file, "-wal")) ? part_of(file.string(), 0) : part;
}

/// Refuses what another program has made, and leaves it as it is. A missing file and an empty one
/// are nobody's. \throws FileError
void check_ours(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  const bool regular = fs::is_regular_file(status);
  if (!fs::exists(status) || (regular && fs::file_size(file, error) == 0)) return;
  std::string fault = "no regular file";
  try {
    if (regular) fault = foreign_part(fs::canonical(file));
  } catch (const SQLite::Exception& failure) {
    throw FileError(fmt::format("{}: not a usable database: {}", file.string(), failure.what()));
  }
  if (fault.empty()) return;
  throw FileError(
      fmt::format("{}: not a database of Enfilade ({}); it was not changed", file.string(), fault));
}

using Identity = std::pair<std::uint64_t, std::uint64_t>;  // device and inode
Identity identity_of(const fs::path& file) {
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
  check_ours(file);
  create_private(file);
  return open_file(file, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
}

/// Does something with SQLite. \throws DatabaseError for what SQLite throws
template <class Do>
auto told(const Do& something) {
  try {
    return something();
  } catch (const SQLite::Exception& error) {
    throw DatabaseError(error.getErrorCode() == kSqliteFull ? DatabaseError::Cause::kDiskFull
                                                            : DatabaseError::Cause::kStatement,
                        error.what());
  }
}

void bind(SQLite::Statement& statement, int k, const Parameter& value) {
  const auto bind_one = [&](const auto& one) {
    using Value = std::remove_cvref_t<decltype(one)>;
    if constexpr (std::same_as<Value, std::monostate>) {
      statement.bind(k);
    } else if constexpr (std::same_as<Value, std::string_view>) {
      statement.bind(k, one.data(), static_cast<int>(one.size()));
    } else {
      statement.bind(k, one);
    }
  };
  std::visit(bind_one, value.value);
}

// Ends the use of a statement, not the statement: it holds no lock and no values then.
struct EndUse {
  void operator()(SQLite::Statement* statement) const noexcept {
    statement->tryReset();
    statement->clearBindings();
  }
};
using Use = std::unique_ptr<SQLite::Statement, EndUse>;

class SqliteRows final : public ResultSet {
 public:
  explicit SqliteRows(Use use) : use_(std::move(use)) {}

  bool next() override {
    return told([this] { return use_->executeStep(); });
  }
  int columns() const override { return use_->getColumnCount(); }
  bool is_null(int column) const override { return use_->isColumnNull(column); }
  std::int64_t integer(int column) const override { return use_->getColumn(column).getInt64(); }
  double real(int column) const override { return use_->getColumn(column).getDouble(); }
  std::string text(int column) const override { return use_->getColumn(column).getString(); }

 private:
  Use use_;
};

class SqliteConnection final : public Connection {
 public:
  explicit SqliteConnection(const fs::path& file)
      : file_(file), db_(open_or_create(file)), identity_(identity_of(file)) {
    told([this] {
      use_log();
      // Acknowledged changes survive a power failure, not only a crash of the process.
      db_.exec("PRAGMA synchronous = FULL");
      db_.exec("PRAGMA foreign_keys = ON");
    });
    set_application_id();  // SQLite opens a file that it may not write as one to read
    for (const char* suffix : {"", "-wal", "-shm"}) close_to_others(with_suffix(file_, suffix));
  }

  void begin() override { exec("BEGIN IMMEDIATE"); }
  void commit() override { exec("COMMIT"); }
  void roll_back() noexcept override { db_.tryExec("ROLLBACK"); }
  int run(const std::string& sql, std::span<const Parameter> values) override {
    return told([&] { return prepare(sql, values)->exec(); });
  }
  std::unique_ptr<ResultSet> select(const std::string& sql,
                                    std::span<const Parameter> values) override {
    return std::make_unique<SqliteRows>(told([&] { return prepare(sql, values); }));
  }

  int version() override {
    return told([this] { return db_.execAndGet("PRAGMA user_version").getInt(); });
  }
  void migrate(const char* script, int version) override {
    exec(script);
    exec(fmt::format("PRAGMA user_version = {}", version));
  }

  std::vector<std::string> tables() override {
    return told([this] { return tables_of(db_); });
  }

  bool is_in_place() const override { return identity_of(file_) == identity_; }
  void check_readable() override {
    // This connection has pages in memory, and would not notice that the file has been overwritten.
    SQLite::Database fresh = open_file(file_, SQLite::OPEN_READWRITE);
    told([&fresh] {
      for (const std::string& name : tables_of(fresh)) {
        SQLite::Statement(fresh, fmt::format("SELECT * FROM \"{}\" LIMIT 1", name)).executeStep();
      }
    });
  }
  // SQLite writes the page even if it stays the same. The schema's version would do too, but
  // another program may be changing that.
  void check_writable() override { set_application_id(); }
  std::optional<std::uint64_t> free_bytes() const override {
    struct statvfs disk {};
    if (::statvfs(file_.c_str(), &disk) != 0) return std::nullopt;
    return std::uint64_t{disk.f_bavail} * disk.f_frsize;
  }

 private:
  void exec(const std::string& sql) {
    told([&] { db_.exec(sql); });
  }
  // Of two programs that turn a new file's log on at once, each would wait for the other, so that
  // SQLite does not let them wait.
  void use_log() {
    const auto end =
        std::chrono::steady_clock::now() + std::chrono::milliseconds(kBusyMilliseconds);
    for (;;) {
      try {
        db_.exec("PRAGMA journal_mode = WAL");
        return;
      } catch (const SQLite::Exception& error) {
        if (error.getErrorCode() != kSqliteBusy || std::chrono::steady_clock::now() > end) throw;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  void set_application_id() { exec(fmt::format("PRAGMA application_id = {}", kApplicationId)); }
  Use prepare(const std::string& sql, std::span<const Parameter> values) {
    Use use(&prepared(sql));
    int k = 0;
    for (const Parameter& value : values) bind(*use, ++k, value);
    return use;
  }
  // \pre no other statement is in use
  SQLite::Statement& prepared(const std::string& sql) {
    const auto known = statements_.find(sql);
    if (known != statements_.end()) return known->second;
    if (statements_.size() == kMostStatements) statements_.clear();
    return statements_.try_emplace(sql, db_, sql).first->second;
  }

  fs::path file_;
  SQLite::Database db_;
  Identity identity_;  // as it was opened
  // By their texts: to prepare one takes longer than to run it.
  std::unordered_map<std::string, SQLite::Statement> statements_;
};

}  // namespace

std::unique_ptr<Connection> open_sqlite(const fs::path& file) {
  return std::make_unique<SqliteConnection>(file);
}

std::vector<std::string> schema_tables(std::size_t version) {
  SQLite::Database db(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  for (const char* script : std::span(kMigrations).first(version)) db.exec(script);
  return tables_of(db);
}

void back_up(const fs::path& database, const fs::path& copy) {
  for (const fs::path& file : {database, copy}) check_ours(file);
  std::error_code error;
  if (fs::equivalent(database, copy, error) || fs::exists(with_suffix(copy, "-wal"), error) ||
      fs::exists(with_suffix(copy, "-shm"), error)) {
    throw FileError(fmt::format("{}: a database in use, not a copy", copy.string()));
  }
  SQLite::Database from = open_file(database, SQLite::OPEN_READWRITE);
  const fs::path part = with_suffix(copy, ".part");
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
