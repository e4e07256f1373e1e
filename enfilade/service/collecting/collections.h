/// \file  Collections: sets of paths for workers to describe, or of instructions to follow.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "enfilade/service/collecting/kind.h"
#include "enfilade/service/collecting/platforms.h"
#include "enfilade/service/collecting/questions.h"
#include "enfilade/service/site.h"
#include "enfilade/service/store/database.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::service::collecting {

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
  Kind kind = Kind::kWrite;
  bool open = true;
  std::string key;  ///< part of the link; needed to join
  Platform platform;
  std::string consent, instructions;  ///< Markdown
  int per_item = 3;                   ///< different workers an item
  std::int64_t lease_seconds = 1800;
  int tasks_per_visit = 0;  ///< 0: no limit
  std::int64_t created = 0;
  std::optional<std::int64_t> archived;  ///< when
  std::int64_t seed = 0;                 ///< of the order of tasks: order.h
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
struct Item {
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
  std::int64_t block = 0;  ///< order.h
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

struct NewCollection {
  Collection about;
  std::vector<Item> items;
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
std::vector<Item> items_of(store::Database& db, std::int64_t collection, std::string_view split);
/// The first item: for a preview.
Item first_item(store::Database& db, std::int64_t collection);

/// Path and query of the page for workers, with the key and the platform's placeholders.
std::string link_of(const Collection& collection);

/// The columns of an Item, for a query of the table item.
inline constexpr const char* kItemColumns =
    "item.id, item.split, item.path_id, item.number, item.scan, item.heading, item.path, "
    "item.distance, item.instruction, item.secret, item.practice, item.block, item.object, "
    "item.target, item.region, item.outlines, item.of";

}  // namespace enfilade::service::collecting
