#include "enfilade/service/collecting/visits.h"

#include "enfilade/service/detail/refusal.h"

namespace enfilade::service::collecting {
namespace {

using detail::Refusal;

std::int64_t find_or_add_visit(store::Database& db, const Collection& collection,
                               const Arrival& arrival) {
  db.run("INSERT OR IGNORE INTO worker (collection, external, created) VALUES (?, ?, ?)",
         collection.id, arrival.worker, db.now());
  const std::int64_t worker = db.find_number(
      "SELECT id FROM worker WHERE collection = ? AND external = ?", collection.id, arrival.worker);
  const std::int64_t known = db.find_number(
      "SELECT id FROM visit WHERE worker = ? AND external = ?", worker, arrival.assignment);
  if (known != 0) return known;
  if (!collection.open) {
    throw Refusal(403, "the collection is closed", "collection-closed");
  }
  const bool taken = !arrival.assignment.empty() &&
                     db.find_number(
                         "SELECT visit.id FROM visit JOIN worker ON worker.id = visit.worker "
                         "WHERE worker.collection = ? AND visit.external = ?",
                         collection.id, arrival.assignment) != 0;
  if (taken) throw Refusal(409, "another worker has this assignment");
  return db.insert(
      "INSERT INTO visit (worker, external, grouped, submit_to, created) VALUES (?, ?, ?, ?, ?)",
      worker, arrival.assignment, arrival.group, arrival.submit_to, db.now());
}

}  // namespace

bool is_finished(const Collection& collection, const Visit& visit) {
  return collection.tasks_per_visit > 0 && visit.done >= collection.tasks_per_visit;
}

std::int64_t join(store::Database& db, const Collection& collection, const Arrival& arrival) {
  return db.transact([&] { return find_or_add_visit(db, collection, arrival); });
}

Visit get_visit(store::Database& db, std::int64_t visit) {
  return db
      .find<Visit>(
          "SELECT visit.id, worker.id, worker.collection, consented IS NOT NULL, "
          "worker.external, visit.external, submit_to, (SELECT count(*) FROM task WHERE "
          "task.visit = visit.id AND state IN ('submitted', 'accepted', 'rejected')) "
          "FROM visit JOIN worker ON worker.id = visit.worker WHERE visit.id = ?",
          visit)
      .value();
}

void give_consent(store::Database& db, const Visit& visit) {
  db.run("UPDATE worker SET consented = ? WHERE id = ? AND consented IS NULL", db.now(),
         visit.worker);
}

}  // namespace enfilade::service::collecting
