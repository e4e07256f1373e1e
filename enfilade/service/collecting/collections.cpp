#include "enfilade/service/collecting/collections.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <utility>

#include "enfilade/service/collecting/assignments.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/metrics.h"

namespace enfilade::service::collecting {
namespace {

using detail::Reason;
using detail::Refusal;

constexpr std::size_t kKeySize = 32;  // digits: 128 bits

constexpr std::string_view kCollectionColumns =
    "name, title, kind, open, link_key, platform, origins, completion_code, screen_out_code, "
    "consent, instructions, per_item, lease_seconds, tasks_per_visit, collection.created, "
    "archived, seed, pay, minutes, check_every, consent_changed, language";

std::string collections_where(std::string_view condition) {
  return fmt::format("SELECT collection.id, {} FROM collection {}", kCollectionColumns, condition);
}

/// Gives it a key, a time and an id. \throws Refusal kConflict if its name is taken
void insert_collection(store::Database& db, Collection& c) {
  if (find_collection(db, c.name)) {
    throw Refusal(Reason::kConflict, "name: another collection has it");
  }
  c.created = db.now();
  c.key = detail::new_secret("").substr(0, kKeySize);
  c.id = db.insert(
      "INSERT INTO collection (name, title, kind, open, link_key, platform, origins, "
      "completion_code, screen_out_code, consent, instructions, per_item, lease_seconds, "
      "tasks_per_visit, created, seed, pay, minutes, check_every, language) "
      "VALUES (?, ?, ?, 1, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
      c.name, c.title, c.kind, c.key, c.platform.kind, c.platform.origins,
      c.platform.completion_code, c.platform.screen_out_code, c.consent, c.instructions, c.per_item,
      c.lease_seconds, c.tasks_per_visit, c.created, c.seed, c.pay, c.minutes, c.check_every,
      c.language);
}

void insert_item(store::Database& db, std::int64_t collection, const WorkItem& item) {
  db.run(
      "INSERT INTO item (collection, split, path_id, number, scan, heading, path, distance, "
      "instruction, secret, practice, block, object, target, region, outlines, of, state) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, 'fresh')",
      collection, item.split, item.path_id, item.number, item.scan, item.heading.value, item.path,
      item.distance, item.instruction, item.secret, item.practice, item.block, item.object,
      item.target, item.region, item.outlines, item.of);
}

void add_questions(store::Database& db, std::int64_t collection,
                   const std::vector<Question>& questions) {
  for (const Question& one : questions) {
    db.run(
        "INSERT INTO question (collection, stage, text, choices, accepted) VALUES (?, ?, ?, ?, ?)",
        collection, one.stage, one.text, one.choices, one.accepted);
  }
}

std::vector<Question> unanswered(store::Database& db, std::int64_t collection, std::int64_t worker,
                                 QuestionStage stage) {
  return db.select<Question>(
      "SELECT id, stage, text, choices, accepted FROM question WHERE collection = ? AND stage = ? "
      "AND NOT EXISTS (SELECT 1 FROM answer WHERE question = question.id AND worker = ?) "
      "ORDER BY id",
      collection, stage, worker);
}

constexpr std::size_t kLongestWorker = 100;
constexpr std::size_t kLongestOrigin = 200;
// What MTurk sends as assignment before the worker has accepted it.
constexpr std::string_view kNoAssignment = "ASSIGNMENT_ID_NOT_AVAILABLE";

std::string parameter(const Parameters& parameters, std::string_view name) {
  const auto found = parameters.find(name);
  return found == parameters.end() ? std::string() : found->second;
}

std::string external_id(const Parameters& parameters, std::string_view name) {
  std::string value = parameter(parameters, name);
  if (!detail::is_external_id(value)) {
    throw Refusal(
        Reason::kInvalidInput,
        fmt::format("{}: {:?}, not 1 to 100 of A-Z, a-z, 0-9, - and _", name, value.substr(0, 40)));
  }
  return value;
}

Arrival by_link(const Parameters& parameters) {
  constexpr std::size_t kNameSize = 34;  // "w-" and 128 bits
  const auto named = parameters.find("worker");
  if (named == parameters.end())
    return {false, detail::new_secret("w-").substr(0, kNameSize), "", "", ""};
  if (!detail::is_label(named->second, kLongestWorker)) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("worker: not 1 to {} printable characters", kLongestWorker));
  }
  return {false, named->second, "", "", ""};
}

