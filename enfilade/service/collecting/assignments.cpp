#include "enfilade/service/collecting/assignments.h"

#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/texts.h"
#include "enfilade/service/collecting/kinds/dialogues.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/metrics.h"

namespace enfilade::service::collecting {
namespace {

using detail::Reason;
using detail::Refusal;

constexpr std::size_t kBlockSize = 20;  // items
// Seconds by which a page's time may exceed the server's: its clock starts when the building is
// shown, and two clocks differ a little.
constexpr double kClockSlack = 5;
constexpr std::int64_t kSearchedAtOnce = 500;  // tasks, whose content may be long
constexpr const char* kIsSubmitted = "task.state IN ('submitted', 'accepted', 'rejected')";

std::string tasks_where(std::string_view condition) {
  return fmt::format(
      "SELECT {}, collection.kind, collection.per_item, collection.lease_seconds, task.id, "
      "task.worker, task.state, task.expires, task.draft, task.content, task.digest, "
      "task.seconds, task.flags, task.camera, task.error, task.leased, task.submitted, "
      "task.reason, "
      "task.role "
      "FROM task JOIN item ON item.id = task.item "
      "JOIN collection ON collection.id = item.collection WHERE {}",
      kItemColumns, condition);
}

/// Whether the item has a place for this task besides its other tasks.
bool has_place(store::Database& db, const Assignment& task) {
  if (task.item.practice) return true;
  return db.find_number(
             "SELECT count(*) FROM task WHERE item = ? AND id <> ? AND "
             "(state IN ('submitted', 'accepted') OR (state = 'leased' AND expires > ?))",
             task.item.id, task.id, db.now()) < task.per_item;
}

bool is_still_held(store::Database& db, const Assignment& task) {
  if (task.state == AssignmentState::kLeased && task.expires > db.now()) return true;
  const bool open =
      task.state == AssignmentState::kLeased || task.state == AssignmentState::kLapsed;
  if (task.kind == WorkKind::kDialogue && !kinds::holds_seat(db, task.id)) return false;
  return open && has_place(db, task);
}

void set_state(store::Database& db, const Assignment& task, AssignmentState state) {
  db.run("UPDATE task SET state = ? WHERE id = ?", state, task.id);
}

void renew(store::Database& db, Assignment& task, const Visit& visit) {
  task.state = AssignmentState::kLeased;
  task.expires = db.now() + task.lease_seconds;
  db.run("UPDATE task SET state = ?, visit = ?, expires = ? WHERE id = ?", task.state, visit.id,
         task.expires, task.id);
}

/// The task that the worker may continue: this visit's, or one that lapsed.
std::optional<Assignment> resume(store::Database& db, const Visit& visit) {
  std::vector<Assignment> held =
      db.select<Assignment>(tasks_where("(task.visit = ?2 AND task.state = 'leased') OR "
                                        "(task.worker = ?1 AND task.visit <> ?2 AND "
                                        "(task.state = 'lapsed' OR (task.state = 'leased' AND "
                                        "task.expires <= ?3))) ORDER BY task.visit <> ?2, task.id"),
                            visit.worker, visit.id, db.now());
  for (Assignment& task : held) {
    if (is_still_held(db, task)) {
      renew(db, task, visit);
      return std::move(task);
    }
    set_state(db, task, AssignmentState::kLapsed);
  }
  return std::nullopt;
}

/// Shortens leases that were made by a clock that was ahead to `lease_seconds` from now. Otherwise
/// no one else would get those places until the clock is there again.
void shorten_leases(store::Database& db, const Collection& collection) {
  db.run(
      "UPDATE task SET expires = ?2 WHERE state = 'leased' AND expires > ?2 AND item IN "
      "(SELECT id FROM item WHERE collection = ?1)",
      collection.id, db.now() + collection.lease_seconds);
}

NoTask reason_for_none(store::Database& db, const Collection& collection, const Visit& visit) {
  const bool others = db.find_number(
                          "SELECT 1 FROM item WHERE collection = ?1 AND state = 'begun' AND "
                          "practice = 0 "
                          "AND NOT EXISTS (SELECT 1 FROM task WHERE task.item = item.id "
                          "AND task.worker = ?2) LIMIT 1",
                          collection.id, visit.worker) != 0;
  if (!others) return NoTask::kNoneLeft;
  shorten_leases(db, collection);
  return NoTask::kAllLeased;
}

struct Candidate {
  std::int64_t id = 0, path_id = 0, number = 0;

