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

#include "enfilade/service/store/sql.h"

namespace enfilade::service::store {

/// One connection, used by one thread at a time: SQLite serialises writes anyway, and reads here
/// are of a few rows. All functions may be called from any thread. \throws std::runtime_error with
/// SQLite's message if a statement fails
class Database {
 public:
  /// Opens or makes the file, and brings its schema up to date, each migration in a transaction.
  /// \param clock seconds since 1970; empty: the system's clock
  /// \throws FileError if it can't be opened, or was made by a newer Enfilade
  explicit Database(const std::filesystem::path& file, std::function<std::int64_t()> clock = {});

  std::int64_t now() const { return clock_ ? clock_() : std::time(nullptr); }

  /// Runs a statement; the values take the places of its question marks. \returns how many rows it
  /// inserted, updated or deleted
  template <class... Values>
  int run(const std::string& sql, const Values&... values) {
    const auto held = hold();
    SQLite::Statement statement = prepare(sql, values...);
    return statement.exec();
  }
  /// As run(), of an INSERT. \returns the new row's id
  template <class... Values>
  std::int64_t insert(const std::string& sql, const Values&... values) {
    const auto held = hold();
    run(sql, values...);
    return db_.getLastInsertRowid();
  }
  /// The rows of a SELECT, as Row::read() reads them.
  template <class T, class... Values>
  std::vector<T> select(const std::string& sql, const Values&... values) {
    const auto held = hold();
    SQLite::Statement statement = prepare(sql, values...);
    std::vector<T> found;
    while (statement.executeStep()) Row(statement).read(found.emplace_back());
    return found;
  }
  /// As select(), the first row; none if there is no row.
  template <class T, class... Values>
  std::optional<T> find(const std::string& sql, const Values&... values) {
    const auto held = hold();
    SQLite::Statement statement = prepare(sql, values...);
    std::optional<T> found;
    if (statement.executeStep()) Row(statement).read(found.emplace());
    return found;
  }
  /// A number; 0 if there is no row.
  template <class... Values>
  std::int64_t find_number(const std::string& sql, const Values&... values) {
    return find<std::int64_t>(sql, values...).value_or(0);
  }

  /// Calls change() in a transaction: all that it runs happens, on the disk when this returns, or
  /// nothing of it. \pre not within another transaction
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
  /// Keeps other threads away for as long as the returned lock lives, so that several reads agree.
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

/// Copies a database while a server may be using it. The copy appears whole, by a rename.
/// \throws FileError
void back_up(const std::filesystem::path& database, const std::filesystem::path& copy);

}  // namespace enfilade::service::store
