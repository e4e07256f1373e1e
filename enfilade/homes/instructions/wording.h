/// \file  Clauses for the facts of a path, each with many variants. Internal.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/homes/instructions/naming.h"
#include "enfilade/homes/instructions/path_story.h"
#include "enfilade/homes/instructions/phrases.h"

namespace enfilade::homes::instructions {

/// Draws clauses for one speaker: imperatives without capital letter and full stop.
class Wording {
 public:
  /// \param brevity  probability that a clause gets the fewest words, [0, 1]
  Wording(const SpokenHome& home, Speaker speaker, double brevity, std::uint64_t seed)
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
  std::string along(const Stretch& stretch, bool with_turn);
  std::string stairs(const Stretch& stretch);
  /// Into another room. \param straight  the opening lies straight ahead
  std::string cross(const Happening& crossing, bool straight);
  /// The turn of a stretch and its first crossing, right after it.
  std::string turn_and_cross(const Stretch& stretch, const Happening& crossing);
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
  std::string door_aside(const Stretch& stretch, const Happening& crossing, const Slots& slots);
  std::string door(const Happening& crossing);
  bool leaves(const Happening& crossing) const;

  SpokenHome home_;
  Naming naming_;
  Speaker speaker_;
  double brevity_;
  Rng rng_;
  std::size_t goal_room_ = 0;
  std::vector<std::size_t> been_;
  std::map<std::string, std::string> names_;  // of rooms
};

}  // namespace enfilade::homes::instructions