  auto columns() { return std::tie(id, path_id, number); }
};

constexpr std::string_view kHasPlace =
    "(SELECT count(*) FROM task WHERE task.item = item.id AND (task.state IN ('submitted', "
    "'accepted') OR (task.state = 'leased' AND task.expires > ?3))) < ?4";
// The list does not depend on the item: SQLite makes it once for a query.
constexpr std::string_view kNewPath =
    "path_id NOT IN (SELECT had.path_id FROM task JOIN item AS had ON had.id = task.item "
    "WHERE task.worker = ?2)";
constexpr std::string_view kNewItem =
    "NOT EXISTS (SELECT 1 FROM task WHERE task.item = item.id AND task.worker = ?2)";

/// The worker's next item among those that are new by the rule; 0 if none has a place.
std::int64_t next_of(store::Database& db, const Collection& collection, std::int64_t worker,
                     std::string_view is_new) {
  const std::string open = fmt::format(
      "FROM item WHERE collection = ?1 AND practice = 0 AND state <> 'complete' AND {} AND {}",
      is_new, kHasPlace);
  const auto block =
      db.find<std::int64_t>(fmt::format("SELECT block {} ORDER BY block LIMIT 1", open),
                            collection.id, worker, db.now(), collection.per_item);
  if (!block) return 0;
  const auto candidates =
      db.select<Candidate>(fmt::format("SELECT id, path_id, number {} AND block = ?5", open),
                           collection.id, worker, db.now(), collection.per_item, *block);
  const auto rank = [&](const Candidate& one) {
    return std::pair(detail::sha256(fmt::format("{} {} {} {}", collection.seed, worker, one.path_id,
                                                one.number)),
                     one.id);
  };
  return std::ranges::min(candidates, {}, rank).id;
}

/// The worker's next item that has a place; 0 if there is none.
std::int64_t next_item(store::Database& db, const Collection& collection, std::int64_t worker) {
  const std::int64_t practice = db.find_number(
      fmt::format("SELECT id FROM item WHERE collection = ?1 AND practice = 1 AND state <> "
                  "'complete' AND {} ORDER BY id LIMIT 1",
                  kNewItem),
      collection.id, worker);
  if (practice != 0) return practice;
  const std::int64_t first = next_of(db, collection, worker, kNewPath);
  return first != 0 ? first : next_of(db, collection, worker, kNewItem);
}

Lease lease_next(store::Database& db, const Collection& collection, const Visit& visit) {
  if (is_screened_out(db, visit.worker)) return {std::nullopt, NoTask::kScreenedOut};
  if (auto task = resume(db, visit)) return {std::move(task), {}};
  if (is_finished(collection, visit)) return {std::nullopt, NoTask::kFinished};
  if (!collection.open) return {std::nullopt, NoTask::kClosed};
  const bool dialogue = collection.kind == WorkKind::kDialogue;
  const auto seat = dialogue ? kinds::find_seat(db, collection, visit.worker) : std::nullopt;
  const std::int64_t item = seat ? seat->item : next_item(db, collection, visit.worker);
  if (item == 0) return {std::nullopt, reason_for_none(db, collection, visit)};
  if (!pending_questions_of(db, collection, visit).empty()) {
    return {std::nullopt, NoTask::kQuestions};
  }
  const std::int64_t id = db.insert(
      "INSERT INTO task (item, worker, visit, state, expires, leased) VALUES (?, ?, ?, ?, ?, ?)",
      item, visit.worker, visit.id, AssignmentState::kLeased, db.now() + collection.lease_seconds,
      db.now());
  db.run("UPDATE item SET state = 'begun' WHERE id = ? AND state = 'fresh'", item);
  if (dialogue) kinds::take_seat(db, seat, id, item);
  return {db.find<Assignment>(tasks_where("task.id = ?"), id), {}};
}

void check_held(store::Database& db, const Assignment& task) {
  if (task.is_submitted()) {
    throw Refusal(Reason::kAlreadySubmitted, "the task was submitted before");
  }
  if (task.state == AssignmentState::kReturned) {
    throw Refusal(Reason::kAlreadyReturned, "the task was returned before");
  }
  if (!is_still_held(db, task)) {
    throw Refusal(Reason::kLeaseExpired, "the lease ended, and another worker has the task now");
  }
}

void add_event(store::Database& db, const Assignment& task, const Event& event) {
  db.run("INSERT INTO event (task, at, who, what, before, reason) VALUES (?, ?, ?, ?, ?, ?)",
         task.id, event.at, event.who, event.what, event.before, event.reason);
}

/// \throws Refusal kConflict if its content is no text alone
void correct(store::Database& db, const Assignment& task, const std::string& instruction,
             const std::string& who) {
  if (!is_written(task.kind)) {
    throw Refusal(Reason::kConflict,
                  is_followed(task.kind)
                      ? "the task is a walk, which has no instruction to change"
                      : "the words of this task belong to moments, and can't be changed");
  }
  if (task.content == instruction) return;
  db.run("UPDATE task SET content = ? WHERE id = ?", instruction, task.id);
  add_event(db, task, {db.now(), who, EventKind::kEdited, task.content, ""});
}

/// \pre within a transaction  \throws Refusal as review()
void judge(store::Database& db, const Assignment& task, const Verdict& verdict,
           const std::string& who) {
  const bool accepted = verdict.state == AssignmentState::kAccepted;
  if (!verdict.instruction.empty()) correct(db, task, verdict.instruction, who);
  if (task.state == verdict.state && task.reason == verdict.reason) return;
  if (accepted && task.state == AssignmentState::kRejected && !has_place(db, task)) {
    throw Refusal(
        Reason::kConflict,
        fmt::format("task {} was rejected, and another worker has its place now", task.id));
  }
  db.run("UPDATE task SET state = ?, reason = ? WHERE id = ?", verdict.state, verdict.reason,
         task.id);
  add_event(
      db, task,
      {db.now(), who, accepted ? EventKind::kAccepted : EventKind::kRejected, "", verdict.reason});
  update_item(db, task);
}

/// What is searched of a task; `content` is empty where a text was followed.
struct WorkText {
  std::int64_t id = 0;
  WorkKind kind = WorkKind::kWrite;
  std::string content, instruction, target;

