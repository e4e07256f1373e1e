/// \file  The one database of a server: SQLite in WAL mode.
#pragma once
#include <SQLiteCpp/SQLiteCpp.h>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <unordered_map>
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
  /// in a transaction of its own. Only its owner may read it then: it has people's texts and, of
  /// walks, secret goals. An existing file that others may read is closed to them.
  /// \param clock returns seconds since 1970, and may be called from any thread; empty: the
  /// system's clock
  /// \throws FileError if it can't be opened or written, was made by a newer Enfilade, or others
  /// may read it and that can't be changed
  explicit Database(const std::filesystem::path& file, std::function<std::int64_t()> clock = {});

  /// Seconds since 1970, by the clock of the constructor.
  std::int64_t now() const { return clock_ ? clock_() : std::time(nullptr); }

  /// Runs a statement that has no rows to read. The values are bound to its question marks, in
  /// their order or by number (?1, ?2). \returns how many rows it inserted, updated or deleted
  template <class... Values>
  int run(const std::string& sql, const Values&... values) {
    const auto held = hold();
    const Use use = prepare(sql, values...);
    return use->exec();
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
    const Use use = prepare(sql, values...);
    std::vector<T> found;
    while (use->executeStep()) Row(*use).read_whole(found.emplace_back());
    return found;
  }
  /// The first row of a SELECT; none if it has no row.
  template <class T, class... Values>
  std::optional<T> find(const std::string& sql, const Values&... values) {
    const auto held = hold();
    const Use use = prepare(sql, values...);
    std::optional<T> found;
    if (use->executeStep()) Row(*use).read_whole(found.emplace());
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

  const std::filesystem::path& file() const noexcept { return file_; }
  /// Whether the file that was opened is still there under its name: of one that was removed or
  /// replaced, all that is written is lost.
  bool is_in_place() const;
  /// Reads a row of every table, by a connection of its own, from the file rather than from memory.
  /// \throws SQLite::Exception or FileError if that fails
  void check_readable() const;
  /// Writes a few bytes that say nothing new, to the disk. \throws SQLite::Exception if that fails
  void check_writable();

 private:
  // Ends the use of a statement, not the statement: it holds no lock and no values then.
  struct EndUse {
    void operator()(SQLite::Statement* statement) const noexcept;
  };
  using Use = std::unique_ptr<SQLite::Statement, EndUse>;

  template <class... Values>
  Use prepare(const std::string& sql, const Values&... values) {
    Use use(&prepared(sql));
    int k = 0;
    (bind(*use, ++k, values), ...);
    return use;
  }
  SQLite::Statement& prepared(const std::string& sql);
  void migrate();

  std::recursive_mutex mutex_;
  std::filesystem::path file_;
  std::function<std::int64_t()> clock_;
  SQLite::Database db_;
  // By their texts. To prepare one takes longer than to run it, and there are not many texts.
  std::unordered_map<std::string, SQLite::Statement> statements_;
  std::pair<std::uint64_t, std::uint64_t>
      identity_;  // device and inode of the file as it was opened
};

/// Copies a database, also while a server uses it. The copy is written beside its place and then
/// renamed, so that it is never there in part; an older copy of that name is replaced. Only its
/// owner may read it.
/// \throws FileError naming the file that cannot be opened, read or written
void back_up(const std::filesystem::path& database, const std::filesystem::path& copy);

}  // namespace enfilade::service::store
