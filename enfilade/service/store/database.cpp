#include "enfilade/service/store/database.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ranges>

#include "enfilade/service/store/schema.h"

namespace enfilade::service::store {

std::string join_lines(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, "\n"));
}

std::vector<std::string> split_lines(std::string_view text) {
  std::vector<std::string> lines;
  for (const auto line : std::views::split(text, '\n'))
    lines.emplace_back(line.begin(), line.end());
  return lines;
}

Database::Database(const std::string& place, std::function<std::int64_t()> clock)
    : shown_(shown(place)), clock_(std::move(clock)) {
  try {
    connection_ = connect(place);
    migrate();
    check_writable();  // a standby of PostgreSQL can only be read
  } catch (const DatabaseError& error) {
    throw FileError(fmt::format("{}: not a usable database: {}", shown_, error.what()));
  }
}

void Database::check_readable() {
  const auto held = hold();
  connection_->check_readable();
}

void Database::check_writable() {
  change([this] { connection_->check_writable(); });
}

void Database::migrate() {
  const int newest = static_cast<int>(kMigrations.size());
  int version = connection_->version();
  while (version < newest) {
    version = transact([this] {  // another program may have done it by now
      const int found = connection_->version();
      if (found >= static_cast<int>(kMigrations.size())) return found;
      connection_->migrate(kMigrations[static_cast<std::size_t>(found)], found + 1);
      return found + 1;
    });
  }
  if (version > newest) {
    throw FileError(
        fmt::format("{}: its schema has version {}, and this program knows up to {}; "
                    "use the newer Enfilade that made it",
                    shown_, version, newest));
  }
}

}  // namespace enfilade::service::store
