/// \file  The one database of a server: a file of SQLite, or a database of PostgreSQL that several
/// servers may share. Health reports whether it and its disk do their work.
#pragma once
#include <array>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <ctime>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/progress.h"

namespace enfilade::service::store {

/// A statement failed, or the database cannot be reached; what() has the database's own words.
class DatabaseError : public Error {
 public:
  enum class Cause : std::uint8_t {
    kStatement,    ///< of the statement, or of the database's files
    kNoText,       ///< a text has a NUL, or is no UTF-8: PostgreSQL cannot hold it
    kDiskFull,     ///< the database found no room on its disk
    kUnreachable,  ///< the connection to a server is lost, or cannot be made; trying again may help
  };
  DatabaseError(Cause cause, const std::string& what) : Error(what), cause_(cause) {}
  Cause cause() const noexcept { return cause_; }

 private:
  Cause cause_;
};

/// How long a change waits for the changes of other programs before it fails.
inline constexpr int kBusyMilliseconds = 10'000;
/// Statements that a connection keeps prepared. There are fewer texts, unless some have values in
/// them.
inline constexpr std::size_t kMostStatements = 500;

/// One value for a statement.
struct Parameter {
  enum class ValueType : std::uint8_t { kInteger, kReal, kText, kBytes };

  ValueType type = ValueType::kInteger;  ///< also of a NULL
  /// By type; bytes stay the caller's.
  std::variant<std::monostate, std::int64_t, double, std::string, std::string_view> value = {};
};

/// The rows of a statement, from the first on. Columns count from 0.
class ResultSet {
 public:
  virtual ~ResultSet() = default;
  virtual bool next() = 0;  ///< goes to the next row (at first: to the first); false at the end
  virtual int columns() const = 0;
  virtual bool is_null(int column) const = 0;
  virtual std::int64_t integer(int column) const = 0;  ///< of a truth value 0 or 1
  virtual double real(int column) const = 0;
  virtual std::string text(int column) const = 0;  ///< or bytes
};

/// A connection, used by one thread at a time. Statements mark their values ?, or ?1, ?2. All
/// functions but the destructor and roll_back() \throw DatabaseError if they fail.
class Connection {
 public:
  virtual ~Connection() = default;

  /// Begins a transaction, after the end of every other one that changes something. Reads in it see
  /// the same state until its end.
  /// \pre in no transaction
  virtual void begin() = 0;
  /// All changes of the transaction are on the disk when this returns. \pre in a transaction
  virtual void commit() = 0;
  virtual void roll_back() noexcept = 0;
  /// \pre in a transaction  \returns how many rows were inserted, updated or deleted
  virtual int run(const std::string& sql, std::span<const Parameter> values) = 0;
  /// \returns the rows, to be read before the next statement
  virtual std::unique_ptr<ResultSet> select(const std::string& sql,
                                            std::span<const Parameter> values) = 0;

  /// Version of the schema (kMigrations); 0: there are no tables yet.
  virtual int version() = 0;
  /// Runs a migration, and sets the version. \pre in a transaction
  virtual void migrate(const char* script, int version) = 0;
  /// Names of the tables that are there now, other programs' too.
  virtual std::vector<std::string> tables() = 0;

