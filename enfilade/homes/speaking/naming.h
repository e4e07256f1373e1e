/// \file  What people call things and rooms of a home, and whether that names one thing only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/homes/speaking/speaker.h"

namespace enfilade::homes::speaking {

/// How much a speaker says of a thing beyond what tells it from others.
enum class Detail : std::uint8_t { kPlain, kColour };

/// What a thing must not be mistaken for.
enum class Rivals : std::uint8_t {
  kHere,    ///< what is in the same room, or behind open doors: for who stops there
  kNearby,  ///< also what is out of view a few doors away: for who walks on
};

/// Names for the things and rooms of one home.
class Naming {
 public:
  explicit Naming(const SpokenHome& home) : home_(home) {}

  /// "green sofa": words that fit this thing and no rival of it for who stands at the viewpoint;
  /// nothing if there are none.
  std::optional<std::string> thing(std::size_t thing, ViewpointIndex from, Detail detail,
                                   Rivals rivals, Rng& rng) const;
  /// "living room", "lounge": never a name that another sort of room of the home goes by.
  std::string room(std::size_t room, Rng& rng) const;
  /// "red rug": a thing that tells a room from others of its name; nothing if there are no others,
  /// or no such thing.
  std::optional<std::string> mark_of(std::size_t room, Rng& rng) const;
  /// Are the two called the same?
  bool same_room_name(std::size_t a, std::size_t b) const;
  /// Does one other room, and no more, go by its name?
  bool is_one_of_two(std::size_t room) const;
  bool is_stairs(std::size_t room) const { return home_.home.plan.rooms[room].type == 's'; }
  /// Is it a room that one passes through to others: hall, corridor, landing?
  bool is_way(std::size_t room) const;

 private:
  std::vector<std::size_t> others(std::size_t thing, ViewpointIndex from) const;
  std::vector<std::size_t> rivals_of(std::size_t thing, std::string_view noun, ViewpointIndex from,
                                     Rivals rivals) const;
  bool is_behind_walls(std::size_t thing, ViewpointIndex from) const;

  SpokenHome home_;
};

/// How much people care for things of its category, [0, 1]; 0 for walls, doors, stairs.
double weight_of(const Home& home, std::size_t thing);
/// "books", but not "chest of drawers".
bool is_plural(std::string_view name);
/// Is it a floor covering, which people walk over?
bool is_rug(const Thing& thing);

}  // namespace enfilade::homes::speaking
