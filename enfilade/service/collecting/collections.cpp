#include "enfilade/service/collecting/collections.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/r2r/metrics.h"
#include "enfilade/service/detail/errors.h"
#include "enfilade/service/detail/secrets.h"

namespace enfilade::service::collecting {
namespace {

using detail::ErrorCode;
using detail::ServiceError;

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

store::Row& operator>>(store::Row& row, Collection& c) {
  return row >> c.id >> c.name >> c.title >> c.kind >> c.open >> c.key >> c.platform.kind >>
         c.platform.origins >> c.platform.completion_code >> c.consent >> c.instructions >>
         c.per_item >> c.lease_seconds >> c.tasks_per_visit >> c.created;
}

store::Row& operator>>(store::Row& row, Item& item) {
  return row >> item.id >> item.split >> item.path_id >> item.number >> item.scan >>
         item.heading.value >> item.path >> item.distance >> item.instruction >> item.secret;
}

store::Row& operator>>(store::Row& row, Progress& p) {
  return row >> p.items >> p.complete >> p.leased >> p.submitted >> p.accepted >> p.rejected >>
         p.workers;
}

store::Row& operator>>(store::Row& row, SplitSize& split) {
  return row >> split.split >> split.items >> split.secret;
}

store::Row& operator>>(store::Row& row, VisitSummary& v) {
  return row >> v.visit >> v.worker >> v.external >> v.assignment >> v.group >> v.created >>
         v.submitted >> v.accepted >> v.rejected >> v.bonuses >> v.finished;
}

Collection add_collection(store::Database& db, const NewCollection& added) {
  Collection collection = added.about;
  collection.created = db.now();
  collection.key = detail::new_secret("").substr(0, kKeySize);
  db.transact([&] {
    if (find_collection(db, collection.name)) {
      throw ServiceError(ErrorCode::kConflict, "name: another collection has it");
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
  if (!found) throw ServiceError(ErrorCode::kNotFound, "no collection of this name");
  return std::move(*found);
}

Collection collection_of_visit(store::Database& db, std::int64_t visit) {
  return db
      .find<Collection>(
          collections_where("JOIN worker ON worker.collection = collection.id "
                            "JOIN visit ON visit.worker = worker.id WHERE visit.id = ?"),
          visit)
      .value();
}

std::vector<Collection> list_collections(store::Database& db) {
  return db.select<Collection>(collections_where("ORDER BY collection.id"));
}

void set_open(store::Database& db, std::int64_t collection, bool open) {
  db.run("UPDATE collection SET open = ? WHERE id = ?", open, collection);
}

Progress progress_of(store::Database& db, std::int64_t collection) {
  return db
      .find<Progress>(
          "SELECT (SELECT count(*) FROM item WHERE collection = ?1), "
          "(SELECT total(state = 'complete') FROM item WHERE collection = ?1), "
          "total(task.state = 'leased' AND expires > ?2), total(task.state = 'submitted'), "
          "total(task.state = 'accepted'), total(task.state = 'rejected'), "
          "count(DISTINCT worker) "
          "FROM task JOIN item ON item.id = task.item WHERE item.collection = ?1",
          collection, db.now())
      .value();
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
  return db
      .find<Item>(
          fmt::format("SELECT {} FROM item WHERE collection = ? ORDER BY id LIMIT 1", kItemColumns),
          collection)
      .value();
}

std::string link_of(const Collection& collection) {
  return fmt::format("/{}?collection={}&key={}{}",
                     collection.kind == Kind::kWalk ? "walk" : "collect", collection.name,
                     collection.key, placeholders(collection.platform.kind));
}

}  // namespace enfilade::service::collecting
