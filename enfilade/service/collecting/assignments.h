/// \file  Visits of workers to a collection, and their tasks: which worker has which item, what the
/// worker submitted, and what reviewers decided.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/service/collecting/collections.h"

namespace enfilade::service::collecting {

/// A worker at work: for one assignment of a platform, or by a link of the server's own.
struct Visit {
  std::int64_t id = 0, worker = 0;
  bool consented = false;  ///< to the consent text as it is now
  std::string assignment, submit_to;
  std::int64_t done = 0;            ///< tasks submitted; here and below without practice
  std::int64_t done_by_worker = 0;  ///< likewise, in all visits of the worker
  std::int64_t bonuses = 0;         ///< for trajectories to goals that are not secret

  auto columns() {
    return std::tie(id, worker, consented, assignment, submit_to, done, done_by_worker, bonuses);
  }
};

/// Whether the visit has submitted as many tasks as the collection gives one; never if it gives any
/// number.
bool is_finished(const Collection& collection, const Visit& visit);

/// The same worker with the same assignment is the same visit, also after a restart.
/// \pre not arrival.preview  \returns the visit's id
/// \throws Refusal kCollectionClosed for a new visit of a closed collection; kConflict if
/// another worker has the assignment
std::int64_t join(store::Database& db, const Collection& collection, const Arrival& arrival);
/// \pre there is a visit of this id
Visit get_visit(store::Database& db, std::int64_t visit);
/// Stores that the visit's worker agreed to the consent text.
void give_consent(store::Database& db, const Visit& visit);

enum class AssignmentState : std::uint8_t {
  kLeased,    ///< with its worker
  kReturned,  ///< the worker gave it back
  kLapsed,    ///< its lease ended and others have the place
  kSubmitted,
  kAccepted,
  kRejected,
};
constexpr std::array<std::string_view, 6> names_of(AssignmentState /*enum*/) {
  return {"leased", "returned", "lapsed", "submitted", "accepted", "rejected"};
}

/// An item with a worker.
struct Assignment {
  std::int64_t id = 0;
  WorkItem item;
  WorkKind kind = WorkKind::kWrite;
  int per_item = 0;
  std::int64_t lease_seconds = 0;
  std::int64_t worker = 0;
  AssignmentState state = AssignmentState::kLeased;
  std::int64_t expires = 0;  ///< of the lease
  std::string draft;         ///< the page's JSON; may be empty.
  /// The instruction (is_written()), or JSON. kWalk: the list of steps. kFind: {"steps", "point",
  /// "object"}. kGuide: {"instruction", "words", "steps", "spoken"}. kDialogue: as in
  /// kinds/dialogues.h.
  std::string content;
  std::string digest;  ///< of the submitted work
  double seconds = 0;  ///< as the page measured it
  std::vector<std::string> flags;
  std::string camera;  ///< JSON
  /// Metres. kWalk, kDialogue: from the end to the goal, along the graph. kFind: 0 if right, else
  /// to where the object is seen, 3 at least.
  std::optional<double> error;
  std::int64_t leased = 0;  ///< at first; 0 if it was not kept
  std::int64_t submitted = 0;
  std::string reason;  ///< of a rejection
  std::string role;    ///< in a dialogue: "navigator" or "oracle"; else empty

  /// From the first lease to the submission, by the server's clock, breaks included; none if it is
  /// not known.
  std::optional<std::int64_t> server_seconds() const;
  bool is_submitted() const { return submitted != 0; }  ///< reviewed or not
  bool bonus() const;  ///< a trajectory that ended less than 3 m from its goal

