/// \file  Order in which workers get the items of a collection.
///
/// Each worker has an order of their own, so that an item's position in it (practice, fatigue) is
/// not the same for all. It follows from the collection's seed, the worker's number and the item.
/// Exports have these, so anyone can compute it again:
///
///     block of an item: its rank by sha256("SEED PATH_ID NUMBER") / 20, rounded down
///     worker's order: by block, then by sha256("SEED WORKER PATH_ID NUMBER")
///
/// Digests are compared as hexadecimal texts. Blocks keep a collection that stops early from having
/// many items half done. Items of paths that the worker has not had come before all others.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/service/collecting/collections.h"

namespace enfilade::service::collecting {

inline constexpr std::size_t kBlockSize = 20;

/// Gives the items their blocks; practice has none.
void assign_blocks(std::int64_t seed, std::vector<Item>& items);

/// The worker's next item that has a place; 0 if there is none. Practice comes first, in the order
/// in which it was written.
std::int64_t next_item(store::Database& db, const Collection& collection, std::int64_t worker);

/// Items with a place that are new to the worker, practice not counted. \returns at most `most`
std::int64_t count_open_items(store::Database& db, const Collection& collection,
                              std::int64_t worker, std::int64_t most);

/// Practice items that are new to the worker.
std::int64_t count_practice(store::Database& db, const Collection& collection, std::int64_t worker);

}  // namespace enfilade::service::collecting
