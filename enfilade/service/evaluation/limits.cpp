#include "enfilade/service/evaluation/limits.h"

#include <fmt/format.h>

#include "enfilade/service/detail/addresses.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/secrets.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::evaluation {
namespace {

using detail::Reason;
using detail::Refusal;

constexpr std::int64_t kDay = 24L * 3600;
constexpr const char* kAddressKey = "address-key";

/// \param what "20 submissions of a team"
void refuse_if_full(std::int64_t taken, std::int64_t most, const Phase& phase,
                    std::string_view what) {
  if (taken < most) return;
  throw Refusal(Reason::kRateLimited,
                fmt::format("phase {} takes at most {} {}", phase.name, most, what));
}

// Submissions of databases that are older than the table `attempt` count too.
void check_team(store::Database& db, const Phase& phase, std::int64_t team) {
  const std::string count = "SELECT count(*) FROM submission WHERE team = ? AND phase = ?";
  refuse_if_full(db.find_number(count + " AND created > ?", team, phase.name, db.now() - kDay),
                 phase.per_day, phase, "submissions of a team in 24 hours");
  if (!phase.per_team) return;
  refuse_if_full(db.find_number(count, team, phase.name), *phase.per_team, phase,
                 "submissions of a team in all");
}

void check_address(store::Database& db, const Phase& phase, const std::string& address) {
  const std::string count =
      "SELECT count(*) FROM attempt WHERE address = ? AND phase = ? AND submission IS NOT NULL";
  refuse_if_full(db.find_number(count + " AND created > ?", address, phase.name, db.now() - kDay),
                 phase.per_address_day, phase, "submissions from an address in 24 hours");
  if (!phase.per_address) return;
  refuse_if_full(db.find_number(count, address, phase.name), *phase.per_address, phase,
                 "submissions from an address in all");
}

void check_refused(store::Database& db, const Phase& phase, const Sender& sender) {
  const std::string count =
      "SELECT count(*) FROM attempt WHERE phase = ? AND submission IS NULL AND created > ? AND ";
  const std::int64_t since = db.now() - kDay;
  refuse_if_full(db.find_number(count + "team = ?", phase.name, since, sender.team), kRefusedPerDay,
                 phase, "files with faults of a team in 24 hours");
  refuse_if_full(db.find_number(count + "address = ?", phase.name, since, sender.address),
                 kRefusedPerAddressDay, phase, "files with faults from an address in 24 hours");
}

// The bound on a phase's leakage holds for Phase::teams teams.
void check_place(store::Database& db, const Phase& phase, std::int64_t team) {
  if (!phase.goals_secret()) return;
  const std::int64_t others =
      db.find_number("SELECT count(DISTINCT team) FROM submission WHERE phase = ? AND team <> ?",
                     phase.name, team);
  if (others < phase.teams) return;
  throw Refusal(
      Reason::kForbidden,
      fmt::format("phase {} takes submissions of {} teams, and has them", phase.name, phase.teams));
}

}  // namespace

std::string stored_address(store::Database& db, std::string_view address) {
  const std::string key = db.transact([&db] {
    const std::string find = "SELECT value FROM secret WHERE name = ?";
    if (const auto found = db.find<std::string>(find, kAddressKey)) return *found;
    db.run("INSERT INTO secret (name, value) VALUES (?, ?)", kAddressKey, detail::new_secret(""));
    return db.get<std::string>(find, kAddressKey);
  });
  return detail::keyed_hash(key, detail::address_group(address));
}

void check_limits(store::Database& db, const Phase& phase, const Sender& sender) {
  check_place(db, phase, sender.team);
  check_team(db, phase, sender.team);
  check_address(db, phase, sender.address);
}

std::int64_t begin_attempt(store::Database& db, const Phase& phase, const Sender& sender) {
  return db.transact([&] {
    check_limits(db, phase, sender);
    check_refused(db, phase, sender);
    // Addresses of refused files are not kept for longer than they count.
    db.run("DELETE FROM attempt WHERE submission IS NULL AND created <= ?", db.now() - kDay);
    return db.insert("INSERT INTO attempt (team, phase, address, created) VALUES (?, ?, ?, ?)",
                     sender.team, phase.name, sender.address, db.now());
  });
}

void accept_attempt(store::Database& db, std::int64_t attempt, std::int64_t submission) {
  db.run("UPDATE attempt SET submission = ? WHERE id = ?", submission, attempt);
}

}  // namespace enfilade::service::evaluation
