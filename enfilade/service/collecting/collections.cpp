#include "enfilade/service/collecting/collections.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>

#include "enfilade/r2r/metrics.h"
#include "enfilade/service/detail/secrets.h"
#include "enfilade/service/http/http.h"
#include "enfilade/service/store/database.h"
#include "enfilade/service/store/sql.h"

namespace enfilade::service::collecting {
namespace {

constexpr std::size_t kKeySize = 32;  // digits: 128 bits

constexpr const char* kCollections =
    "SELECT collection.id, name, title, kind, open, link_key, platform, origins, completion_code, "
    "consent, instructions, per_item, lease_seconds, tasks_per_visit, collection.created "
    "FROM collection ";

Collection read_collection(SQLite::Statement& row) {
  Collection c;
  c.id = row.getColumn(0).getInt64();
  c.name = row.getColumn(1).getString();
  c.title = row.getColumn(2).getString();
  c.kind = row.getColumn(3).getString() == "walk" ? Kind::kWalk : Kind::kWrite;
  c.open = row.getColumn(4).getInt() != 0;
  c.key = row.getColumn(5).getString();
  c.platform = {platform_kind(row.getColumn(6).getString()),
                split_lines(row.getColumn(7).getString()), row.getColumn(8).getString()};
  c.consent = row.getColumn(9).getString();
  c.instructions = row.getColumn(10).getString();
  c.per_item = row.getColumn(11).getInt();
  c.lease_seconds = row.getColumn(12).getInt64();
  c.tasks_per_visit = row.getColumn(13).getInt();
  c.created = row.getColumn(14).getInt64();
  return c;
}

void insert_collection(SQLite::Database& db, const Collection& c) {
  store::run(
      db,
      "INSERT INTO collection (name, title, kind, open, link_key, platform, origins, "
      "completion_code, consent, instructions, per_item, lease_seconds, tasks_per_visit, created) "
      "VALUES (?, ?, ?, 1, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
      c.name, c.title, std::string(to_string(c.kind)), c.key,
      std::string(to_string(c.platform.kind)), join_lines(c.platform.origins),
      c.platform.completion_code, c.consent, c.instructions, c.per_item, c.lease_seconds,
      c.tasks_per_visit, c.created);
}

void insert_items(SQLite::Database& db, std::int64_t collection, const std::vector<Item>& items) {
  SQLite::Statement insert(
      db,
      "INSERT INTO item (collection, split, path_id, number, scan, heading, path, instruction, "
      "secret, distance, state) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, 'fresh')");
  for (const Item& item : items) {
    insert.reset();
    SQLite::bind(insert, collection, item.split, item.path_id,
                 static_cast<std::int64_t>(item.number), item.scan, item.heading.value,
                 join_lines(item.path), item.instruction, item.secret ? 1 : 0);
    item.distance ? insert.bind(10, *item.distance) : insert.bind(10);
    insert.exec();
  }
}

std::vector<Collection> select_collections(store::Database& database, const std::string& condition,
                                           const std::string& name, std::int64_t number) {
  return database.with([&](SQLite::Database& db) {
    SQLite::Statement rows(db, kCollections + condition);
    if (!name.empty()) rows.bind(1, name);
    if (number != 0) rows.bind(1, number);
    std::vector<Collection> found;
    while (rows.executeStep()) found.push_back(read_collection(rows));
    return found;
  });
}

}  // namespace

std::string_view to_string(Kind kind) { return kind == Kind::kWalk ? "walk" : "write"; }

std::string join_lines(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, "\n"));
}

