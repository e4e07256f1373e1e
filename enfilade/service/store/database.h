/// \file  The one database of a server: SQLite in WAL mode.
#pragma once
#include <SQLiteCpp/SQLiteCpp.h>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <utility>

namespace enfilade::service::store {

/// One connexion, one user of it at a time: writes take turns in SQLite anyway, and reads here are
/// of a few rows. All functions may be called from any thread; \throws Error with SQLite's words.
class Database {
 public:
  /// Opens or makes the file, and brings its schema up to date, each migration in a transaction.
  /// \throws FileError if it can't be opened, or was made by a newer Enfilade
  explicit Database(const std::filesystem::path& file);

  /// Calls use(SQLite::Database&) while nobody else does.
  template <class Use>
  auto with(Use&& use) {
    const std::scoped_lock lock(mutex_);
    return std::forward<Use>(use)(db_);
  }
  /// As with(), in a transaction: all of it happens, on the disk when this returns, or nothing.
  template <class Use>
  auto transact(Use&& use) {
    const std::scoped_lock lock(mutex_);
    SQLite::Transaction transaction(db_, SQLite::TransactionBehavior::IMMEDIATE);
    if constexpr (std::is_void_v<decltype(use(db_))>) {
      std::forward<Use>(use)(db_);
      transaction.commit();
    } else {
      auto result = std::forward<Use>(use)(db_);
      transaction.commit();
      return result;
    }
  }

 private:
  void migrate();

  std::mutex mutex_;
  std::string file_;
  SQLite::Database db_;
};

/// Copies a database while a server may be using it. The copy appears whole, by a rename.
/// \throws FileError
void back_up(const std::filesystem::path& database, const std::filesystem::path& copy);

}  // namespace enfilade::service::store
