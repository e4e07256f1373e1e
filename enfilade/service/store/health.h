/// \file  Whether a server's database and disk do their work.
#pragma once
#include <array>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/service/store/database.h"

namespace enfilade::service::store {

/// Causes that keep a server from its work, in words that monitors may match.
enum class Trouble : std::uint8_t {
  kDiskFull,             ///< less room than stated is left, or the database found none
  kDatabaseReplaced,     ///< the file was moved, removed or replaced while it was open
  kDatabaseUnreadable,   ///< it cannot be opened, or a table of it cannot be read
  kDatabaseUnwritable,   ///< a small change of it did not reach the disk
  kDatabaseUnreachable,  ///< there is no connection to its server
};
constexpr std::array<std::string_view, 5> names_of(Trouble /*enum*/) {
  return {"disk-full", "database-replaced", "database-unreadable", "database-unwritable",
          "database-unreachable"};
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

 private:
  struct Fault {
    Trouble trouble = Trouble::kDiskFull;
    std::string details;
  };
  std::optional<Fault> look();
  std::optional<Fault> try_out(void (Database::*work)(), Trouble otherwise);

  Database& db_;
  std::uint64_t least_free_bytes_;
  Report report_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point looked_;  // 0: never
  std::optional<Trouble> seen_;
};

}  // namespace enfilade::service::store
