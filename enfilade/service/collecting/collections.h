/// \file  Collections: sets of paths for workers to describe, or of instructions to follow.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "enfilade/service/site.h"
#include "enfilade/service/store/database.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::service::collecting {

enum class WorkKind : std::uint8_t {
  kWrite,     ///< a path is shown, an instruction is written (Room-to-Room)
  kWalk,      ///< an instruction is shown, the worker follows it: the Human agent
  kDescribe,  ///< a path to an object is shown, the worker writes how to find it (REVERIE)
  kFind,      ///< such a text is shown: the worker follows it, and points at the object
  kGuide,     ///< the worker moves along a path, and speaks or writes, with times (RxR)
  kDialogue,  ///< two workers: one moves and asks, one sees the path and answers (CVDN)
};
constexpr std::array<std::string_view, 6> names_of(WorkKind /*enum*/) {
  return {"write", "walk", "describe", "find", "guide", "dialogue"};
}

/// Whether a task's content is one text, which reviewers may correct.
constexpr bool is_written(WorkKind kind) {
  return kind == WorkKind::kWrite || kind == WorkKind::kDescribe;
}
/// Whether the worker follows a text to an unknown goal.
constexpr bool is_followed(WorkKind kind) {
  return kind == WorkKind::kWalk || kind == WorkKind::kFind;
}
/// Whether items have an object, or a region, as their goal.
constexpr bool has_target(WorkKind kind) {
  return kind == WorkKind::kDescribe || kind == WorkKind::kFind || kind == WorkKind::kDialogue;
}
/// Whether the item is a whole path, and not one of its instructions.
constexpr bool shows_path(WorkKind kind) { return is_written(kind) || kind == WorkKind::kGuide; }

/// Platforms that send workers: the server's own link, Amazon Mechanical Turk (an
/// ExternalQuestion), Prolific.
enum class PlatformKind : std::uint8_t { kSelf, kMturk, kProlific };
constexpr std::array<std::string_view, 3> names_of(PlatformKind /*enum*/) {
  return {"self", "mturk", "prolific"};
}

struct Platform {
  PlatformKind kind = PlatformKind::kSelf;
  /// Mechanical Turk: sites that may frame the pages and receive their form; see is_origin().
  std::vector<std::string> origins;
  std::string completion_code;  ///< Prolific: of the study
  std::string screen_out_code;  ///< Prolific: for workers whom the screening sends away; or empty
};

/// Those of Mechanical Turk and its sandbox.
std::vector<std::string> mturk_origins();
/// "https://www.mturk.com"; http for this machine only, where tests run. It has no character that
/// ends a directive of a Content-Security-Policy.
bool is_origin(std::string_view text);

/// The query of the page's address, decoded.
using Parameters = std::map<std::string, std::string, std::less<>>;

/// A worker who opens the link, as the platform describes the worker.
struct Arrival {
  bool preview = false;    ///< no worker has accepted the task yet; the rest is empty then
  std::string worker;      ///< the platform's id of the worker
  std::string assignment;  ///< the paid unit: assignmentId, SESSION_ID; "" if self-hosted
  std::string group;       ///< hitId, STUDY_ID
  std::string submit_to;   ///< Mechanical Turk: the origin to post to when done
};

/// Reads the platform's query. A self-hosted worker without a name gets a random one.
/// \throws Refusal kInvalidInput naming the parameter
Arrival read_arrival(const Platform& platform, const Parameters& parameters);

/// Whether workers may join, and whether lists show it.
enum class CollectionState : std::uint8_t {
  kOpen,
  kClosed,    ///< no new workers, no new tasks
  kArchived,  ///< closed, and left out of lists by default
};
constexpr std::array<std::string_view, 3> names_of(CollectionState /*enum*/) {
  return {"open", "closed", "archived"};
}