  /// Whether a file that was opened is still there under its name: of one that was removed or
  /// replaced, all that is written is lost. Always so of a server.
  virtual bool is_in_place() const = 0;
  /// Reads a row of every table, not from this process's memory. \throws FileError too
  virtual void check_readable() = 0;
  /// Writes a few unimportant bytes to the disk. \pre in a transaction
  virtual void check_writable() = 0;
  /// Free bytes on the database's disk, for this process; no value if unknown.
  virtual std::optional<std::uint64_t> free_bytes() const = 0;
};

/// Whether a place names a database of PostgreSQL (postgresql://USER@HOST/NAME, or postgres://)
/// rather than a file of SQLite.
bool is_url(std::string_view place);
/// Whether a URL has a password in it.
bool has_password(std::string_view place);
/// A place as logs and messages may have it: without password and options.
std::string shown(std::string_view place);

/// Opens a place; a file is made if it is missing. \throws FileError if that fails, or if this
/// build has no PostgreSQL
std::unique_ptr<Connection> connect(const std::string& place);

/// Connects to a URL as libpq reads it; missing parts come from libpq's environment and files
/// (PGPASSWORD, ~/.pgpass).
/// \throws FileError if the server cannot be reached, refuses, or has a database of another
/// encoding than UTF-8; also if this build has no PostgreSQL. No message has a password
std::unique_ptr<Connection> connect_to_postgres(const std::string& url);

/// Opens a file, and makes it if it is missing. Only its owner may read it then: it has people's
/// texts and secret goals. An existing file that others may read is closed to them. A database of
/// another program is not changed, nor are its rights.
/// \throws FileError if it can't be opened or written, is another program's, or others may read it
/// and that can't be changed
std::unique_ptr<Connection> open_sqlite(const std::filesystem::path& file);

/// Copies a file's database, also while a server uses it. The copy is written beside its
/// destination and then renamed, so that it is never there in part. An older copy of that name is
/// replaced, another file is not, nor a database in use. Only its owner may read it.
/// \throws FileError naming the file that cannot be opened, read or written, is no database of
/// Enfilade, or is in use
void back_up(const std::filesystem::path& database, const std::filesystem::path& copy);

/// Bytes for a column of type BLOB.
struct Blob {
  std::string_view bytes;
};

/// How a list is stored: one entry per line. \pre no entry is empty or has a line break
std::string join_lines(const std::vector<std::string>& lines);
std::vector<std::string> split_lines(std::string_view text);

/// A C++ value for a statement.
template <class T>
struct ToParameter {
  static constexpr Parameter::ValueType kType =
      std::integral<T>         ? Parameter::ValueType::kInteger
      : std::floating_point<T> ? Parameter::ValueType::kReal
      : std::same_as<T, Blob>  ? Parameter::ValueType::kBytes
                               : Parameter::ValueType::kText;

  static Parameter of(const T& value) {
    if constexpr (std::integral<T>) {
      return {kType, static_cast<std::int64_t>(value)};
    } else if constexpr (std::floating_point<T>) {
      return {kType, static_cast<double>(value)};
    } else if constexpr (NamedEnum<T>) {
      return {kType, std::string(enum_name(value))};
    } else if constexpr (std::same_as<T, std::vector<std::string>>) {
      return {kType, join_lines(value)};
    } else if constexpr (std::same_as<T, Blob>) {
      return {kType, value.bytes};
    } else {
      return {kType, std::string(value)};
    }
  }
};
/// None is NULL.
template <class T>
struct ToParameter<std::optional<T>> {
  static Parameter of(const std::optional<T>& value) {
    return value ? ToParameter<T>::of(*value) : Parameter{ToParameter<T>::kType};
  }
};

/// The columns of a row, read from left to right. A struct has `auto columns()`, which gives
/// std::tie() of its fields in the order of the columns.
class Row {
 public:
  explicit Row(const ResultSet& rows) : rows_(rows) {}

  /// read(), for a T that all columns belong to.
  template <class T>
  void read_whole(T& value) {
    read(value);
    EN_CHECK_EQ(column_, rows_.columns());
  }

  template <class T>
  void read(T& value) {
    if constexpr (requires { value.columns(); }) {
      auto fields = value.columns();
      read(fields);
    } else if constexpr (std::integral<T>) {
      value = static_cast<T>(rows_.integer(column_++));
    } else if constexpr (std::floating_point<T>) {
      value = rows_.real(column_++);
    } else if constexpr (NamedEnum<T>) {
      const auto found = find_enum<T>(rows_.text(column_++));
      if (!found) throw Error("the database has a name that this program does not know");
      value = *found;
    } else if constexpr (std::same_as<T, std::vector<std::string>>) {
      value = split_lines(rows_.text(column_++));
    } else {
      value = rows_.text(column_++);
    }
  }
  template <class T>
  void read(std::optional<T>& value) {
    value.reset();
    if (rows_.is_null(column_)) {
      ++column_;
    } else {
      read(value.emplace());
    }
  }
  template <class... T>
  void read(std::tuple<T...>& values) {
    std::apply([this](auto&... value) { (this->read(value), ...); }, values);
  }

