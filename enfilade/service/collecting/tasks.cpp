#include "enfilade/service/collecting/tasks.h"

#include <fmt/format.h>
#include <array>

#include "enfilade/r2r/metrics.h"
#include "enfilade/service/detail/secrets.h"
#include "enfilade/service/http/http.h"
#include "enfilade/service/store/database.h"
#include "enfilade/service/store/sql.h"

namespace enfilade::service::collecting {
namespace {

constexpr const char* kHandedIn = "task.state IN ('submitted', 'accepted', 'rejected')";

std::string task_query(std::string_view condition) {
  return fmt::format(
      "SELECT {}, item.collection, collection.kind, collection.per_item, "
      "collection.lease_seconds, task.id, task.worker, task.visit, task.state, task.expires, "
      "task.draft, task.content, task.digest, task.seconds, task.flags, task.camera, task.error, "
      "task.submitted, task.reason FROM task JOIN item ON item.id = task.item "
      "JOIN collection ON collection.id = item.collection WHERE {}",
      kItemColumns, condition);
}

Task read_task(SQLite::Statement& row) {
  int k = kItemColumnCount;
  const auto number = [&] { return row.getColumn(k++).getInt64(); };
  const auto text = [&] { return row.getColumn(k++).getString(); };
  Task task;
  task.item = read_item(row);
  task.collection = number();
  task.kind = text() == "walk" ? Kind::kWalk : Kind::kWrite;
  task.per_item = static_cast<int>(number());
  task.lease_seconds = number();
  task.id = number();
  task.worker = number();
  task.visit = number();
  task.state = text();
  task.expires = number();
  task.draft = text();
  task.content = text();
  task.digest = text();
  task.seconds = row.getColumn(k++).getDouble();
  task.flags = split_lines(text());
  task.camera = text();
  if (!row.getColumn(k).isNull()) task.error = row.getColumn(k).getDouble();
  ++k;
  task.submitted = number();
  task.reason = text();
  return task;
}

template <class... Values>
std::vector<Task> select_tasks(SQLite::Database& db, std::string_view condition,
                               const Values&... values) {
  SQLite::Statement rows(db, task_query(condition));
  SQLite::bind(rows, values...);
  std::vector<Task> tasks;
  while (rows.executeStep()) tasks.push_back(read_task(rows));
  return tasks;
}

template <class... Values>
std::optional<Task> select_task(SQLite::Database& db, std::string_view condition,
                                const Values&... values) {
  std::vector<Task> found = select_tasks(db, condition, values...);
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

/// Whether the item has a place for this task beside all the others.
bool has_place(SQLite::Database& db, const Task& task, std::int64_t now) {
  return store::find_number(
             db,
             "SELECT count(*) FROM task WHERE item = ? AND id <> ? AND "
             "(state IN ('submitted', 'accepted') OR (state = 'leased' AND expires > ?))",
             task.item.id, task.id, now) < task.per_item;
}

bool still_held(SQLite::Database& db, const Task& task, std::int64_t now) {
  const bool leased = task.state == "leased" || task.state == "lapsed";
  return leased && ((task.state == "leased" && task.expires > now) || has_place(db, task, now));
}

void renew(SQLite::Database& db, Task& task, const Visit& visit, std::int64_t now) {
  task.state = "leased";
  task.visit = visit.id;
  task.expires = now + task.lease_seconds;
  store::run(db, "UPDATE task SET state = 'leased', visit = ?, expires = ? WHERE id = ?", visit.id,
             task.expires, task.id);
}

/// What the worker may go on with: this visit's, or one that lapsed.
std::optional<Task> take_up(SQLite::Database& db, const Visit& visit, std::int64_t now) {
  std::vector<Task> held =
      select_tasks(db, "task.visit = ? AND task.state = 'leased' ORDER BY task.id", visit.id);
  for (Task& lapsed :
       select_tasks(db,
                    "task.worker = ?1 AND task.visit <> ?2 AND (task.state = 'lapsed' OR "
                    "(task.state = 'leased' AND task.expires <= ?3)) ORDER BY task.id",
                    visit.worker, visit.id, now)) {
    held.push_back(std::move(lapsed));
  }
  for (Task& task : held) {
    if (still_held(db, task, now)) {
      renew(db, task, visit, now);
      return std::move(task);
    }
    store::run(db, "UPDATE task SET state = 'lapsed' WHERE id = ?", task.id);
  }
  return std::nullopt;
}

/// An item that has a place and is new to the worker; 0 if there is none. Those with the fewest
/// places left first.
std::int64_t next_item(SQLite::Database& db, const Collection& collection, const Visit& visit,
                       std::int64_t now) {
  const std::int64_t begun = store::find_number(
      db,
      "SELECT id FROM (SELECT item.id AS id, (SELECT count(*) FROM task WHERE task.item = item.id "
      "AND (task.state IN ('submitted', 'accepted') OR (task.state = 'leased' AND task.expires > "
      "?3))) AS taken FROM item WHERE collection = ?1 AND item.state = 'begun' AND NOT EXISTS "
      "(SELECT 1 FROM task WHERE task.item = item.id AND task.worker = ?2)) "
      "WHERE taken < ?4 ORDER BY taken DESC, id LIMIT 1",
      collection.id, visit.worker, now, collection.per_item);
  if (begun != 0) return begun;
  return store::find_number(
      db, "SELECT id FROM item WHERE collection = ? AND state = 'fresh' ORDER BY id LIMIT 1",
      collection.id);
}

NoTask reason_for_none(SQLite::Database& db, const Collection& collection, const Visit& visit) {
  const bool others =
      store::find_number(db,
                         "SELECT 1 FROM item WHERE collection = ?1 AND state = 'begun' "
                         "AND NOT EXISTS (SELECT 1 FROM task WHERE task.item = item.id "
                         "AND task.worker = ?2) LIMIT 1",
                         collection.id, visit.worker) != 0;
  return others ? NoTask::kAllLeased : NoTask::kNoneLeft;
}

Lease lease_next(SQLite::Database& db, const Collection& collection, const Visit& visit,
                 std::int64_t now) {
  if (auto task = take_up(db, visit, now)) return {std::move(task), {}};
  if (has_had_all(collection, visit)) return {std::nullopt, NoTask::kFinished};
  if (!collection.open) return {std::nullopt, NoTask::kClosed};
  const std::int64_t item = next_item(db, collection, visit, now);
  if (item == 0) return {std::nullopt, reason_for_none(db, collection, visit)};
  store::run(db,
             "INSERT INTO task (item, worker, visit, state, expires) VALUES (?, ?, ?, 'leased', ?)",
             item, visit.worker, visit.id, now + collection.lease_seconds);
  const std::int64_t id = db.getLastInsertRowid();
  store::run(db, "UPDATE item SET state = 'begun' WHERE id = ? AND state = 'fresh'", item);
  return {select_task(db, "task.id = ?", id), {}};
}

Task own(SQLite::Database& db, const Visit& visit, std::int64_t id) {
  auto task = select_task(db, "task.id = ? AND task.visit = ?", id, visit.id);
  if (!task) throw http::HttpError(404, "unknown-task", "no such task of this worker");
  return std::move(*task);
}

void check_in_hand(SQLite::Database& db, const Task& task, std::int64_t now) {
  if (task.handed_in()) throw http::HttpError(409, "submitted", "it was handed in already");
  if (task.state == "returned") throw http::HttpError(409, "returned", "it was given back");
  if (!still_held(db, task, now)) {
    throw http::HttpError(409, "lease-lost", "it took too long, and others have it by now");
  }
}

/// The item's state, from those of its tasks.
void count_places(SQLite::Database& db, const Task& task) {
  store::run(
      db,
      "UPDATE item SET state = CASE WHEN (SELECT count(*) FROM task WHERE item = ?1 AND state IN "
      "('submitted', 'accepted')) >= ?2 THEN 'complete' ELSE 'begun' END WHERE id = ?1",
      task.item.id, task.per_item);
}

Task handed_in_task(SQLite::Database& db, std::int64_t id) {
  auto task = select_task(db, fmt::format("task.id = ? AND {}", kHandedIn), id);
  if (!task) throw http::HttpError(404, "unknown-task", "no work of this number was handed in");
  return std::move(*task);
}

void add_event(SQLite::Database& db, const Task& task, const Event& event) {
  store::run(db,
             "INSERT INTO event (task, at, who, what, before, reason) VALUES (?, ?, ?, ?, ?, ?)",
             task.id, event.at, event.who, event.what, event.before, event.reason);
}

}  // namespace

bool Task::bonus() const { return error && *error < r2r::MetricOptions{}.success_distance; }

std::string_view to_string(NoTask why) {
  constexpr std::array<std::string_view, 4> kNames{"finished", "none-left", "all-leased", "closed"};
  return kNames[static_cast<std::size_t>(why)];
}

Lease lease_task(store::Database& database, const Collection& collection, const Visit& visit,
                 std::int64_t now) {
  if (!visit.consented) throw http::HttpError(403, "no-consent", "the consent page comes first");
  return database.transact(
      [&](SQLite::Database& db) { return lease_next(db, collection, visit, now); });
}

std::optional<Task> held_task(store::Database& database, const Visit& visit) {
  return database.with([&](SQLite::Database& db) {
    return select_task(db, "task.visit = ? AND task.state = 'leased' ORDER BY task.id", visit.id);
  });
}

Task own_task(store::Database& database, const Visit& visit, std::int64_t task) {
  return database.with([&](SQLite::Database& db) { return own(db, visit, task); });
}

std::int64_t keep_draft(store::Database& database, const Visit& visit, std::int64_t id,
                        const std::string& draft, std::int64_t now) {
  return database.transact([&](SQLite::Database& db) {
    Task task = own(db, visit, id);
    check_in_hand(db, task, now);
    renew(db, task, visit, now);
    store::run(db, "UPDATE task SET draft = ? WHERE id = ?", draft, id);
    return task.expires;
  });
}

void give_back(store::Database& database, const Visit& visit, std::int64_t id, std::int64_t now) {
  database.transact([&](SQLite::Database& db) {
    const Task task = own(db, visit, id);
    if (task.state == "returned") return;
    check_in_hand(db, task, now);
    store::run(db, "UPDATE task SET state = 'returned' WHERE id = ?", id);
  });
}

void hand_in(store::Database& database, const Visit& visit, std::int64_t id, const HandedIn& work,
             std::int64_t now) {
  const std::string digest = detail::sha256(work.content);
  database.transact([&](SQLite::Database& db) {
    const Task task = own(db, visit, id);
    if (task.handed_in() && task.digest == digest) return;
    check_in_hand(db, task, now);
    store::run(
        db,
        "UPDATE task SET state = 'submitted', content = ?, digest = ?, seconds = ?, flags = ?, "
        "camera = ?, submitted = ?, draft = '' WHERE id = ?",
        work.content, digest, work.seconds, join_lines(work.flags), work.camera, now, id);
    if (work.error) store::run(db, "UPDATE task SET error = ? WHERE id = ?", *work.error, id);
    count_places(db, task);
  });
}

WorkPage list_work(store::Database& database, std::int64_t collection, const std::string& state,
                   std::int64_t after, std::int64_t limit) {
  const std::string condition =
      fmt::format("item.collection = ?1 AND {} AND (?2 = 'all' OR task.state = ?2)", kHandedIn);
  return database.with([&](SQLite::Database& db) {
    WorkPage page;
    page.matching = store::find_number(
        db, "SELECT count(*) FROM task JOIN item ON item.id = task.item WHERE " + condition,
        collection, state);
    page.tasks = select_tasks(db, condition + " AND task.id > ?3 ORDER BY task.id LIMIT ?4",
                              collection, state, after, limit);
    return page;
  });
}

std::vector<Task> collected(store::Database& database, std::int64_t collection,
                            const std::string& split, bool submitted_too) {
  return database.with([&](SQLite::Database& db) {
    return select_tasks(db,
                        "item.collection = ? AND item.split = ? AND (task.state = 'accepted' OR "
                        "(? AND task.state = 'submitted')) ORDER BY item.id, task.id",
                        collection, split, submitted_too ? 1 : 0);
  });
}

std::vector<Item> items_of(store::Database& database, std::int64_t collection,
                           const std::string& split) {
  return database.with([&](SQLite::Database& db) {
    SQLite::Statement rows(
        db, fmt::format("SELECT {} FROM item WHERE collection = ? AND split = ? ORDER BY id",
                        kItemColumns));
    SQLite::bind(rows, collection, split);
    std::vector<Item> items;
    while (rows.executeStep()) items.push_back(read_item(rows));
    return items;
  });
}

Task find_work(store::Database& database, std::int64_t task) {
  return database.with([&](SQLite::Database& db) { return handed_in_task(db, task); });
}

std::vector<Event> events_of(store::Database& database, std::int64_t task) {
  return database.with([&](SQLite::Database& db) {
    SQLite::Statement rows(
        db, "SELECT at, who, what, before, reason FROM event WHERE task = ? ORDER BY id");
    rows.bind(1, task);
    std::vector<Event> events;
    while (rows.executeStep()) {
      events.push_back({rows.getColumn(0).getInt64(), rows.getColumn(1).getString(),
                        rows.getColumn(2).getString(), rows.getColumn(3).getString(),
                        rows.getColumn(4).getString()});
    }
    return events;
  });
}

void judge(store::Database& database, std::int64_t id, Verdict verdict, const std::string& reason,
           const std::string& who, std::int64_t now) {
  const std::string state = verdict == Verdict::kAccepted ? "accepted" : "rejected";
  database.transact([&](SQLite::Database& db) {
    const Task task = handed_in_task(db, id);
    if (task.state == state && task.reason == reason) return;
    const bool comes_back = task.state == "rejected" && verdict == Verdict::kAccepted;
    if (comes_back && !has_place(db, task, now)) {
      throw http::HttpError(409, "place-taken",
                            "it was rejected, and others have its place by now");
    }
    store::run(db, "UPDATE task SET state = ?, reason = ? WHERE id = ?", state, reason, id);
    add_event(db, task, {now, who, state, "", reason});
    count_places(db, task);
  });
}

void edit(store::Database& database, std::int64_t id, const std::string& instruction,
          const std::string& who, std::int64_t now) {
  database.transact([&](SQLite::Database& db) {
    const Task task = handed_in_task(db, id);
    if (task.content == instruction) return;
    store::run(db, "UPDATE task SET content = ? WHERE id = ?", instruction, id);
    add_event(db, task, {now, who, "edited", task.content, ""});
  });
}

std::int64_t waiting_for_review(store::Database& database) {
  return database.with([](SQLite::Database& db) {
    return store::find_number(db, "SELECT count(*) FROM task WHERE state = 'submitted'");
  });
}

}  // namespace enfilade::service::collecting