struct Collection {
  std::int64_t id = 0;
  std::string name, title;
  WorkKind kind = WorkKind::kWrite;
  bool open = true;
  std::string key;  ///< part of the link; needed to join
  Platform platform;
  std::string consent, instructions;  ///< Markdown
  int per_item = 3;                   ///< different workers an item
  std::int64_t lease_seconds = 1800;
  int tasks_per_visit = 0;  ///< 0: no limit
  std::int64_t created = 0;
  std::optional<std::int64_t> archived;  ///< when
  std::int64_t seed = 0;                 ///< of the order of tasks: assignments.h
  std::string pay;                       ///< shown to workers: "$1.20 a path"; may be empty
  double minutes = 0;                    ///< duration of a task, shown to workers; 0: not shown
  int check_every = 3;                   ///< an attention check comes before every such task
  /// When the consent text was last changed, or 0: earlier consent must be given again.
  std::int64_t consent_changed = 0;
  std::string language = "en-US";  ///< kGuide: one of RxR's

  CollectionState state() const {
    if (archived) return CollectionState::kArchived;
    return open ? CollectionState::kOpen : CollectionState::kClosed;
  }
  auto columns() {
    return std::tie(id, name, title, kind, open, key, platform.kind, platform.origins,
                    platform.completion_code, platform.screen_out_code, consent, instructions,
                    per_item, lease_seconds, tasks_per_visit, created, archived, seed, pay, minutes,
                    check_every, consent_changed, language);
  }
};

/// The object of a task. kWrite, kGuide: a path. kDescribe, kDialogue: a path with an object at its
/// end. kWalk, kFind: an instruction of one.
struct WorkItem {
  std::int64_t id = 0;
  std::string split;
  std::int64_t path_id = 0;
  /// Number of the instruction. kDescribe, kDialogue: the object's id, as a path may end at
  /// several.
  std::size_t number = 0;
  std::string scan;
  Radians heading;
  /// Viewpoints from start to goal. If the worker searches for the goal (is_followed(), and
  /// navigators of kDialogue), only the first is ever sent.
  std::vector<std::string> path;
  std::optional<double> distance;
  /// To be followed, or empty; of practice, where one writes, an example of what may be written.
  std::string instruction;
  bool secret = false;     ///< the goal is of a phase with secret goals: it never leaves the server
  bool practice = false;   ///< every worker's first tasks: never reviewed, never exported
  std::int64_t block = 0;  ///< assign_blocks()
  // If has_target().
  std::optional<std::int64_t> object = {};  ///< of REVERIE's boxes; no value for a region only
  std::string target = {};                  ///< its name for people: "plant"
  std::vector<std::string> region = {};  ///< viewpoints from which it is seen, or near it; sorted
  std::string outlines = {};             ///< outlines_json(); empty if no box is known
  std::optional<std::int64_t> of = {};  ///< kFind: the task whose text this is, if it is of another
                                        ///< collection

  auto columns() {
    return std::tie(id, split, path_id, number, scan, heading.value, path, distance, instruction,
                    secret, practice, block, object, target, region, outlines, of);
  }
};

/// When a question to workers is asked. Which answers are right never leaves the server.
enum class QuestionStage : std::uint8_t {
  kScreening,  ///< before anything else: a wrong answer means no task
  kCheck,      ///< between tasks: wrong answers are counted, and shown to reviewers
};
constexpr std::array<std::string_view, 2> names_of(QuestionStage /*enum*/) {
  return {"screening", "check"};
}

struct Question {
  std::int64_t id = 0;
  QuestionStage stage = QuestionStage::kScreening;
  std::string text;
  std::vector<std::string> choices;
  std::vector<std::string> accepted;  ///< the right ones of them

  auto columns() { return std::tie(id, stage, text, choices, accepted); }
};

/// By id: in the order in which they were written.
std::vector<Question> questions_of(store::Database& db, std::int64_t collection);

/// Questions for a worker before the next task: all of the screening, or the next attention check.
/// The first check comes before task number `every`, the second before 2 * every, ...
/// \param done tasks that the worker submitted in all visits, without practice
std::vector<Question> pending_questions(store::Database& db, std::int64_t collection,
                                        std::int64_t worker, std::int64_t done, int every);

/// Stores an answer; a second one to the same question changes nothing.
/// \throws Refusal kNotFound for a question of another collection, kInvalidInput for a choice that
/// it does not have
void answer(store::Database& db, std::int64_t collection, std::int64_t worker,
            std::int64_t question, const std::string& choice);
