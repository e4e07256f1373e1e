/// \file  CVDN: a navigator who searches for an object asks an oracle who has the shortest path.
/// Internal.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/homes/benchmarks/site.h"

namespace enfilade::homes::benchmarks {

/// A game: its instances in order, each with the turns so far. The goal is the room where the path
/// ends, the target an object in it. The oracle describes the next steps of a shortest path to the
/// room, at most 5. The navigator follows them, or stops early, and goes a little astray before the
/// first question. Roles, questions and answers are true at their viewpoint. The ids are left to
/// the caller; the group is the path's id. No instance if the start is in the room, or if it has no
/// object to search for.
std::vector<tasks::PathAnnotation> write_dialogue(const Site& site,
                                                  const tasks::PathAnnotation& path,
                                                  std::uint64_t seed);

/// The text of an instance, as the reader of CVDN's files makes it from the turns and the target.
std::string text_of(const std::vector<tasks::DialogueTurn>& turns, const std::string& target);

}  // namespace enfilade::homes::benchmarks
