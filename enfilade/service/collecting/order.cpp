#include "enfilade/service/collecting/order.h"

#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "enfilade/service/detail/secrets.h"

namespace enfilade::service::collecting {
namespace {

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

}  // namespace

void assign_blocks(std::int64_t seed, std::vector<Item>& items) {
  std::vector<std::pair<std::string, Item*>> ranked;
  for (Item& item : items) {
    if (item.practice) continue;
    ranked.emplace_back(detail::sha256(fmt::format("{} {} {}", seed, item.path_id, item.number)),
                        &item);
  }
  std::ranges::sort(ranked, {}, &std::pair<std::string, Item*>::first);
  for (std::size_t k = 0; k < ranked.size(); ++k) {
    ranked[k].second->block = static_cast<std::int64_t>(k / kBlockSize);
  }
}

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
