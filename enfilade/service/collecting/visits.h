/// \file  Workers and their visits to a collection.
#pragma once
#include <cstdint>
#include <string>

#include "enfilade/service/collecting/collections.h"

namespace enfilade::service::collecting {

/// A worker at work: for one assignment of a platform, or by a link of the server's own.
struct Visit {
  std::int64_t id = 0, worker = 0, collection = 0;
  bool consented = false;
  std::string worker_name;  ///< the platform's id
  std::string assignment, submit_to;
  std::int64_t done = 0;  ///< tasks submitted

  auto columns() {
    return std::tie(id, worker, collection, consented, worker_name, assignment, submit_to, done);
  }
};

/// Whether the visit has submitted as many tasks as the collection gives one; never if it gives any
/// number.
bool is_finished(const Collection& collection, const Visit& visit);

/// The same worker with the same assignment is the same visit, also after a restart.
/// \pre not arrival.preview  \returns the visit's id
/// \throws Refusal 403 (collection-closed) for a new visit of a closed collection; 409 if
/// another worker has the assignment
std::int64_t join(store::Database& db, const Collection& collection, const Arrival& arrival);
/// \pre there is a visit of this id
Visit get_visit(store::Database& db, std::int64_t visit);
/// Stores that the visit's worker agreed to the consent text.
void give_consent(store::Database& db, const Visit& visit);

}  // namespace enfilade::service::collecting