 private:
  const ResultSet& rows_;
  int column_ = 0;
};

/// Migration k takes a database of version k to version k + 1. A released migration never
/// changes: a change of the schema is a new one at the end. Times are seconds since 1970. Written
/// as SQLite reads it; postgres.cpp replaces the few words that PostgreSQL has otherwise.
extern const std::array<const char*, 8> kMigrations;
/// Names of the tables of a version of the schema, as SQLite makes them.
std::vector<std::string> schema_tables(std::size_t version = kMigrations.size());

/// One connection, used by one thread at a time: changes wait for each other anyway, and reads are
/// of a few rows. All functions may be called from any thread, and wait for the thread that holds
/// the connection. They return copies, which stay valid.
///
/// SQL is in the common part of SQLite and PostgreSQL. All functions that run a statement throw
/// DatabaseError if it fails. They throw Error for a stored name of an enumeration that this
/// program does not have. If a server of PostgreSQL was lost, the next statement connects again.
class Database {
 public:
  /// Opens a place (connect()), creates the file if it is missing, and brings the schema up to
  /// date. Each migration has a transaction of its own; of several programs at once one does it.
  /// \param clock returns seconds since 1970, and may be called from any thread; empty: the
  /// system's clock
  /// \throws FileError if it can't be opened, written or closed to others, lacks a table, or is of
  /// another program or a newer Enfilade
  explicit Database(const std::string& place, std::function<std::int64_t()> clock = {});

  /// Seconds since 1970, by the clock of the constructor.
  std::int64_t now() const { return clock_ ? clock_() : std::time(nullptr); }

  /// Runs a statement that has no rows to read, in a transaction of its own unless it is in one.
  /// The values are bound to its question marks, in their order or by number (?1, ?2).
  /// \returns how many rows it inserted, updated or deleted
  template <class... Values>
  int run(const std::string& sql, const Values&... values) {
    return change([&] { return connection_->run(sql, parameters(values...)); });
  }
  /// As run(), for an INSERT into a table with a column `id`. \returns the new row's id
  template <class... Values>
  std::int64_t insert(const std::string& sql, const Values&... values) {
    return change([&] { return get<std::int64_t>(sql + " RETURNING id", values...); });
  }
  /// All rows of a SELECT, each read into a T by Row::read(). The values are bound as in run().
  template <class T, class... Values>
  std::vector<T> select(const std::string& sql, const Values&... values) {
    const auto held = hold();
    const auto rows = connection_->select(sql, parameters(values...));
    std::vector<T> found;
    while (rows->next()) Row(*rows).read_whole(found.emplace_back());
    return found;
  }
  /// The first row of a SELECT; none if it has no row.
  template <class T, class... Values>
  std::optional<T> find(const std::string& sql, const Values&... values) {
    const auto held = hold();
    const auto rows = connection_->select(sql, parameters(values...));
    std::optional<T> found;
    if (rows->next()) Row(*rows).read_whole(found.emplace());
    return found;
  }
  /// The only row of a SELECT. \throws LookupError if it has no row
  template <class T, class... Values>
  T get(const std::string& sql, const Values&... values) {
    std::optional<T> found = find<T>(sql, values...);
    if (!found) throw LookupError("no row in the database for: " + sql);
    return std::move(*found);
  }
  /// The first column of a SELECT's first row, a number; 0 if it has no row.
  template <class... Values>
  std::int64_t find_number(const std::string& sql, const Values&... values) {
    return find<std::int64_t>(sql, values...).value_or(0);
  }

  /// Calls change() in a transaction, and returns its result. All statements that it runs are on
  /// the disk when this returns. If it throws, the database does not change, and the exception is
  /// passed on. Other threads wait meanwhile, and so do changes of other programs.
  /// \pre not within another transaction
  template <class Change>
  auto transact(Change&& change) {
    const auto held = hold();
    connection_->begin();
    in_transaction_ = true;
    struct End {  // rolls back, unless it was committed
      Database& db;
      ~End() {
        if (db.in_transaction_) db.connection_->roll_back();
        db.in_transaction_ = false;
      }
    } const end{*this};
    if constexpr (std::is_void_v<std::invoke_result_t<Change>>) {
      std::forward<Change>(change)();
      commit();
    } else {
      auto result = std::forward<Change>(change)();
      commit();
      return result;
    }
  }
  /// Other threads wait for as long as the returned lock lives, so that no other change of this
  /// program comes between several reads. The thread that has it may go on calling all functions.
  /// \pre *this outlives the lock
  std::unique_lock<std::recursive_mutex> hold() { return std::unique_lock(mutex_); }

