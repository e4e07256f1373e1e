/// \file  What three kinds of people say and leave out when they describe a path. Internal.
#pragma once
#include <cstddef>

#include "enfilade/homes/speaking/phrases.h"
#include "enfilade/homes/speaking/speaker.h"

namespace enfilade::homes::speaking {

/// Shares of the times that there is a choice, [0, 1], if nothing else is said.
struct Habits {
  double brevity = 0;          ///< a clause gets the fewest words
  double bend = 0;             ///< a slight bend that misleads nobody is left out
  double start = 0;            ///< they begin with what is around them
  double towards = 0;          ///< they name what they head for
  double things = 0;           ///< they name a thing that is passed
  std::size_t all_things = 0;  ///< such things in an instruction, at most
  double distance = 0;         ///< they say how far, or along what
  double merge = 0;            ///< two rooms make one clause
  double skip = 0;             ///< they say nothing of a hall that they come into
  double openings = 0;         ///< a sentence begins with "then" and the like
  double goal = 0;             ///< they stop by a thing
  double elide = 0;            ///< two turns in a row get one verb
  std::size_t clauses = 1;     ///< in a sentence, at most
  Links links = Links::kAny;
  /// What they care to say is between; who has said more says it again with less. A path of many
  /// turns and rooms takes more all the same.
  std::size_t least_words = 0, most_words = 0;
};

Habits habits_of(Speaker speaker);
/// The same people in a hurry: `leaner` is 0 for as they are, 1 for what cannot be left out.
Habits leaner_habits(Habits habits, double leaner);

}  // namespace enfilade::homes::speaking