  auto columns() {
    return std::tie(item, kind, per_item, lease_seconds, id, worker, state, expires, draft, content,
                    digest, seconds, flags, camera, error, leased, submitted, reason, role);
  }
};

/// Why a worker gets no task.
enum class NoTask : std::uint8_t {
  kFinished,     ///< the visit has had its number
  kNoneLeft,     ///< this worker has had every open item
  kAllLeased,    ///< the open items are with other workers now
  kClosed,       ///< the collection is closed
  kQuestions,    ///< pending_questions_of() come first
  kScreenedOut,  ///< an answer to the screening was wrong
};
constexpr std::array<std::string_view, 6> names_of(NoTask /*enum*/) {
  return {"finished", "none-left", "all-leased", "closed", "questions", "screened-out"};
}

struct Lease {
  std::optional<Assignment> task;
  NoTask why = NoTask::kFinished;  ///< if there is no task
};

/// A worker's submission, checked.
struct SubmittedWork {
  std::string content;
  double seconds = 0;
  std::vector<std::string> flags;
  std::string camera;
  std::optional<double> error;
};

// Order in which workers get the items of a collection.
//
// Each worker has an order of their own, so that an item's position in it (practice, fatigue) is
// not the same for all. It follows from the collection's seed, the worker's number and the item.
// Exports have these, so anyone can compute it again:
//
//     block of an item: its rank by sha256("SEED PATH_ID NUMBER") / 20, rounded down
//     worker's order: by block, then by sha256("SEED WORKER PATH_ID NUMBER")
//
// Digests are compared as hexadecimal texts. Blocks keep a collection that stops early from having
// many items half done. Items of paths that the worker has not had come before all others.
// Practice comes first, in the order in which it was written; it has no blocks.

/// Gives the items their blocks; practice has none. \param seed  the collection's
void assign_blocks(std::int64_t seed, std::vector<WorkItem>& items);

/// Items with a place that are new to the worker, practice not counted. \returns at most `most`
std::int64_t count_open_items(store::Database& db, const Collection& collection,
                              std::int64_t worker, std::int64_t most);

/// Practice items that are new to the worker.
std::int64_t count_practice(store::Database& db, const Collection& collection, std::int64_t worker);

// For workers. A lease that has ended still belongs to its worker until another takes the place.

/// The task that the visit holds, with its lease renewed. Else one of the worker's that lapsed, if
/// its place is free; else the next in that order. No worker gets an item twice.
/// \throws Refusal kConsentRequired
Lease lease_task(store::Database& db, const Collection& collection, const Visit& visit);
/// Questions before the next task.
std::vector<Question> pending_questions_of(store::Database& db, const Collection& collection,
                                           const Visit& visit);
/// Whether the worker has had every item of the collection, so that feedback on one of them gives
/// away nothing about another.
/// \pre practice aside
bool has_had_all(store::Database& db, const Collection& collection, const Visit& visit);
/// Tasks of the worker that reviewers rejected, by number.
std::vector<Assignment> rejected_of(store::Database& db, const Visit& visit);
/// The task that the visit holds, whether or not its lease has ended.
std::optional<Assignment> held_task(store::Database& db, const Visit& visit);
/// \throws Refusal kNotFound if there is no such task, or it is another visit's
Assignment own_task(store::Database& db, const Visit& visit, std::int64_t task);

// These \throw as own_task(); Refusal kAlreadySubmitted or kAlreadyReturned for a task that
// the worker no longer has, kLeaseExpired if another worker has the place.

/// Stores the draft and renews the lease. \returns when it ends
std::int64_t save_draft(store::Database& db, const Visit& visit, std::int64_t task,
                        const std::string& draft);
void return_task(store::Database& db, const Visit& visit, std::int64_t task);
/// Renews the lease alone.
void renew_lease(store::Database& db, const Visit& visit, std::int64_t task);
/// Marks whether all places of the task's item are taken for good. \pre within a transaction
void update_item(store::Database& db, const Assignment& task);
/// On the disk when it returns. Submitting the same work again changes nothing.
void submit(store::Database& db, const Visit& visit, std::int64_t task, const SubmittedWork& work);

// For reviewers. Those with a task's number \throw Refusal kNotFound unless it was submitted.

enum class EventKind : std::uint8_t { kEdited, kAccepted, kRejected };
constexpr std::array<std::string_view, 3> names_of(EventKind /*enum*/) {
  return {"edited", "accepted", "rejected"};
}

/// An action of a reviewer.
struct Event {
  std::int64_t at = 0;
  std::string who;
  EventKind what = EventKind::kEdited;
  std::string before;  ///< kEdited: the content until then
  std::string reason;

