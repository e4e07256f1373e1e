/// \file  Workers, and their coming and going.
#pragma once
#include <cstdint>
#include <string>

#include "enfilade/service/collecting/collections.h"

namespace enfilade::service::collecting {

/// A worker who came: for one assignment of a platform, or by a link of one's own.
struct Visit {
  std::int64_t id = 0, worker = 0, collection = 0;
  bool consented = false;
  std::string worker_name;  ///< the platform's id
  std::string assignment, submit_to;
  std::int64_t done = 0;  ///< tasks handed in
};

/// Whether the visit has had as many tasks as the collection gives one; never if it sets no number.
bool has_had_all(const Collection& collection, const Visit& visit);

// All that follow \throw Error with SQLite's words if the database fails. `now`: seconds since
// 1970.

/// The same worker with the same assignment is the same visit, also after a restart.
/// \pre not arrival.preview  \returns the visit's id
/// \throws HttpError 403 for a new one where the collection is closed; 409 if another worker has
/// the assignment
std::int64_t join(store::Database& database, const Collection& collection, const Arrival& arrival,
                  std::int64_t now);
/// \pre there is a visit of this id
Visit visit_of(store::Database& database, std::int64_t visit);
void consent(store::Database& database, const Visit& visit, std::int64_t now);

}  // namespace enfilade::service::collecting
