/// \file  Habits of the speakers, and clauses for the facts of a path. Internal.
#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/homes/instructions/naming.h"
#include "enfilade/homes/instructions/path_story.h"
#include "enfilade/homes/instructions/phrases.h"

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
  ClauseLinks links = ClauseLinks::kAny;
  /// Range of the wanted length. A longer instruction is written again with less; a path of many
  /// turns and rooms may take more words all the same.
  std::size_t least_words = 0, most_words = 0;
};

Habits habits_of(SpeakerKind speaker);
/// The same habits for a shorter instruction. \param leaner 0: unchanged; 1: only necessary facts
Habits leaner_habits(Habits habits, double leaner);

/// Draws clauses for one speaker, each in one of many variants: imperatives without capital letter
/// and full stop.
class Wording {
 public:
  /// \param brevity  probability that a clause gets the fewest words, [0, 1]
  Wording(const SpokenHome& home, SpeakerKind speaker, double brevity, std::uint64_t seed)
      : home_(home), naming_(home), speaker_(speaker), brevity_(brevity), rng_(seed) {}

  /// Sets the room where the path ends, which is always named.
  void set_goal_room(std::size_t room) { goal_room_ = room; }
  /// Records a room that the path has entered: another of its name is then "the other bedroom".
  void been_in(std::size_t room) { been_.push_back(room); }

  Rng& rng() noexcept { return rng_; }
  const Naming& naming() const noexcept { return naming_; }
  bool chance(double share) { return rng_.uniform() < share; }
  std::string say(std::string_view pattern, const Slots& slots = {}) {
    return expand(pattern, slots, rng_);
  }

  std::string turn(double degrees);
  std::string straight();
  /// "walk about four metres"
  std::string walk(double metres);
  /// Along a hall, with or without the turn before it.
  std::string along(const PathStretch& stretch, bool with_turn);
  std::string stairs(const PathStretch& stretch);
  /// Into another room. \param straight  the opening lies straight ahead
  std::string cross(const Happening& crossing, bool straight);
  /// The turn of a stretch and its first crossing, right after it.
  std::string turn_and_cross(const PathStretch& stretch, const Happening& crossing);
  /// Two crossings in one clause.
  std::string through(const Happening& first, const Happening& second, bool straight);
  std::string into(const Happening& crossing);
  std::string pass(const std::string& thing, bool on_right);
  std::string between(const std::string& a, const std::string& b);
  std::string over(const std::string& thing);
  std::string towards(const std::string& thing);
  /// An introduction such as "with the bed behind you"; no value if the object is not clearly at
  /// one of the four sides.
  std::optional<std::string> at_start(const std::string& thing, double bearing);
  std::string stop(const std::string& where);
  // Places to stop, without the verb: "next to the sink".
  std::string beside(const std::string& thing, const Neighbour& n);
  std::string in_doorway(std::size_t opening);
  std::string by_door(std::size_t opening, std::size_t room);
  std::string room(std::size_t room);
  std::optional<std::string> thing(std::size_t thing, ViewpointIndex from, Rivals rivals);

 private:
  bool brief() { return chance(brevity_); }
  /// "the bedroom with the red rug", "the other bedroom", where there are several bedrooms
  std::string entered(std::size_t room, double mark = 0.5);
  std::string left(std::size_t room);
  bool been_in_another(std::size_t room) const;
  std::string door_aside(const PathStretch& stretch, const Happening& crossing, const Slots& slots);
  std::string door(const Happening& crossing);
  bool leaves(const Happening& crossing) const;

  SpokenHome home_;
  Naming naming_;
  SpeakerKind speaker_;
  double brevity_;
  Rng rng_;
  std::size_t goal_room_ = 0;
  std::vector<std::size_t> been_;
  std::map<std::string, std::string> names_;  // of rooms
};

}  // namespace enfilade::homes::instructions
