/// \file  How often a team and an address may submit to a phase. Rows of the table `attempt`: one
/// for each file that was checked, with the submission that it became; without one it was refused.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/service/phases.h"

namespace enfilade::service::store {
class Database;
}

namespace enfilade::service::evaluation {

/// Files with faults that a team may send to a phase in 24 hours. They give away nothing of goals,
/// so they are not submissions; but a check takes time and memory.
inline constexpr int kRefusedPerDay = 20;
/// Likewise by all teams of an address.
inline constexpr int kRefusedPerAddressDay = 100;

/// The sender of a file.
struct Sender {
  std::int64_t team = 0;
  std::string address;  ///< as stored: see stored_address()
};

/// The stored form of a client's address: a hash with a key of this database. So addresses of two
/// databases cannot be compared, nor read without the file. One for a whole /64 of IPv6.
std::string stored_address(store::Database& db, std::string_view address);

/// \throws Refusal kRateLimited naming the limit that another submission would exceed; kForbidden
/// if the phase has secret goals and all the teams that it takes
void check_limits(store::Database& db, const Phase& phase, const Sender& sender);
/// check_limits(), and counts the file as a refused one until accept_attempt(). Many files that
/// come at once are so counted before the first of them is checked. \returns the attempt's number
std::int64_t begin_attempt(store::Database& db, const Phase& phase, const Sender& sender);
void accept_attempt(store::Database& db, std::int64_t attempt, std::int64_t submission);

}  // namespace enfilade::service::evaluation
