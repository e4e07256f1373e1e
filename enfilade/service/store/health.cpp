#include "enfilade/service/store/health.h"

#include <fmt/format.h>
#include <sys/statvfs.h>
#include <utility>

namespace enfilade::service::store {
namespace {

constexpr std::chrono::seconds kBetweenLooks{1};  // monitors ask less often, floods gain nothing
constexpr int kSqliteFull = 13;                   // SQLITE_FULL of <sqlite3.h>

/// Bytes that are free on a file's disk for this process; none if the system doesn't say.
std::optional<std::uint64_t> free_bytes(const std::filesystem::path& file) {
  struct statvfs disk {};
  if (::statvfs(file.c_str(), &disk) != 0) return std::nullopt;
  return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

}  // namespace

bool is_disk_full(const std::exception& error) noexcept {
  const auto* thrown = dynamic_cast<const SQLite::Exception*>(&error);
  return thrown != nullptr && thrown->getErrorCode() == kSqliteFull;
}

Health::Health(Database& db, std::uint64_t least_free_bytes, Report report)
    : db_(db), least_free_bytes_(least_free_bytes), report_(std::move(report)) {}

std::optional<Trouble> Health::trouble() {
  const std::scoped_lock lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (looked_.time_since_epoch().count() != 0 && now - looked_ < kBetweenLooks) return seen_;
  const std::optional<Fault> fault = look();
  const std::optional<Trouble> trouble =
      fault ? std::optional(fault->trouble) : std::optional<Trouble>();
  if (report_ && trouble != seen_) {
    report_(fault ? fmt::format("{}: {}", enum_name(fault->trouble), fault->details) : "");
  }
  seen_ = trouble;
  looked_ = std::chrono::steady_clock::now();
  return seen_;
}

std::optional<Health::Fault> Health::look() {
  const std::string file = db_.file().string();
  if (!db_.is_in_place()) {
    return Fault{Trouble::kDatabaseReplaced,
                 file + ": is no longer the file that was opened; start the server again"};
  }
  // SQLite may still write: it uses its log again and again, whose room it has.
  if (const auto free = free_bytes(db_.file()); free && *free < least_free_bytes_) {
    return Fault{Trouble::kDiskFull, fmt::format("{}: {} bytes are free on its disk, at least {} "
                                                 "should be",
                                                 file, *free, least_free_bytes_)};
  }
  try {
    db_.check_readable();
  } catch (const std::exception& error) {
    return Fault{Trouble::kDatabaseUnreadable, fmt::format("{}: {}", file, error.what())};
  }
  return try_to_write();
}

std::optional<Health::Fault> Health::try_to_write() {
  try {
    db_.check_writable();
    return std::nullopt;
  } catch (const SQLite::Exception& error) {
    return Fault{is_disk_full(error) ? Trouble::kDiskFull : Trouble::kDatabaseUnwritable,
                 fmt::format("{}: {}", db_.file().string(), error.what())};
  }
}

}  // namespace enfilade::service::store
