/// \file  Habits of the three speakers: how often they mention or omit a fact. Internal.
#pragma once
#include <cstddef>

#include "enfilade/homes/instructions/phrases.h"
#include "enfilade/homes/instructions/speaker.h"

namespace enfilade::homes::instructions {

/// How a speaker chooses: probabilities, [0, 1], unless stated otherwise.
struct Habits {
  double brevity = 0;          ///< a clause gets the fewest words
  double bend = 0;             ///< a slight bend that cannot mislead is left out
  double start = 0;            ///< the start is described by an object nearby
  double towards = 0;          ///< an object straight ahead is named
  double things = 0;           ///< a passed object is named
  std::size_t all_things = 0;  ///< most such objects in an instruction
  double distance = 0;         ///< how far, or along what, is said
  double merge = 0;            ///< two rooms in a row share a clause
  double skip = 0;             ///< entering a hall is not mentioned
  double openings = 0;         ///< a sentence begins with "then" and the like
  double goal = 0;             ///< the place to stop is given by an object
  double elide = 0;            ///< two turns in a row share a verb
  std::size_t clauses = 1;     ///< most clauses in a sentence
  Links links = Links::kAny;
  /// Range of the wanted length. A longer instruction is written again with less; a path of many
  /// turns and rooms may take more words all the same.
  std::size_t least_words = 0, most_words = 0;
};

Habits habits_of(Speaker speaker);
/// The same habits for a shorter instruction. \param leaner 0: unchanged; 1: only necessary facts
Habits leaner_habits(Habits habits, double leaner);

}  // namespace enfilade::homes::instructions