  /// For statements whose columns are known only at run time. \pre within transact()
  Connection& connection() noexcept { return *connection_; }

  /// The place, as logs and messages may have it.
  const std::string& shown_place() const noexcept { return shown_; }
  /// Connection's functions of the same names, also from any thread.
  bool is_in_place() const { return connection_->is_in_place(); }
  std::optional<std::uint64_t> free_bytes() const { return connection_->free_bytes(); }
  void check_readable();
  void check_writable();
  /// The first table of the schema that is not there; empty: all are.
  std::string missing_table();

 private:
  void commit() {
    connection_->commit();
    in_transaction_ = false;
  }

  template <class Change>
  auto change(const Change& change) {
    const auto held = hold();
    return in_transaction_ ? change() : transact(change);
  }
  template <class... Values>
  static std::array<Parameter, sizeof...(Values)> parameters(const Values&... values) {
    return {ToParameter<std::remove_cvref_t<Values>>::of(values)...};
  }
  void migrate();
  void check_no_tables();

  std::recursive_mutex mutex_;
  std::string shown_;
  std::function<std::int64_t()> clock_;
  std::unique_ptr<Connection> connection_;
  bool in_transaction_ = false;
};

/// Copies all rows of a file of SQLite into a database of PostgreSQL without rows. It is one
/// transaction: all are there when this returns, or none if it throws. The file's schema is brought
/// up to date, and no other process can change it meanwhile. New rows get ids that the file has
/// never given.
/// \param progress is called with rows
/// \returns the number of rows
/// \throws FileError for a place that cannot be opened, or a database that has rows
/// \throws Error naming the table of a row that cannot be stored
std::int64_t transfer(const std::string& file, const std::string& url, const Progress& progress);

/// Causes that keep a server from its work, in words that monitors may match.
enum class Trouble : std::uint8_t {
  kDiskFull,             ///< less room than stated is left, or the database found none
  kDatabaseReplaced,     ///< the file was moved, removed or replaced while it was open
  kDatabaseUnreadable,   ///< it cannot be opened, or a table of it cannot be read
  kDatabaseUnwritable,   ///< a small change of it did not reach the disk
  kDatabaseUnreachable,  ///< there is no connection to its server
  kTableMissing,         ///< another program has removed a table
};
constexpr std::array<std::string_view, 6> names_of(Trouble /*enum*/) {
  return {"disk-full",           "database-replaced",    "database-unreadable",
          "database-unwritable", "database-unreachable", "table-missing"};
}

/// The trouble behind an exception of a Database's functions; no value if the statement caused it.
std::optional<Trouble> trouble_of(const std::exception& error) noexcept;

/// Checks a database: reads from it, writes to it, and measures the free room of its disk. All
/// functions may be called from any thread.
class Health {
 public:
  /// Called when a trouble begins, with details that may name files of this machine, and with an
  /// empty text when it is over.
  using Report = std::function<void(std::string_view fault)>;

  /// \param least_free_bytes  less room than that on the database's disk is a trouble
  /// \pre `db` outlives *this
  Health(Database& db, std::uint64_t least_free_bytes, Report report = {});

  /// The trouble, if there is any. Checks at most once a second, which takes a few milliseconds
  /// (one `fsync`), and otherwise returns the last result.
  std::optional<Trouble> trouble();
  /// The table of Trouble::kTableMissing; empty unless trouble() has returned that last.
  std::string missing_table();

 private:
  struct HealthFault {
    Trouble trouble = Trouble::kDiskFull;
    std::string details;
  };
  std::optional<HealthFault> look();

  Database& db_;
  std::uint64_t least_free_bytes_;
  Report report_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point looked_;  // 0: never
  std::optional<Trouble> seen_;
  std::string missing_table_;
};

}  // namespace enfilade::service::store
