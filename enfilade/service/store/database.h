/// \file  The one database of a server: SQLite in WAL mode.
#pragma once
#include <SQLiteCpp/SQLiteCpp.h>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/store/sql.h"

namespace enfilade::service::store {

/// One connection, used by one thread at a time: SQLite serialises writes anyway, and reads here
/// are of a few rows. All functions may be called from any thread, and wait for the thread that
/// holds the connection. What they return are copies, which stay valid.
///
/// All functions that run a statement \throw SQLite::Exception, a std::runtime_error with SQLite's
/// message, if it fails; Error for a stored name of an enumeration that this program does not know.
class Database {
 public:
  /// Opens the file, creates it if it is missing, and brings its schema up to date, each migration
  /// in a transaction of its own.
  /// \param clock returns seconds since 1970, and may be called from any thread; empty: the
  /// system's clock
  /// \throws FileError if it can't be opened, or was made by a newer Enfilade
  explicit Database(const std::filesystem::path& file, std::function<std::int64_t()> clock = {});

  /// Seconds since 1970, by the clock of the constructor.
  std::int64_t now() const { return clock_ ? clock_() : std::time(nullptr); }

  /// Runs a statement that has no rows to read. The values are bound to its question marks, in
  /// their order or by number (?1, ?2). \returns how many rows it inserted, updated or deleted
  template <class... Values>
  int run(const std::string& sql, const Values&... values) {
    const auto held = hold();
    SQLite::Statement statement = prepare(sql, values...);
    return statement.exec();
  }
  /// As run(), for an INSERT. \returns the new row's id
  template <class... Values>
  std::int64_t insert(const std::string& sql, const Values&... values) {
    const auto held = hold();
    run(sql, values...);
    return db_.getLastInsertRowid();
  }
  /// All rows of a SELECT, each read into a T by Row::read(). The values are bound as in run().
  template <class T, class... Values>
  std::vector<T> select(const std::string& sql, const Values&... values) {
    const auto held = hold();
    SQLite::Statement statement = prepare(sql, values...);
    std::vector<T> found;
    while (statement.executeStep()) Row(statement).read(found.emplace_back());
    return found;
  }
  /// The first row of a SELECT; none if it has no row.
  template <class T, class... Values>
  std::optional<T> find(const std::string& sql, const Values&... values) {
    const auto held = hold();
    SQLite::Statement statement = prepare(sql, values...);
    std::optional<T> found;
    if (statement.executeStep()) Row(statement).read(found.emplace());
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

  /// Calls change() in a transaction, and returns what it returns. All statements that it runs are
  /// on the disk when this returns; if it throws, the database stays as it was, and the exception
  /// is passed on. Other threads wait meanwhile. \pre not within another transaction
  template <class Change>
  auto transact(Change&& change) {
    const auto held = hold();
    SQLite::Transaction transaction(db_, SQLite::TransactionBehavior::IMMEDIATE);
    if constexpr (std::is_void_v<std::invoke_result_t<Change>>) {
      std::forward<Change>(change)();
      transaction.commit();
    } else {
      auto result = std::forward<Change>(change)();
      transaction.commit();
      return result;
    }
  }
  /// Other threads wait for as long as the returned lock lives, so that several reads see the same
  /// state. The thread that has it may go on calling all functions. \pre *this outlives the lock
  std::unique_lock<std::recursive_mutex> hold() { return std::unique_lock(mutex_); }

 private:
  template <class... Values>
  SQLite::Statement prepare(const std::string& sql, const Values&... values) {
    SQLite::Statement statement(db_, sql);
    int k = 0;
    (bind(statement, ++k, values), ...);
    return statement;
  }
  void migrate();

  std::recursive_mutex mutex_;
  std::string file_;
  std::function<std::int64_t()> clock_;
  SQLite::Database db_;
};

/// Copies a database, also while a server uses it. The copy is written beside its place and then
/// renamed, so that it is never there in part; an older copy of that name is replaced.
/// \throws FileError naming the file that cannot be opened, read or written
void back_up(const std::filesystem::path& database, const std::filesystem::path& copy);

}  // namespace enfilade::service::store
