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
  bool consented = false;
  std::string assignment, submit_to;
  std::int64_t done = 0;  ///< tasks submitted

  auto columns() { return std::tie(id, worker, consented, assignment, submit_to, done); }
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

enum class TaskState : std::uint8_t {
  kLeased,    ///< with its worker
  kReturned,  ///< the worker gave it back
  kLapsed,    ///< its lease ended and others have the place
  kSubmitted,
  kAccepted,
  kRejected,
};
constexpr std::array<std::string_view, 6> names_of(TaskState /*enum*/) {
  return {"leased", "returned", "lapsed", "submitted", "accepted", "rejected"};
}

/// An item with a worker.
struct Task {
  std::int64_t id = 0;
  Item item;
  Kind kind = Kind::kWrite;
  int per_item = 0;
  std::int64_t lease_seconds = 0;
  std::int64_t worker = 0;
  TaskState state = TaskState::kLeased;
  std::int64_t expires = 0;  ///< of the lease
  std::string draft;         ///< the page's JSON; empty if there is none
  std::string content;       ///< the instruction, or the list of a walk's steps as JSON
  std::string digest;        ///< of what was submitted
  double seconds = 0;
  std::vector<std::string> flags;
  std::string camera;           ///< JSON
  std::optional<double> error;  ///< of a walk: metres from its end to the goal, along the graph
  std::int64_t submitted = 0;
  std::string reason;  ///< of a rejection

  bool is_submitted() const { return submitted != 0; }  ///< reviewed or not
  bool bonus() const;  ///< a walk that ended less than 3 m from its goal

  auto columns() {
    return std::tie(item, kind, per_item, lease_seconds, id, worker, state, expires, draft, content,
                    digest, seconds, flags, camera, error, submitted, reason);
  }
};

/// Why a worker gets no task.
enum class NoTask : std::uint8_t {
  kFinished,   ///< the visit has had its number
  kNoneLeft,   ///< this worker has had every open item
  kAllLeased,  ///< the open items are with other workers now
  kClosed,     ///< the collection is closed
};
constexpr std::array<std::string_view, 4> names_of(NoTask /*enum*/) {
  return {"finished", "none-left", "all-leased", "closed"};
}

struct Lease {
  std::optional<Task> task;
  NoTask why = NoTask::kFinished;  ///< if there is none
};

/// What a worker submits, checked.
struct SubmittedWork {
  std::string content;
  double seconds = 0;
  std::vector<std::string> flags;
  std::string camera;
  std::optional<double> error;
};

// For workers. A lease that has ended still belongs to its worker as long as nobody else has the
// place.

/// The task that the visit holds, its lease renewed; else one of the worker's that lapsed, if its
/// place is free; else the next: items that others have begun come first, so that few stay half
/// done, and no worker gets an item twice. \throws Refusal kConsentRequired
Lease lease_task(store::Database& db, const Collection& collection, const Visit& visit);
/// The task that the visit holds, whether or not its lease has ended.
std::optional<Task> held_task(store::Database& db, const Visit& visit);
/// \throws Refusal kNotFound if there is no such task, or it is another visit's
Task own_task(store::Database& db, const Visit& visit, std::int64_t task);

// These \throw as own_task(); Refusal kAlreadySubmitted or kAlreadyReturned for a task that
// the worker no longer has, kLeaseExpired if another worker has the place.

/// Stores the draft and renews the lease. \returns when it ends
std::int64_t save_draft(store::Database& db, const Visit& visit, std::int64_t task,
                        const std::string& draft);
void return_task(store::Database& db, const Visit& visit, std::int64_t task);
/// On the disk when it returns. Submitting the same work again changes nothing.
void submit(store::Database& db, const Visit& visit, std::int64_t task, const SubmittedWork& work);

// For reviewers. Those with a task's number \throw Refusal kNotFound unless it was submitted.

enum class EventKind : std::uint8_t { kEdited, kAccepted, kRejected };
constexpr std::array<std::string_view, 3> names_of(EventKind /*enum*/) {
  return {"edited", "accepted", "rejected"};
}

/// What a reviewer did.
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
  std::vector<Task> tasks;
};

/// Submitted work, by rising number. \param state none: all
WorkPage list_work(store::Database& db, std::int64_t collection, std::optional<TaskState> state,
                   std::int64_t after, std::int64_t limit);
/// Which work is exported.
struct ExportedSplit {
  Collection collection;
  std::string split;
  bool with_waiting = false;  ///< also work that waits for review, not only accepted work
};
/// Sorted by item and task.
std::vector<Task> work_of(store::Database& db, const ExportedSplit& exported);
Task find_work(store::Database& db, std::int64_t task);
std::vector<Event> events_of(store::Database& db, std::int64_t task);
/// A rejected task leaves its place to another worker. \pre verdict is kAccepted or kRejected
/// \throws Refusal kConflict if it was rejected before and its place is taken
void review(store::Database& db, std::int64_t task, TaskState verdict, const std::string& reason,
            const std::string& who);
/// Changes an instruction. \throws Refusal kConflict if the task is a walk
void edit(store::Database& db, std::int64_t task, const std::string& instruction,
          const std::string& who);
/// Tasks that wait for review, of all collections.
std::int64_t waiting_for_review(store::Database& db);

}  // namespace enfilade::service::collecting