Arrival by_mturk(const Platform& platform, const Parameters& parameters) {
  const std::string assignment = parameter(parameters, "assignmentId");
  if (assignment.empty() || assignment == kNoAssignment) return {true, "", "", "", ""};
  std::string submit_to = parameter(parameters, "turkSubmitTo");
  while (submit_to.ends_with('/')) submit_to.pop_back();
  // The origin is part of the page's address, which anybody can write: an unknown one could send
  // the form, and the worker, anywhere.
  if (std::ranges::find(platform.origins, submit_to) == platform.origins.end()) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("turkSubmitTo: {:?}, not one of the collection's origins",
                              submit_to.substr(0, 80)));
  }
  return {false, external_id(parameters, "workerId"), external_id(parameters, "assignmentId"),
          external_id(parameters, "hitId"), std::move(submit_to)};
}

// Opened by its author: the ids are absent, or the placeholders as they stand in the link.
bool is_bare(const Parameters& parameters) {
  return std::ranges::all_of(std::array{"PROLIFIC_PID", "SESSION_ID", "STUDY_ID"},
                             [&](std::string_view name) {
                               const std::string value = parameter(parameters, name);
                               return value.empty() || value == fmt::format("{{{{%{}%}}}}", name);
                             });
}

Arrival by_prolific(const Parameters& parameters) {
  if (is_bare(parameters)) return {true, "", "", "", ""};
  return {false, external_id(parameters, "PROLIFIC_PID"), external_id(parameters, "SESSION_ID"),
          external_id(parameters, "STUDY_ID"), ""};
}

}  // namespace

Collection add_collection(store::Database& db, const NewCollection& added) {
  Collection collection = added.about;
  db.transact([&] {
    insert_collection(db, collection);
    for (const WorkItem& item : added.items) insert_item(db, collection.id, item);
    add_questions(db, collection.id, added.questions);
  });
  return collection;
}