  auto columns() { return std::tie(id, kind, content, instruction, target); }

  /// \param wanted in lower case
  bool has(const std::string& wanted) const {
    const auto is_in = [&wanted](const std::string& text) {
      return lower_case(text).find(wanted) != std::string::npos;
    };
    if (is_in(target)) return true;
    if (is_followed(kind)) return is_in(instruction);
    if (is_written(kind)) return is_in(content);
    const auto read = nlohmann::json::parse(content);
    if (kind == WorkKind::kGuide) return is_in(read.at("instruction").get<std::string>());
    for (const auto& turn : read.at("turns")) {
      if (is_in(turn.value("text", std::string()))) return true;
    }
    return false;
  }
};

/// list_work() with a text. The tasks are read in parts, which bounds the memory; other requests
/// use the database in between.
/// \param condition of ?1 to ?4
WorkPage search_work(store::Database& db, std::int64_t collection, const WorkFilter& filter,
                     const std::string& condition, std::int64_t after, std::int64_t limit) {
  const std::string sql = fmt::format(
      "SELECT task.id, kind, CASE WHEN kind IN ('walk', 'find') THEN '' ELSE content END, "
      "instruction, target FROM task JOIN item ON item.id = task.item JOIN collection ON "
      "collection.id = item.collection WHERE {} AND task.id > ?5 ORDER BY task.id LIMIT ?6",
      condition);
  const std::string wanted = lower_case(filter.text);
  std::vector<std::int64_t> found;
  std::int64_t last = 0;
  for (bool more = true; more;) {
    const auto some = db.select<WorkText>(sql, collection, filter.state, filter.worker,
                                          filter.path_id, last, kSearchedAtOnce);
    for (const WorkText& one : some) {
      if (one.has(wanted)) found.push_back(one.id);
      last = one.id;
    }
    more = std::ssize(some) == kSearchedAtOnce;
  }
  WorkPage page{std::ssize(found), {}};
  for (const std::int64_t id : found) {
    if (std::ssize(page.tasks) == limit) break;
    if (id <= after) continue;
    if (auto task = db.find<Assignment>(tasks_where("task.id = ?"), id)) {
      page.tasks.push_back(std::move(*task));
    }
  }
  return page;
}

}  // namespace

bool is_finished(const Collection& collection, const Visit& visit) {
  return collection.tasks_per_visit > 0 && visit.done >= collection.tasks_per_visit;
}

std::int64_t join(store::Database& db, const Collection& collection, const Arrival& arrival) {
  return db.transact([&] {
    db.run(
        "INSERT INTO worker (collection, external, created) VALUES (?, ?, ?) ON CONFLICT DO "
        "NOTHING",
        collection.id, arrival.worker, db.now());
    const std::int64_t worker =
        db.find_number("SELECT id FROM worker WHERE collection = ? AND external = ?", collection.id,
                       arrival.worker);
    const std::int64_t known = db.find_number(
        "SELECT id FROM visit WHERE worker = ? AND external = ?", worker, arrival.assignment);
    if (known != 0) return known;
    if (!collection.open) {
      throw Refusal(Reason::kCollectionClosed, "the collection is closed");
    }
    const bool taken = !arrival.assignment.empty() &&
                       db.find_number(
                           "SELECT visit.id FROM visit JOIN worker ON worker.id = visit.worker "
                           "WHERE worker.collection = ? AND visit.external = ?",
                           collection.id, arrival.assignment) != 0;
    if (taken) throw Refusal(Reason::kConflict, "another worker has this assignment");
    return db.insert(
        "INSERT INTO visit (worker, external, grouped, submit_to, created) VALUES (?, ?, ?, ?, ?)",
        worker, arrival.assignment, arrival.group, arrival.submit_to, db.now());
  });
}

Visit get_visit(store::Database& db, std::int64_t visit) {
  constexpr std::string_view kDone =
      "FROM task JOIN item ON item.id = task.item WHERE practice = 0 AND task.state IN "
      "('submitted', 'accepted', 'rejected')";
  return db.get<Visit>(
      fmt::format(
          "SELECT visit.id, worker.id, consented IS NOT NULL AND consented >= consent_changed, "
          "visit.external, submit_to, (SELECT count(*) {0} AND task.visit = visit.id), "
          "(SELECT count(*) {0} AND task.worker = worker.id), "
          "(SELECT count(*) {0} AND task.worker = worker.id AND secret = 0 AND error < ?2) "
          "FROM visit JOIN worker ON worker.id = visit.worker "
          "JOIN collection ON collection.id = worker.collection WHERE visit.id = ?1",
          kDone),
      visit, tasks::MetricOptions{}.success_distance);
}

void give_consent(store::Database& db, const Visit& visit) {
  if (visit.consented) return;
  db.run("UPDATE worker SET consented = ? WHERE id = ?", db.now(), visit.worker);
}

std::optional<std::int64_t> Assignment::server_seconds() const {
  if (leased == 0 || submitted < leased) return std::nullopt;  // the clock was set back
  return submitted - leased;
}

bool Assignment::bonus() const { return error && *error < tasks::MetricOptions{}.success_distance; }

Lease lease_task(store::Database& db, const Collection& collection, const Visit& visit) {
  if (!visit.consented) {
    throw Refusal(Reason::kConsentRequired, "the consent page comes first");
  }
  return db.transact([&] { return lease_next(db, collection, visit); });
}

std::vector<Question> pending_questions_of(store::Database& db, const Collection& collection,
                                           const Visit& visit) {
  return pending_questions(db, collection.id, visit.worker, visit.done_by_worker,
                           collection.check_every);
}

bool has_had_all(store::Database& db, const Collection& collection, const Visit& visit) {
  return db.find_number(
             "SELECT 1 FROM item WHERE collection = ?1 AND practice = 0 AND NOT EXISTS (SELECT 1 "
             "FROM task WHERE task.item = item.id AND task.worker = ?2 AND task.state NOT IN "
             "('leased', 'lapsed')) LIMIT 1",
             collection.id, visit.worker) == 0;
}

std::vector<Assignment> rejected_of(store::Database& db, const Visit& visit) {
  return db.select<Assignment>(
      tasks_where("task.worker = ? AND task.state = 'rejected' ORDER BY task.id LIMIT 100"),
      visit.worker);
}

std::optional<Assignment> held_task(store::Database& db, const Visit& visit) {
  return db.find<Assignment>(
      tasks_where("task.visit = ? AND task.state = 'leased' ORDER BY task.id"), visit.id);
}

Assignment own_task(store::Database& db, const Visit& visit, std::int64_t id) {
  auto task = db.find<Assignment>(tasks_where("task.id = ? AND task.visit = ?"), id, visit.id);
  if (!task) throw Refusal(Reason::kNotFound, "no such task of this worker");
  return std::move(*task);
}

std::int64_t save_draft(store::Database& db, const Visit& visit, std::int64_t id,
                        const std::string& draft) {
  return db.transact([&] {
    Assignment task = own_task(db, visit, id);
    check_held(db, task);
    renew(db, task, visit);
    db.run("UPDATE task SET draft = ? WHERE id = ?", draft, id);
    return task.expires;
  });
}

void update_item(store::Database& db, const Assignment& task) {
  if (task.item.practice) return;  // everybody does it
  db.run(
      "UPDATE item SET state = CASE WHEN (SELECT count(*) FROM task WHERE item = ?1 AND state IN "
      "('submitted', 'accepted')) >= ?2 THEN 'complete' ELSE 'begun' END WHERE id = ?1",
      task.item.id, task.per_item);
}

void renew_lease(store::Database& db, const Visit& visit, std::int64_t id) {
  Assignment task = own_task(db, visit, id);
  check_held(db, task);
  renew(db, task, visit);
}

void return_task(store::Database& db, const Visit& visit, std::int64_t id) {
  db.transact([&] {
    const Assignment task = own_task(db, visit, id);
    if (task.state == AssignmentState::kReturned) return;
    check_held(db, task);
    set_state(db, task, AssignmentState::kReturned);
  });
}

void submit(store::Database& db, const Visit& visit, std::int64_t id, const SubmittedWork& work) {
  const std::string digest = detail::sha256(work.content);
  db.transact([&] {
    Assignment task = own_task(db, visit, id);
    if (task.is_submitted() && task.digest == digest) return;
    check_held(db, task);
    task.submitted = db.now();
    std::vector<std::string> flags = work.flags;
    // The page cannot have been open for longer than the worker has the task.
    const auto known = task.server_seconds();
    if (known && work.seconds > static_cast<double>(*known) + kClockSlack) {
      flags.emplace_back("time-mismatch");
    }
    db.run(
        "UPDATE task SET state = ?, content = ?, digest = ?, seconds = ?, flags = ?, camera = ?, "
        "error = ?, submitted = ?, draft = '' WHERE id = ?",
        AssignmentState::kSubmitted, work.content, digest, work.seconds, flags, work.camera,
        work.error, task.submitted, id);
    update_item(db, task);
  });
}

WorkPage list_work(store::Database& db, std::int64_t collection, const WorkFilter& filter,
                   std::int64_t after, std::int64_t limit) {
  const std::string condition = fmt::format(
      "item.collection = ?1 AND practice = 0 AND {} AND (?2 IS NULL OR task.state = ?2) AND (?3 IS "
      "NULL OR task.worker = ?3) AND (?4 IS NULL OR path_id = ?4)",
      kIsSubmitted);
  if (!filter.text.empty()) return search_work(db, collection, filter, condition, after, limit);
  const auto held = db.hold();
  return {
      db.find_number(
          "SELECT count(*) FROM task JOIN item ON item.id = task.item WHERE " + condition,
          collection, filter.state, filter.worker, filter.path_id),
      db.select<Assignment>(tasks_where(condition + " AND task.id > ?5 ORDER BY task.id LIMIT ?6"),
                            collection, filter.state, filter.worker, filter.path_id, after, limit)};
}

std::vector<WorkSummary> summarise_work(store::Database& db, std::int64_t collection, SummaryBy by,
                                        std::int64_t after, std::int64_t limit) {
  constexpr std::string_view kChecks =
      "SELECT count(*) FROM answer JOIN question ON question.id = question "
      "WHERE answer.worker = task.worker AND stage = 'check'";
  const bool of_worker = by == SummaryBy::kWorker;
  return db.select<WorkSummary>(
      fmt::format(
          "SELECT {0}, count(*) FILTER (WHERE task.state = 'submitted'), "
          "count(*) FILTER (WHERE task.state = 'accepted'), "
          "count(*) FILTER (WHERE task.state = 'rejected'), count(*) FILTER (WHERE flags <> ''), "
          "coalesce(avg(CASE WHEN submitted > leased THEN submitted - leased ELSE 0 END) "
          "FILTER (WHERE leased > 0), 0), {1}, {2} "
          "FROM task JOIN item ON item.id = task.item WHERE item.collection = ?1 AND practice = 0 "
          "AND {3} AND {0} > ?2 GROUP BY {0} ORDER BY {0} LIMIT ?3",
          of_worker ? "task.worker" : "path_id",
          of_worker ? fmt::format("({})", kChecks) : std::string("0"),
          of_worker ? fmt::format("({} AND answer.accepted = 0)", kChecks) : std::string("0"),
          kIsSubmitted),
      collection, after, limit);
}

std::vector<Assignment> work_of(store::Database& db, const ExportedSplit& exported) {
  return db.select<Assignment>(
      tasks_where("item.collection = ? AND item.split = ? AND practice = 0 AND (task.state = "
                  "'accepted' OR "
                  "(? = 1 AND task.state = 'submitted')) ORDER BY item.id, task.id"),
      exported.collection.id, exported.split, exported.with_waiting);
}

std::vector<Assignment> submitted_of(store::Database& db, const ExportedSplit& exported) {
  return db.select<Assignment>(
      tasks_where(fmt::format("item.collection = ? AND item.split = ? AND {} ORDER BY task.id",
                              kIsSubmitted)),
      exported.collection.id, exported.split);
}

Assignment find_work(store::Database& db, std::int64_t id) {
  auto task = db.find<Assignment>(tasks_where(fmt::format("task.id = ? AND {}", kIsSubmitted)), id);
  if (!task) throw Refusal(Reason::kNotFound, "no submitted task has this number");
  return std::move(*task);
}

Verified verified_of(store::Database& db, std::int64_t task) {
  return db.get<Verified>(
      "SELECT count(*), count(*) FILTER (WHERE error < ?2) FROM task JOIN item ON item.id = "
      "task.item WHERE item.of "
      "= ?1 AND practice = 0 AND task.state IN ('submitted', 'accepted')",
      task, tasks::MetricOptions{}.success_distance);
}

std::vector<Event> events_of(store::Database& db, std::int64_t task) {
  return db.select<Event>(
      "SELECT at, who, what, before, reason FROM event WHERE task = ? ORDER BY id", task);
}

void review(store::Database& db, std::int64_t id, const Verdict& verdict, const std::string& who) {
  db.transact([&] { judge(db, find_work(db, id), verdict, who); });
}

void review_all(store::Database& db, std::int64_t collection,
                const std::vector<std::int64_t>& tasks, const Verdict& verdict,
                const std::string& who) {
  db.transact([&] {
    for (const std::int64_t id : tasks) {
      const auto task =
          db.find<Assignment>(tasks_where(fmt::format("task.id = ? AND item.collection = ? AND "
                                                      "practice = 0 AND {}",
                                                      kIsSubmitted)),
                              id, collection);
      if (!task) {
        throw Refusal(Reason::kNotFound,
                      fmt::format("task {} is no submitted one of this collection", id));
      }
      judge(db, *task, verdict, who);
    }
  });
}

void edit(store::Database& db, std::int64_t id, const std::string& instruction,
          const std::string& who) {
  db.transact([&] { correct(db, find_work(db, id), instruction, who); });
}

std::int64_t waiting_for_review(store::Database& db) {
  return db.find_number(
      "SELECT count(*) FROM task JOIN item ON item.id = task.item WHERE task.state = 'submitted' "
      "AND practice = 0");
}

void assign_blocks(std::int64_t seed, std::vector<WorkItem>& items) {
  std::vector<std::pair<std::string, WorkItem*>> ranked;
  for (WorkItem& item : items) {
    if (item.practice) continue;
    ranked.emplace_back(detail::sha256(fmt::format("{} {} {}", seed, item.path_id, item.number)),
                        &item);
  }
  std::ranges::sort(ranked, {}, &std::pair<std::string, WorkItem*>::first);
  for (std::size_t k = 0; k < ranked.size(); ++k) {
    ranked[k].second->block = static_cast<std::int64_t>(k / kBlockSize);
  }
}

std::int64_t count_open_items(store::Database& db, const Collection& collection,
                              std::int64_t worker, std::int64_t most) {
  return db.find_number(
      fmt::format("SELECT count(*) FROM (SELECT 1 FROM item WHERE collection = ?1 AND practice = 0 "
                  "AND state <> 'complete' AND {} AND {} LIMIT ?5) AS open_items",
                  kNewItem, kHasPlace),
      collection.id, worker, db.now(), collection.per_item, most);
}

std::int64_t count_practice(store::Database& db, const Collection& collection,
                            std::int64_t worker) {
  return db.find_number(
      fmt::format("SELECT count(*) FROM item WHERE collection = ?1 AND practice = 1 AND state <> "
                  "'complete' AND {}",
                  kNewItem),
      collection.id, worker);
}

}  // namespace enfilade::service::collecting