std::vector<std::string> split_lines(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

Item read_item(SQLite::Statement& row) {
  Item item;
  item.id = row.getColumn(0).getInt64();
  item.split = row.getColumn(1).getString();
  item.path_id = row.getColumn(2).getInt64();
  item.number = static_cast<std::size_t>(row.getColumn(3).getInt64());
  item.scan = row.getColumn(4).getString();
  item.heading = Radians(row.getColumn(5).getDouble());
  item.path = split_lines(row.getColumn(6).getString());
  if (!row.getColumn(7).isNull()) item.distance = row.getColumn(7).getDouble();
  item.instruction = row.getColumn(8).getString();
  item.secret = row.getColumn(9).getInt() != 0;
  return item;
}

Collection add_collection(store::Database& database, const NewCollection& made, std::int64_t now) {
  Collection collection = made.about;
  collection.created = now;
  collection.key = detail::new_secret("").substr(0, kKeySize);
  try {
    collection.id = database.transact([&](SQLite::Database& db) {
      insert_collection(db, collection);
      const std::int64_t id = db.getLastInsertRowid();
      insert_items(db, id, made.items);
      return id;
    });
  } catch (const SQLite::Exception& error) {
    if (error.getExtendedErrorCode() != store::kUniqueViolated) throw;
    throw http::HttpError(409, "name-taken", "name: another collection has it");
  }
  return collection;
}

std::optional<Collection> find_collection(store::Database& database, std::string_view name) {
  if (name.empty()) return std::nullopt;
  auto found = select_collections(database, "WHERE name = ?", std::string(name), 0);
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

Collection collection_named(store::Database& database, std::string_view name) {
  auto found = find_collection(database, name);
  if (!found) throw http::HttpError(404, "unknown-collection", "no collection of this name");
  return std::move(*found);
}

Collection collection_of_visit(store::Database& database, std::int64_t visit) {
  return select_collections(database,
                            "JOIN worker ON worker.collection = collection.id "
                            "JOIN visit ON visit.worker = worker.id WHERE visit.id = ?",
                            "", visit)
      .at(0);
}

std::vector<Collection> list_collections(store::Database& database) {
  return select_collections(database, "ORDER BY collection.id", "", 0);
}

void set_open(store::Database& database, std::int64_t collection, bool open) {
  database.transact([&](SQLite::Database& db) {
    store::run(db, "UPDATE collection SET open = ? WHERE id = ?", open ? 1 : 0, collection);
  });
}

Progress progress_of(store::Database& database, std::int64_t collection, std::int64_t now) {
  return database.with([&](SQLite::Database& db) {
    SQLite::Statement items(
        db, "SELECT count(*), total(state = 'complete') FROM item WHERE collection = ?");
    items.bind(1, collection);
    items.executeStep();
    SQLite::Statement tasks(
        db,
        "SELECT total(task.state = 'leased' AND expires > ?2), total(task.state = 'submitted'), "
        "total(task.state = 'accepted'), total(task.state = 'rejected'), count(DISTINCT worker) "
        "FROM task JOIN item ON item.id = task.item WHERE item.collection = ?1");
    SQLite::bind(tasks, collection, now);
    tasks.executeStep();
    const auto number = [](SQLite::Statement& row, int k) { return row.getColumn(k).getInt64(); };
    return Progress{number(items, 0), number(tasks, 0), number(tasks, 1), number(tasks, 2),
                    number(tasks, 3), number(items, 1), number(tasks, 4)};
  });
}

std::vector<SplitSize> splits_of(store::Database& database, std::int64_t collection) {
  return database.with([&](SQLite::Database& db) {
    SQLite::Statement rows(db,
                           "SELECT split, count(*), max(secret) FROM item WHERE collection = ? "
                           "GROUP BY split ORDER BY min(id)");
    rows.bind(1, collection);
    std::vector<SplitSize> splits;
    while (rows.executeStep()) {
      splits.push_back({rows.getColumn(0).getString(), rows.getColumn(1).getInt64(),
                        rows.getColumn(2).getInt() != 0});
    }
    return splits;
  });
}

std::vector<VisitSummary> visits_of(store::Database& database, const Collection& collection) {
  return database.with([&](SQLite::Database& db) {
    SQLite::Statement rows(
        db,
        "SELECT visit.id, worker.id, worker.external, visit.external, grouped, visit.created, "
        "total(state = 'submitted'), total(state = 'accepted'), total(state = 'rejected'), "
        "total(error < ?2 AND state IN ('submitted', 'accepted')) "
        "FROM visit JOIN worker ON worker.id = visit.worker LEFT JOIN task ON task.visit = "
        "visit.id WHERE worker.collection = ?1 GROUP BY visit.id ORDER BY visit.id");
    SQLite::bind(rows, collection.id, r2r::MetricOptions{}.success_distance);
    std::vector<VisitSummary> visits;
    while (rows.executeStep()) {
      const auto number = [&rows](int k) { return rows.getColumn(k).getInt64(); };
      const auto text = [&rows](int k) { return rows.getColumn(k).getString(); };
      VisitSummary visit{number(0), number(1), text(2),   text(3),   text(4), number(5),
                         number(6), number(7), number(8), number(9), false};
      const std::int64_t done = visit.submitted + visit.accepted + visit.rejected;
      visit.finished = collection.tasks_per_visit > 0 && done >= collection.tasks_per_visit;
      visits.push_back(std::move(visit));
    }
    return visits;
  });
}

Item first_item(store::Database& database, std::int64_t collection) {
  return database.with([&](SQLite::Database& db) {
    SQLite::Statement row(db, fmt::format("SELECT {} FROM item WHERE collection = ? ORDER BY id "
                                          "LIMIT 1",
                                          kItemColumns));
    row.bind(1, collection);
    row.executeStep();
    return read_item(row);
  });
}

std::string link_of(const Collection& collection) {
  return fmt::format("/{}?collection={}&key={}{}",
                     collection.kind == Kind::kWalk ? "walk" : "collect", collection.name,
                     collection.key, placeholders(collection.platform.kind));
}

}  // namespace enfilade::service::collecting