Collection copy_collection(store::Database& db, const Collection& from, Collection copy) {
  db.transact([&] {
    insert_collection(db, copy);
    auto items = db.select<WorkItem>(
        fmt::format("SELECT {} FROM item WHERE collection = ? ORDER BY id", kItemColumns), from.id);
    assign_blocks(copy.seed, items);
    for (const WorkItem& item : items) insert_item(db, copy.id, item);
    add_questions(db, copy.id, questions_of(db, from.id));
  });
  return copy;
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

std::vector<Collection> list_collections(store::Database& db, std::string_view text,
                                         bool archived) {
  auto found = db.select<Collection>(collections_where(
      fmt::format("WHERE archived IS {} NULL ORDER BY collection.id", archived ? "NOT" : "")));
  const std::string wanted = lower_case(text);
  const auto has = [&wanted](const std::string& words) {
    return lower_case(words).find(wanted) != std::string::npos;
  };
  std::erase_if(found, [&has](const Collection& one) { return !has(one.name) && !has(one.title); });
  return found;
}

void change_collection(store::Database& db, const Collection& c) {
  db.transact([&] {
    db.run(
        "UPDATE collection SET title = ?, open = ?, archived = ?, consent = ?, instructions = ?, "
        "per_item = ?, lease_seconds = ?, tasks_per_visit = ?, pay = ?, minutes = ?, "
        "check_every = ?, completion_code = ?, screen_out_code = ?, consent_changed = CASE WHEN "
        "consent = ?4 THEN consent_changed ELSE ?14 END WHERE id = ?15",
        c.title, c.open, c.archived, c.consent, c.instructions, c.per_item, c.lease_seconds,
        c.tasks_per_visit, c.pay, c.minutes, c.check_every, c.platform.completion_code,
        c.platform.screen_out_code, db.now(), c.id);
    // Fewer or more places an item: which are complete is another matter then.
    db.run(
        "UPDATE item SET state = CASE WHEN (SELECT count(*) FROM task WHERE item = item.id AND "
        "state IN ('submitted', 'accepted')) >= ?2 THEN 'complete' ELSE 'begun' END "
        "WHERE collection = ?1 AND practice = 0 AND state <> 'fresh'",
        c.id, c.per_item);
  });
}

Progress progress_of(store::Database& db, std::int64_t collection) {
  const auto held = db.hold();
  Progress progress = db.get<Progress>(
      "SELECT (SELECT count(*) FROM item WHERE collection = ?1 AND practice = 0), "
      "(SELECT count(*) FROM item WHERE collection = ?1 AND practice = 0 AND state = 'complete'), "
      "count(*) FILTER (WHERE task.state = 'leased' AND expires > ?2), "
      "count(*) FILTER (WHERE task.state = 'submitted'), "
      "count(*) FILTER (WHERE task.state = 'accepted'), "
      "count(*) FILTER (WHERE task.state = 'rejected'), "
      "count(DISTINCT worker) "
      "FROM task JOIN item ON item.id = task.item WHERE item.collection = ?1 AND practice = 0",
      collection, db.now());
  progress.minutes =
      db.find<double>(
            "SELECT (submitted - leased) / 60.0 AS minutes FROM task JOIN item ON item.id = "
            "task.item WHERE collection = ?1 AND practice = 0 AND submitted > 0 AND leased > 0 "
            "ORDER BY minutes LIMIT 1 OFFSET (SELECT count(*) / 2 FROM task JOIN item ON item.id = "
            "task.item WHERE collection = ?1 AND practice = 0 AND submitted > 0 AND leased > 0)",
            collection)
          .value_or(0);
  return progress;
}

std::vector<SplitSize> splits_of(store::Database& db, std::int64_t collection) {
  return db.select<SplitSize>(
      "SELECT split, count(*), max(secret) FROM item WHERE collection = ? AND practice = 0 "
      "GROUP BY split ORDER BY min(id)",
      collection);
}

std::vector<VisitSummary> visits_of(store::Database& db, const Collection& collection) {
  return db.select<VisitSummary>(
      "SELECT visit.id, worker.id, worker.external, visit.external, grouped, visit.created, "
      "count(*) FILTER (WHERE state = 'submitted'), count(*) FILTER (WHERE state = 'accepted'), "
      "count(*) FILTER (WHERE state = 'rejected'), "
      "count(*) FILTER (WHERE error < ?2 AND state IN ('submitted', 'accepted')), "
      "?3 > 0 AND count(*) FILTER (WHERE state IN ('submitted', 'accepted', 'rejected')) >= ?3, "
      "coalesce(sum(submitted - leased) FILTER (WHERE leased > 0 AND submitted > leased), 0), "
      "(SELECT count(*) FROM answer JOIN question ON question.id = question WHERE answer.worker = "
      "worker.id AND stage = 'check'), "
      "(SELECT count(*) FROM answer JOIN question ON question.id = question WHERE answer.worker = "
      "worker.id AND stage = 'check' AND answer.accepted = 0), "
      "EXISTS (SELECT 1 FROM answer JOIN question ON question.id = question WHERE answer.worker = "
      "worker.id AND stage = 'screening' AND answer.accepted = 0) "
      "FROM visit JOIN worker ON worker.id = visit.worker "
      "LEFT JOIN (SELECT task.visit AS by, task.state AS state, error, submitted, leased FROM task "
      "JOIN item ON item.id = task.item WHERE practice = 0) AS done ON done.by = visit.id "
      "WHERE worker.collection = ?1 GROUP BY visit.id, worker.id ORDER BY visit.id",
      collection.id, tasks::MetricOptions{}.success_distance, collection.tasks_per_visit);
}

std::vector<WorkItem> items_of(store::Database& db, std::int64_t collection,
                               std::string_view split) {
  return db.select<WorkItem>(
      fmt::format("SELECT {} FROM item WHERE collection = ?1 AND split = ?2 AND practice = 0 "
                  "ORDER BY id",
                  kItemColumns),
      collection, split);
}

WorkItem first_item(store::Database& db, std::int64_t collection) {
  return db.get<WorkItem>(
      fmt::format("SELECT {} FROM item WHERE collection = ? ORDER BY practice DESC, id "
                  "LIMIT 1",
                  kItemColumns),
      collection);
}

std::vector<Question> questions_of(store::Database& db, std::int64_t collection) {
  return db.select<Question>(
      "SELECT id, stage, text, choices, accepted FROM question WHERE collection = ? ORDER BY id",
      collection);
}

std::vector<Question> pending_questions(store::Database& db, std::int64_t collection,
                                        std::int64_t worker, std::int64_t done, int every) {
  std::vector<Question> pending = unanswered(db, collection, worker, QuestionStage::kScreening);
  if (!pending.empty()) return pending;
  const std::int64_t answered = db.find_number(
      "SELECT count(*) FROM answer JOIN question ON question.id = question WHERE worker = ? AND "
      "stage = ?",
      worker, QuestionStage::kCheck);
  if (done + 1 < (answered + 1) * every) return {};
  pending = unanswered(db, collection, worker, QuestionStage::kCheck);
  if (pending.size() > 1) pending.resize(1);
  return pending;
}

void answer(store::Database& db, std::int64_t collection, std::int64_t worker,
            std::int64_t question, const std::string& choice) {
  const auto found = db.find<Question>(
      "SELECT id, stage, text, choices, accepted FROM question WHERE id = ? AND collection = ?",
      question, collection);
  if (!found) throw Refusal(Reason::kNotFound, "no such question in this collection");
  if (std::ranges::find(found->choices, choice) == found->choices.end()) {
    throw Refusal(Reason::kInvalidInput, "choice: not one of the question's");
  }
  const bool accepted = std::ranges::find(found->accepted, choice) != found->accepted.end();
  db.run(
      "INSERT INTO answer (question, worker, choice, accepted, at) VALUES (?, ?, ?, ?, ?) "
      "ON CONFLICT DO NOTHING",
      question, worker, choice, accepted, db.now());
}

bool is_screened_out(store::Database& db, std::int64_t worker) {
  return db.find_number(
             "SELECT 1 FROM answer JOIN question ON question.id = question WHERE worker = ? AND "
             "stage = ? AND answer.accepted = 0 LIMIT 1",
             worker, QuestionStage::kScreening) != 0;
}

std::vector<std::string> mturk_origins() {
  return {"https://www.mturk.com", "https://worker.mturk.com", "https://workersandbox.mturk.com"};
}

bool is_origin(std::string_view text) {
  if (text.size() > kLongestOrigin) return false;
  std::string_view host = text;
  if (host.starts_with("https://")) {
    host.remove_prefix(8);
  } else if (host.starts_with("http://127.0.0.1") || host.starts_with("http://localhost")) {
    host.remove_prefix(7);
  } else {
    return false;
  }
  return !host.empty() && host.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-.:") ==
                              std::string_view::npos;
}

Arrival read_arrival(const Platform& platform, const Parameters& parameters) {
  if (platform.kind == PlatformKind::kMturk) return by_mturk(platform, parameters);
  if (platform.kind == PlatformKind::kProlific) return by_prolific(parameters);
  return by_link(parameters);
}

}  // namespace enfilade::service::collecting
