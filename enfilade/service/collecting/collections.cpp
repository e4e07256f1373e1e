#include "enfilade/service/collecting/collections.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/r2r/metrics.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/secrets.h"

namespace enfilade::service::collecting {
namespace {

using detail::Reason;
using detail::Refusal;

constexpr std::size_t kKeySize = 32;  // digits: 128 bits

std::string collections_where(std::string_view condition) {
  return fmt::format(
      "SELECT collection.id, name, title, kind, open, link_key, platform, origins, "
      "completion_code, consent, instructions, per_item, lease_seconds, tasks_per_visit, "
      "collection.created FROM collection {}",
      condition);
}

std::int64_t insert_collection(store::Database& db, const Collection& c) {
  return db.insert(
      "INSERT INTO collection (name, title, kind, open, link_key, platform, origins, "
      "completion_code, consent, instructions, per_item, lease_seconds, tasks_per_visit, created) "
      "VALUES (?, ?, ?, 1, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
      c.name, c.title, c.kind, c.key, c.platform.kind, c.platform.origins,
      c.platform.completion_code, c.consent, c.instructions, c.per_item, c.lease_seconds,
      c.tasks_per_visit, c.created);
}

void insert_item(store::Database& db, std::int64_t collection, const Item& item) {
  db.run(
      "INSERT INTO item (collection, split, path_id, number, scan, heading, path, distance, "
      "instruction, secret, state) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, 'fresh')",
      collection, item.split, item.path_id, item.number, item.scan, item.heading.value, item.path,
      item.distance, item.instruction, item.secret);
}

}  // namespace

Collection add_collection(store::Database& db, const NewCollection& added) {
  Collection collection = added.about;
  collection.created = db.now();
  collection.key = detail::new_secret("").substr(0, kKeySize);
  db.transact([&] {
    if (find_collection(db, collection.name)) {
      throw Refusal(Reason::kConflict, "name: another collection has it");
    }
    collection.id = insert_collection(db, collection);
    for (const Item& item : added.items) insert_item(db, collection.id, item);
  });
  return collection;
}

std::optional<Collection> find_collection(store::Database& db, std::string_view name) {
  return db.find<Collection>(collections_where("WHERE name = ?"), name);
}

Collection get_collection(store::Database& db, std::string_view name) {
  auto found = find_collection(db, name);
  if (!found) throw Refusal(Reason::kNotFound, "no collection of this name");
  return std::move(*found);
}

Collection collection_of_visit(store::Database& db, std::int64_t visit) {
  return db.get<Collection>(
      collections_where("JOIN worker ON worker.collection = collection.id "
                        "JOIN visit ON visit.worker = worker.id WHERE visit.id = ?"),
      visit);
}

std::vector<Collection> list_collections(store::Database& db) {
  return db.select<Collection>(collections_where("ORDER BY collection.id"));
}

void set_open(store::Database& db, std::int64_t collection, bool open) {
  db.run("UPDATE collection SET open = ? WHERE id = ?", open, collection);
}

Progress progress_of(store::Database& db, std::int64_t collection) {
  return db.get<Progress>(
      "SELECT (SELECT count(*) FROM item WHERE collection = ?1), "
      "(SELECT total(state = 'complete') FROM item WHERE collection = ?1), "
      "total(task.state = 'leased' AND expires > ?2), total(task.state = 'submitted'), "
      "total(task.state = 'accepted'), total(task.state = 'rejected'), "
      "count(DISTINCT worker) "
      "FROM task JOIN item ON item.id = task.item WHERE item.collection = ?1",
      collection, db.now());
}

std::vector<SplitSize> splits_of(store::Database& db, std::int64_t collection) {
  return db.select<SplitSize>(
      "SELECT split, count(*), max(secret) FROM item WHERE collection = ? "
      "GROUP BY split ORDER BY min(id)",
      collection);
}

std::vector<VisitSummary> visits_of(store::Database& db, const Collection& collection) {
  return db.select<VisitSummary>(
      "SELECT visit.id, worker.id, worker.external, visit.external, grouped, visit.created, "
      "total(state = 'submitted'), total(state = 'accepted'), total(state = 'rejected'), "
      "total(error < ?2 AND state IN ('submitted', 'accepted')), "
      "?3 > 0 AND total(state IN ('submitted', 'accepted', 'rejected')) >= ?3 "
      "FROM visit JOIN worker ON worker.id = visit.worker LEFT JOIN task ON task.visit = "
      "visit.id WHERE worker.collection = ?1 GROUP BY visit.id ORDER BY visit.id",
      collection.id, r2r::MetricOptions{}.success_distance, collection.tasks_per_visit);
}

std::vector<Item> items_of(store::Database& db, std::int64_t collection, std::string_view split) {
  return db.select<Item>(
      fmt::format("SELECT {} FROM item WHERE collection = ?1 AND split = ?2 ORDER BY id",
                  kItemColumns),
      collection, split);
}

Item first_item(store::Database& db, std::int64_t collection) {
  return db.get<Item>(
      fmt::format("SELECT {} FROM item WHERE collection = ? ORDER BY id LIMIT 1", kItemColumns),
      collection);
}

std::string link_of(const Collection& collection) {
  // What Prolific fills in. MTurk adds its parameters itself.
  constexpr std::string_view kProlific =
      "&PROLIFIC_PID={{%PROLIFIC_PID%}}&STUDY_ID={{%STUDY_ID%}}&SESSION_ID={{%SESSION_ID%}}";
  return fmt::format("/{}?collection={}&key={}{}",
                     collection.kind == Kind::kWalk ? "walk" : "collect", collection.name,
                     collection.key,
                     collection.platform.kind == PlatformKind::kProlific ? kProlific : "");
}

}  // namespace enfilade::service::collecting
