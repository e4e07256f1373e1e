#include "enfilade/service/store/health.h"

#include <fmt/format.h>
#include <utility>

namespace enfilade::service::store {
namespace {

constexpr std::chrono::seconds kBetweenLooks{1};  // monitors ask less often, floods gain nothing

}  // namespace

std::optional<Trouble> trouble_of(const std::exception& error) noexcept {
  const auto* thrown = dynamic_cast<const DatabaseError*>(&error);
  if (thrown == nullptr) return std::nullopt;
  switch (thrown->cause()) {
    case DatabaseError::Cause::kDiskFull:
      return Trouble::kDiskFull;
    case DatabaseError::Cause::kUnreachable:
      return Trouble::kDatabaseUnreachable;
    case DatabaseError::Cause::kStatement:
    case DatabaseError::Cause::kNoText:
      break;
  }
  return std::nullopt;
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
  const std::string& place = db_.shown_place();
  if (!db_.is_in_place()) {
    return Fault{Trouble::kDatabaseReplaced,
                 place + ": is no longer the file that was opened; start the server again"};
  }
  // SQLite may still write: it uses its log again and again, whose room it has.
  if (const auto free = db_.free_bytes(); free && *free < least_free_bytes_) {
    return Fault{Trouble::kDiskFull, fmt::format("{}: {} bytes are free on its disk, at least {} "
                                                 "should be",
                                                 place, *free, least_free_bytes_)};
  }
  if (auto fault = try_out(&Database::check_readable, Trouble::kDatabaseUnreadable)) return fault;
  return try_out(&Database::check_writable, Trouble::kDatabaseUnwritable);
}

std::optional<Health::Fault> Health::try_out(void (Database::*work)(), Trouble otherwise) {
  try {
    (db_.*work)();
    return std::nullopt;
  } catch (const std::exception& error) {
    return Fault{trouble_of(error).value_or(otherwise),
                 fmt::format("{}: {}", db_.shown_place(), error.what())};
  }
}

}  // namespace enfilade::service::store
