#include "enfilade/service/collecting/visits.h"

#include "enfilade/core/check.h"
#include "enfilade/service/http/http.h"
#include "enfilade/service/store/database.h"
#include "enfilade/service/store/sql.h"

namespace enfilade::service::collecting {
namespace {

std::int64_t come_in(SQLite::Database& db, const Collection& collection, const Arrival& arrival,
                     std::int64_t now) {
  store::run(db, "INSERT OR IGNORE INTO worker (collection, external, created) VALUES (?, ?, ?)",
             collection.id, arrival.worker, now);
  const std::int64_t worker =
      store::find_number(db, "SELECT id FROM worker WHERE collection = ? AND external = ?",
                         collection.id, arrival.worker);
  const std::int64_t known = store::find_number(
      db, "SELECT id FROM visit WHERE worker = ? AND external = ?", worker, arrival.assignment);
  if (known != 0) return known;
  if (!collection.open) throw http::HttpError(403, "closed", "the collection is closed");
  const bool taken =
      !arrival.assignment.empty() &&
      store::find_number(db,
                         "SELECT visit.id FROM visit JOIN worker ON worker.id = visit.worker "
                         "WHERE worker.collection = ? AND visit.external = ?",
                         collection.id, arrival.assignment) != 0;
  if (taken) throw http::HttpError(409, "assignment-taken", "another worker has this assignment");
  store::run(
      db,
      "INSERT INTO visit (worker, external, grouped, submit_to, created) VALUES (?, ?, ?, ?, ?)",
      worker, arrival.assignment, arrival.group, arrival.submit_to, now);
  return db.getLastInsertRowid();
}

}  // namespace

bool has_had_all(const Collection& collection, const Visit& visit) {
  return collection.tasks_per_visit > 0 && visit.done >= collection.tasks_per_visit;
}

std::int64_t join(store::Database& database, const Collection& collection, const Arrival& arrival,
                  std::int64_t now) {
  return database.transact(
      [&](SQLite::Database& db) { return come_in(db, collection, arrival, now); });
}

Visit visit_of(store::Database& database, std::int64_t visit) {
  return database.with([&](SQLite::Database& db) {
    SQLite::Statement row(
        db,
        "SELECT visit.id, worker.id, worker.collection, consented IS NOT NULL, worker.external, "
        "visit.external, submit_to, (SELECT count(*) FROM task WHERE task.visit = visit.id "
        "AND state IN ('submitted', 'accepted', 'rejected')) "
        "FROM visit JOIN worker ON worker.id = visit.worker WHERE visit.id = ?");
    row.bind(1, visit);
    EN_CHECK(row.executeStep());
    return Visit{row.getColumn(0).getInt64(),  row.getColumn(1).getInt64(),
                 row.getColumn(2).getInt64(),  row.getColumn(3).getInt() != 0,
                 row.getColumn(4).getString(), row.getColumn(5).getString(),
                 row.getColumn(6).getString(), row.getColumn(7).getInt64()};
  });
}

void consent(store::Database& database, const Visit& visit, std::int64_t now) {
  database.transact([&](SQLite::Database& db) {
    store::run(db, "UPDATE worker SET consented = ? WHERE id = ? AND consented IS NULL", now,
               visit.worker);
  });
}

}  // namespace enfilade::service::collecting
