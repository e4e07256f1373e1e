/// \file  The one database of a server: a file of SQLite, or a database of PostgreSQL that several
/// servers may share.
#pragma once
#include <array>
#include <cstdint>
#include <ctime>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/store/connection.h"
#include "enfilade/service/store/sql.h"

namespace enfilade::service::store {

/// One connection, used by one thread at a time: changes wait for each other anyway, and reads are
/// of a few rows. All functions may be called from any thread, and wait for the thread that holds
/// the connection. They return copies, which stay valid.
///
/// SQL is in the common part of SQLite and PostgreSQL. All functions that run a statement throw
/// DatabaseError if it fails. They throw Error for a stored name of an enumeration that this
/// program does not have. If a server of PostgreSQL was lost, the next statement connects again.
class Database {
 public:
  /// Opens a place (connection.h), creates the file if it is missing, and brings the schema up to
  /// date. Each migration has a transaction of its own; of several programs at once one does it.
  /// \param clock returns seconds since 1970, and may be called from any thread; empty: the
  /// system's clock
  /// \throws FileError if it can't be opened or written, was made by a newer Enfilade, or is
  /// readable by others and that can't be changed
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
    Transaction transaction(*this);
    if constexpr (std::is_void_v<std::invoke_result_t<Change>>) {
      std::forward<Change>(change)();
      transaction.commit();
    } else {
      auto result = std::forward<Change>(change)();
      transaction.commit();
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

 private:
  /// Rolled back at its end, unless it was committed. \pre the thread holds the connection
  class Transaction {
   public:
    explicit Transaction(Database& db) : db_(db) {
      db_.connection_->begin();
      db_.in_transaction_ = true;
    }
    ~Transaction() {
      if (db_.in_transaction_) db_.connection_->roll_back();
      db_.in_transaction_ = false;
    }
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    void commit() {
      db_.connection_->commit();
      db_.in_transaction_ = false;
    }

   private:
    Database& db_;
  };

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

  std::recursive_mutex mutex_;
  std::string shown_;
  std::function<std::int64_t()> clock_;
  std::unique_ptr<Connection> connection_;
  bool in_transaction_ = false;
};

}  // namespace enfilade::service::store
