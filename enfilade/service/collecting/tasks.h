/// \file  Tasks: which worker has which item, what came of it, and what reviewers say to that.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/service/collecting/visits.h"

namespace enfilade::service::collecting {

/// An item with a worker.
struct Task {
  std::int64_t id = 0;
  Item item;
  std::int64_t collection = 0;
  Kind kind = Kind::kWrite;
  int per_item = 0;
  std::int64_t lease_seconds = 0;
  std::int64_t worker = 0, visit = 0;
  /// "leased", "returned" (given back), "lapsed" (the lease ended, somebody else came),
  /// "submitted", "accepted", "rejected"
  std::string state;
  std::int64_t expires = 0;  ///< of the lease
  std::string draft;         ///< the page's JSON; empty if there is none
  std::string content;       ///< the instruction, or the list of a walk's steps as JSON
  std::string digest;        ///< of what was handed in
  double seconds = 0;
  std::vector<std::string> flags;
  std::string camera;           ///< JSON
  std::optional<double> error;  ///< of a walk: metres from its end to the goal, along the graph
  std::int64_t submitted = 0;
  std::string reason;  ///< of a rejection

  bool handed_in() const { return submitted != 0; }
  bool bonus() const;  ///< a walk that ended less than 3 m from its goal
};

/// Why a worker gets no task.
enum class NoTask : std::uint8_t {
  kFinished,   ///< the visit has had its number
  kNoneLeft,   ///< this worker has had all that is open
  kAllLeased,  ///< what is open is with others just now
  kClosed,     ///< the collection is
};
std::string_view to_string(NoTask why);  ///< "finished", "none-left", "all-leased", "closed"

struct Lease {
  std::optional<Task> task;
  NoTask why = NoTask::kFinished;  ///< if there is none
};

/// What a worker hands in, checked.
struct HandedIn {
  std::string content;
  double seconds = 0;
  std::vector<std::string> flags;
  std::string camera;
  std::optional<double> error;
};

// For workers. A lease that has run out is still its worker's as long as nobody else has the place.
// All \throw Error with SQLite's words if the database fails. `now`: seconds since 1970.

/// The task that the visit holds, its lease begun anew; else the worker's that lapsed, if its place
/// is free; else the next: items that others have begun come first, so that few stay half done, and
/// no worker gets an item twice. \throws HttpError 403 without consent
Lease lease_task(store::Database& database, const Collection& collection, const Visit& visit,
                 std::int64_t now);
/// What the visit holds, whether or not its lease has run out.
std::optional<Task> held_task(store::Database& database, const Visit& visit);
/// \throws HttpError 404 if there is no such task, or it is another visit's
Task own_task(store::Database& database, const Visit& visit, std::int64_t task);

// These \throw as own_task(); HttpError 409 "submitted" or "returned" for what is no longer in
// hand, "lease-lost" if another worker has the place.

/// Keeps the draft and begins the lease anew. \returns when it ends
std::int64_t keep_draft(store::Database& database, const Visit& visit, std::int64_t task,
                        const std::string& draft, std::int64_t now);
void give_back(store::Database& database, const Visit& visit, std::int64_t task, std::int64_t now);
/// On the disk when it returns; the same once more changes nothing.
void hand_in(store::Database& database, const Visit& visit, std::int64_t task, const HandedIn& work,
             std::int64_t now);

// For reviewers.

/// What a reviewer did.
struct Event {
  std::int64_t at = 0;
  std::string who, what;  ///< what: "edited", "accepted", "rejected"
  std::string before;     ///< "edited": the content until then
  std::string reason;
};

enum class Verdict : std::uint8_t { kAccepted, kRejected };

struct WorkPage {
  std::int64_t matching = 0;  ///< of all, not only of these
  std::vector<Task> tasks;
};

/// What was handed in, by rising number. \param state "submitted", "accepted", "rejected", "all"
WorkPage list_work(store::Database& database, std::int64_t collection, const std::string& state,
                   std::int64_t after, std::int64_t limit);
/// Of a split, by item and number: accepted, or submitted ones too.
std::vector<Task> collected(store::Database& database, std::int64_t collection,
                            const std::string& split, bool submitted_too);
/// Its items, by number.
std::vector<Item> items_of(store::Database& database, std::int64_t collection,
                           const std::string& split);
/// \throws HttpError 404 unless it was handed in
Task find_work(store::Database& database, std::int64_t task);
std::vector<Event> events_of(store::Database& database, std::int64_t task);
/// A rejected one leaves its place to another worker. \throws HttpError 404; 409 if it was rejected
/// and its place is taken
void judge(store::Database& database, std::int64_t task, Verdict verdict, const std::string& reason,
           const std::string& who, std::int64_t now);
/// \pre it is an instruction  \throws HttpError 404
void edit(store::Database& database, std::int64_t task, const std::string& instruction,
          const std::string& who, std::int64_t now);
/// Handed in and not judged, of all collections.
std::int64_t waiting_for_review(store::Database& database);

}  // namespace enfilade::service::collecting
