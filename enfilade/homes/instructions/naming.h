/// \file  Unambiguous names for the objects and rooms of a home. Internal.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/homes/instructions/speaker.h"

namespace enfilade::homes::instructions {

/// How much a speaker tells about an object beyond its distinction from others.
enum class Detail : std::uint8_t { kPlain, kColour };

/// The objects that a name must not fit.
enum class Rivals : std::uint8_t {
  kHere,    ///< objects in the same room or behind open doors: where a path ends
  kNearby,  ///< also things out of view a few doors away: along a path
};

/// Names for the objects and rooms of one home.
class Naming {
 public:
  explicit Naming(const SpokenHome& home) : home_(home) {}

  /// Words such as "green sofa" that fit this object and none of its rivals, seen from the
  /// viewpoint; no value if there are none.
  std::optional<std::string> thing(std::size_t thing, ViewpointIndex from, Detail detail,
                                   Rivals rivals, Rng& rng) const;
  /// Words that fit this object and none of `others`, from any viewpoint; no value if there are
  /// none.
  std::optional<std::string> thing_among(std::size_t thing, std::span<const std::size_t> others,
                                         Detail detail, Rng& rng) const;
  /// "living room", "lounge": never a name of another kind of room in the home.
  std::string room(std::size_t room, Rng& rng) const;
  /// An object such as "red rug" that distinguishes a room from others of its name. No value if
  /// there are no others, or no such object.
  std::optional<std::string> mark_of(std::size_t room, Rng& rng) const;
  /// Whether the two rooms have the same name.
  bool same_room_name(std::size_t a, std::size_t b) const;
  /// How many rooms of the home have its name, itself included.
  std::size_t rooms_of_name(std::size_t room) const;
  bool is_stairs(std::size_t room) const { return home_.home.plan.rooms[room].type == 's'; }
  /// Whether the room mainly leads to others: hall, corridor, landing.
  bool is_way(std::size_t room) const;

 private:
  /// \param rivals  objects that `noun` fits, too
  std::optional<std::string> words_of(std::size_t thing, std::string_view noun,
                                      std::span<const std::size_t> rivals, Detail detail,
                                      Rng& rng) const;
  std::vector<std::size_t> others(std::size_t thing, ViewpointIndex from) const;
  std::vector<std::size_t> rivals_of(std::size_t thing, std::string_view noun, ViewpointIndex from,
                                     Rivals rivals) const;
  bool is_behind_walls(std::size_t thing, ViewpointIndex from) const;

  SpokenHome home_;
};

/// Importance of objects of its category to people, [0, 1]; 0 for walls, doors, stairs.
double weight_of(const Home& home, std::size_t thing);
/// Whether a name is plural: "books", but not "chest of drawers".
bool is_plural(std::string_view name);
/// Whether the object is a floor covering, which people step on.
bool is_rug(const HomeThing& thing);

}  // namespace enfilade::homes::instructions