  auto columns() { return std::tie(at, who, what, before, reason); }
};

struct WorkPage {
  std::int64_t matching = 0;  ///< of all, not only of these
  std::vector<Assignment> tasks;
};

/// Filter of submitted work; fields without a value match all.
struct WorkFilter {
  std::optional<AssignmentState> state;
  std::optional<std::int64_t> worker, path_id;
  /// Is in the text of the work, or in its object's name, in any case of a-z. Texts are what was
  /// written or said, or the instruction that was followed. Empty: matches all.
  std::string text = {};
};
/// Submitted work without practice, by rising number.
WorkPage list_work(store::Database& db, std::int64_t collection, const WorkFilter& filter,
                   std::int64_t after, std::int64_t limit);
/// The submitted work of a worker or of a path, in numbers.
struct WorkSummary {
  std::int64_t id = 0;                                     ///< of the worker; path_id
  std::int64_t submitted = 0, accepted = 0, rejected = 0;  ///< by their present state
  std::int64_t flagged = 0;                                ///< with flags
  double mean_seconds = 0;                                 ///< by the server's clock
  std::int64_t checks = 0, checks_failed = 0;              ///< of a worker: attention checks

  auto columns() {
    return std::tie(id, submitted, accepted, rejected, flagged, mean_seconds, checks,
                    checks_failed);
  }
};
enum class SummaryBy : std::uint8_t { kWorker, kPath };
/// By rising id, at most `limit` after that id; without practice.
std::vector<WorkSummary> summarise_work(store::Database& db, std::int64_t collection, SummaryBy by,
                                        std::int64_t after, std::int64_t limit);
/// Which work is exported.
struct ExportedSplit {
  Collection collection;
  std::string split;
  bool with_waiting = false;  ///< also work that waits for review, not only accepted work
};
/// Sorted by item and task; without practice.
std::vector<Assignment> work_of(store::Database& db, const ExportedSplit& exported);
/// All submitted tasks of the split, practice included, by number.
std::vector<Assignment> submitted_of(store::Database& db, const ExportedSplit& exported);
Assignment find_work(store::Database& db, std::int64_t task);
/// Number of workers who followed a text to find its object, and of those who found it.
struct Verified {
  std::int64_t walked = 0, found = 0;

  auto columns() { return std::tie(walked, found); }
};
/// \param task of kDescribe
Verified verified_of(store::Database& db, std::int64_t task);
std::vector<Event> events_of(store::Database& db, std::int64_t task);
/// Decision of a reviewer.
struct Verdict {
  AssignmentState state = AssignmentState::kAccepted;  ///< or kRejected
  std::string reason;                                  ///< of a rejection
  std::string instruction;                             ///< as corrected; empty: as it is
};
/// A rejected task leaves its place to another worker. The correction and the verdict are stored
/// together or not at all.
/// \throws Refusal kConflict if it was rejected before and its place is taken; as edit()
void review(store::Database& db, std::int64_t task, const Verdict& verdict, const std::string& who);
/// As review(), of several tasks of a collection: all verdicts are stored, or none if one of them
/// is refused.
/// \pre verdict.instruction is empty
/// \throws Refusal kNotFound naming a task that is no submitted one of the collection, or is
/// practice; as review()
void review_all(store::Database& db, std::int64_t collection,
                const std::vector<std::int64_t>& tasks, const Verdict& verdict,
                const std::string& who);
/// Changes an instruction. \throws Refusal kConflict if the task's content is no text alone
void edit(store::Database& db, std::int64_t task, const std::string& instruction,
          const std::string& who);
/// Tasks that wait for review, of all collections.
std::int64_t waiting_for_review(store::Database& db);

}  // namespace enfilade::service::collecting