/// Whether an answer to the screening was wrong.
bool is_screened_out(store::Database& db, std::int64_t worker);

struct NewCollection {
  Collection about;
  std::vector<WorkItem> items;
  std::vector<Question> questions;
};

/// Reads the body of POST /api/v1/collections (openapi.json), and checks all of it. Items have
/// their blocks.
/// \param db has the collections whose texts are to be verified (kFind)
/// \throws InvalidInput with its faults (up to 1000) and their JSON paths
NewCollection read_new_collection(const Site& site, store::Database& db, std::string_view body);
/// Reads the body of PATCH /api/v1/collections/{collection}: the fields that are there.
/// \param now seconds since 1970
/// \returns `collection` with them
/// \throws InvalidInput as read_new_collection()
Collection read_changed_collection(const Collection& collection, std::string_view body,
                                   std::int64_t now);
/// The body of POST /api/v1/collections/{collection}/copy.
/// \returns `collection` with its new name and title, open, and with a seed of its own
/// \throws InvalidInput as read_new_collection()
Collection read_copied_collection(const Collection& collection, std::string_view body);

/// Without practice.
struct Progress {
  std::int64_t items = 0, leased = 0, submitted = 0, accepted = 0, rejected = 0, complete = 0,
               workers = 0;
  double minutes = 0;  ///< median time of a submitted task by the server's clock; 0: no task

  auto columns() {
    return std::tie(items, complete, leased, submitted, accepted, rejected, workers);
  }
};

struct SplitSize {
  std::string split;
  std::int64_t items = 0;
  bool secret = false;  ///< has goals that never leave the server

  auto columns() { return std::tie(split, items, secret); }
};

/// A visit with the numbers that an organiser pays by; practice is not among them.
struct VisitSummary {
  std::int64_t visit = 0, worker = 0;
  std::string external, assignment, group;  ///< the platform's ids
  std::int64_t created = 0, submitted = 0, accepted = 0, rejected = 0, bonuses = 0;
  bool finished = false;
  std::int64_t seconds = 0;  ///< from tasks given out to tasks submitted, by the server's clock
  std::int64_t checks = 0, checks_failed = 0;  ///< attention checks of the worker, in all visits
  bool screened_out = false;

  auto columns() {
    return std::tie(visit, worker, external, assignment, group, created, submitted, accepted,
                    rejected, bonuses, finished, seconds, checks, checks_failed, screened_out);
  }
};

/// \returns it with its id, key and time  \throws Refusal kConflict if the name is taken
Collection add_collection(store::Database& db, const NewCollection& added);
/// None if no collection has this name.
std::optional<Collection> find_collection(store::Database& db, std::string_view name);
/// \throws Refusal kNotFound
Collection get_collection(store::Database& db, std::string_view name);
Collection collection_of_visit(store::Database& db, std::int64_t visit);
/// Those whose name or title has the text, in any case of a-z. \param archived these, or the others
std::vector<Collection> list_collections(store::Database& db, std::string_view text, bool archived);
/// Stores the changeable fields: state, texts, rules.
void change_collection(store::Database& db, const Collection& changed);
/// Copies its items and questions, without work. \param copy with a name of its own
/// \returns it with its id, key and time
/// \throws Refusal kConflict if the name is taken
Collection copy_collection(store::Database& db, const Collection& from, Collection copy);
Progress progress_of(store::Database& db, std::int64_t collection);
std::vector<SplitSize> splits_of(store::Database& db, std::int64_t collection);
std::vector<VisitSummary> visits_of(store::Database& db, const Collection& collection);

/// The items of a split, by id, without practice.
std::vector<WorkItem> items_of(store::Database& db, std::int64_t collection,
                               std::string_view split);
/// The first item: for a preview.
WorkItem first_item(store::Database& db, std::int64_t collection);

/// The columns of a WorkItem, for a query of the table item.
inline constexpr const char* kItemColumns =
    "item.id, item.split, item.path_id, item.number, item.scan, item.heading, item.path, "
    "item.distance, item.instruction, item.secret, item.practice, item.block, item.object, "
    "item.target, item.region, item.outlines, item.of";

}  // namespace enfilade::service::collecting
