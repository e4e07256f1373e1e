/// \file  Collections: sets of paths for workers to describe, or of instructions to walk.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "enfilade/r2r/annotations.h"
#include "enfilade/service/collecting/platforms.h"
#include "enfilade/service/site.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::collecting {

enum class Kind : std::uint8_t {
  kWrite,  ///< a path is shown, an instruction is written
  kWalk,   ///< an instruction is shown, a path is walked: the Human agent
};
constexpr std::array<std::string_view, 2> names_of(Kind /*enum*/) { return {"write", "walk"}; }

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

  auto columns() {
    return std::tie(id, name, title, kind, open, key, platform.kind, platform.origins,
                    platform.completion_code, consent, instructions, per_item, lease_seconds,
                    tasks_per_visit, created);
  }
};

/// The object of a task: a path (kWrite), or one of its instructions (kWalk).
struct Item {
  std::int64_t id = 0;
  std::string split;
  std::int64_t path_id = 0;
  std::size_t number = 0;  ///< of the instruction
  std::string scan;
  Radians heading;
  /// Viewpoints from start to goal. Of kWalk, only the first is ever sent to a worker.
  std::vector<std::string> path;
  std::optional<double> distance;
  std::string instruction;  ///< kWalk
  bool secret = false;  ///< the goal is of a phase with secret goals: it never leaves the server

  auto columns() {
    return std::tie(id, split, path_id, number, scan, heading.value, path, distance, instruction,
                    secret);
  }
};

struct NewCollection {
  Collection about;
  std::vector<Item> items;
};

/// Reads the body of POST /api/v1/collections (openapi.json), and checks all of it.
/// \throws InvalidInput with every fault and its JSON path
NewCollection read_new_collection(const Site& site, std::string_view body);

struct Progress {
  std::int64_t items = 0, leased = 0, submitted = 0, accepted = 0, rejected = 0, complete = 0,
               workers = 0;

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

/// A visit with the numbers that an organiser pays by.
struct VisitSummary {
  std::int64_t visit = 0, worker = 0;
  std::string external, assignment, group;  ///< the platform's ids
  std::int64_t created = 0, submitted = 0, accepted = 0, rejected = 0, bonuses = 0;
  bool finished = false;

  auto columns() {
    return std::tie(visit, worker, external, assignment, group, created, submitted, accepted,
                    rejected, bonuses, finished);
  }
};

/// \returns it with its id, key and time  \throws Refusal kConflict if the name is taken
Collection add_collection(store::Database& db, const NewCollection& added);
/// None if no collection has this name.
std::optional<Collection> find_collection(store::Database& db, std::string_view name);
/// \throws Refusal kNotFound
Collection get_collection(store::Database& db, std::string_view name);
Collection collection_of_visit(store::Database& db, std::int64_t visit);
std::vector<Collection> list_collections(store::Database& db);
void set_open(store::Database& db, std::int64_t collection, bool open);
Progress progress_of(store::Database& db, std::int64_t collection);
std::vector<SplitSize> splits_of(store::Database& db, std::int64_t collection);
std::vector<VisitSummary> visits_of(store::Database& db, const Collection& collection);

/// Of a split, by id.
std::vector<Item> items_of(store::Database& db, std::int64_t collection, std::string_view split);
/// The first item: what a preview shows.
Item first_item(store::Database& db, std::int64_t collection);

/// Path and query of the page for workers, with the key and what the platform fills in.
std::string link_of(const Collection& collection);

/// The columns of an Item, for a query of the table item.
inline constexpr const char* kItemColumns =
    "item.id, item.split, item.path_id, item.number, item.scan, item.heading, item.path, "
    "item.distance, item.instruction, item.secret";

}  // namespace enfilade::service::collecting
