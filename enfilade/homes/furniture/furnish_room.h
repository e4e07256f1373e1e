/// \file  A room during furnishing: its furniture, its free floor, its passages; and furniture by
/// kind of room.
#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/homes/furniture/shapes.h"

namespace enfilade::homes::furniture {

/// A piece of a group, in the group's frame. Its x is along the wall, y from the wall (or the
/// group's back edge) into the room, z from the floor. With `turned` 0 it faces the room.
struct GroupItem {
  GroupItem(const FurnitureShape& what, FurnitureSize of, double at_x, double at_y, double at_z = 0,
            double turn = 0)
      : shape(&what), size(of), x(at_x), y(at_y), z(at_z), turned(turn) {}
  /// In the shape's usual size.
  GroupItem(const FurnitureShape& what, double at_x, double at_y, double at_z = 0, double turn = 0)
      : GroupItem(what, what.size, at_x, at_y, at_z, turn) {}

  const FurnitureShape* shape;
  FurnitureSize size;
  double x, y, z;    ///< of its middle; z: of its lowest point
  double turned;     ///< radians, counter-clockwise
  double power = 1;  ///< of its lamps
};

/// Pieces that belong together: `w` along the wall, `d` into the room. The `front` metres before it
/// stay free for their users.
struct FurnitureGroup {
  double w = 0, d = 0, front = 0;
  std::vector<GroupItem> items;
};

/// Where a group may go: its frame's origin and quarter turns.
struct GroupFrame {
  Vec3d origin;
  unsigned quarters = 0;  ///< 0: the room is in +y of it
  Vec3d to_world(double x, double y, double z = 0) const;
  double angle() const;
};

/// A place at a wall, with the inputs of its score.
struct Spot {
  GroupFrame frame;
  Side wall = Side::kPlusX;
  double along = 0;       ///< x or y of its middle
  double off_centre = 0;  ///< of the wall: 0 at its middle, 1 at an end
  double corner = 0;      ///< metres from its side to the nearer corner
  double door = 9;        ///< metres from its middle to the nearest door
  bool window = false;    ///< below a window
};
using Score = std::function<double(const Spot&)>;

class FurnishedRoom {
 public:
  FurnishedRoom(const looks::RoomSpace& space, const looks::RoomStyle& style, Rng& rng,
                looks::HomeParts& parts);

  const looks::RoomSpace& space() const { return space_; }
  const looks::RoomStyle& style() const { return style_; }
  Rng& rng() { return rng_; }
  double width() const { return space_.floor.width(); }
  double depth() const { return space_.floor.depth(); }
  double area() const { return space_.floor.area(); }
  double narrow() const { return std::min(width(), depth()); }
  double longest() const { return std::max(width(), depth()); }
  double height() const { return space_.ceiling_z - space_.floor_z; }
  bool chance(double p) { return rng_.uniform() < p; }
  double between(double a, double b) { return a + (b - a) * rng_.uniform(); }

  /// One of the shapes of that name, drawn.
  const FurnitureShape& pick(std::string_view noun);

  /// The best place that is free and leaves all ways open; builds the group there. The scores are
  /// jittered, so that rooms differ.
  std::optional<Spot> place_at_wall(const FurnitureGroup& group, const Score& score);
  std::optional<Spot> place_at_wall(const FurnitureShape& shape, const Score& score,
                                    double front = 0.5);
  /// Anywhere in the room, in any of the four directions; nearer to `towards` is better.
  std::optional<GroupFrame> place_free(const FurnitureGroup& group, Vec3d towards);
  /// Exactly there, if it is free.
  bool place(const FurnitureGroup& group, const GroupFrame& frame);

  /// Builds it there without checking for free space: objects on objects, lamps at ceilings.
  void put(const GroupItem& item, const GroupFrame& frame);
  /// As put(), unless it would meet something. Returns whether it was built.
  bool put_if_clear(const GroupItem& item, const GroupFrame& frame);
  /// Puts it on a wall, above the furniture there: `low` metres above the floor, at most `slide`
  /// from `along`. It is `apart` from doors, windows and other hanging objects.
  bool hang(const FurnitureShape& shape, FurnitureSize size, Side wall, double along, double low,
            double slide = 0, double apart = 0.06);
  /// In its usual size, above a place.
  bool hang(const FurnitureShape& shape, const Spot& at, double low, double slide) {
    return hang(shape, shape.size, at.wall, at.along, low, slide);
  }
  /// On any wall with room for it, well apart from others. `low` as above.
  bool hang_anywhere(const FurnitureShape& shape, double low);
  /// On the floor, below what stands there; cut to the room's size.
  bool lay(const FurnitureShape& shape, FurnitureSize size, const GroupFrame& frame, double x,
           double y);

  GroupFrame wall_frame(Side wall, double along) const;
  /// Ends of a wall (x or y).
  std::pair<double, double> wall_ends(Side wall) const;
  GroupFrame middle() const;

 private:
  struct WallItem {
    Side wall;
    double from, to, low, high;
  };
  struct Solid {
    Rect box;
    double low, high;  // above the floor
  };
  Rect footprint(const GroupItem& item, const GroupFrame& frame) const;
  Solid solid(const GroupItem& item, const GroupFrame& frame) const;
  static bool meets_any(const Solid& solid, const std::vector<Solid>& others);
  bool fits(const std::vector<Rect>& rects) const;
  bool commit(const FurnitureGroup& group, const GroupFrame& frame, std::optional<Side> wall);
  std::vector<Spot> spots(const FurnitureGroup& group) const;
  bool wall_is_free(const WallItem& item, double margin) const;
  Spot describe(const GroupFrame& frame, Side wall, double along, double w) const;

  const looks::RoomSpace& space_;
  const looks::RoomStyle& style_;
  Rng& rng_;
  looks::HomeParts& parts_;
  std::vector<Rect> standing_, clear_, used_, rugs_;
  std::vector<WallItem> on_walls_;
  std::vector<Solid> built_, hung_;  // everything but rugs; of it, what hangs on walls
};

/// Whether passages 0.75 m wide lead around `standing` from each door to each other and to near the
/// room's middle. At most half a square metre of floor may be cut off.
bool ways_are_open(const looks::RoomSpace& space, const std::vector<Rect>& standing);

// --- parts of many rooms (furnish.cpp) ---

/// Scores: nearer to the middle of a wall, in a corner, away from doors.
double near_middle(const Spot& spot);
double in_corner(const Spot& spot);
double away_from_doors(const Spot& spot);

enum class Light : std::uint8_t { kHome, kSpots, kPanels, kChandelier };
/// Lamps all over the ceiling, more in larger rooms.
void hang_lights(FurnishedRoom& room, Light kind);
/// One pendant above a place.
void hang_pendant(FurnishedRoom& room, Vec3d above);
/// Curtains where there is room for them, else blinds; some windows get neither.
void dress_windows(FurnishedRoom& room, bool curtains);
void hang_pictures(FurnishedRoom& room, unsigned at_most);
/// Puts a plant, a lamp or the like into a free corner.
bool put_in_corner(FurnishedRoom& room, const FurnitureShape& shape);
void plants(FurnishedRoom& room, unsigned at_most);
/// The last objects in a room, in this order.
struct Finish {
  unsigned plants = 0;    ///< at most
  bool curtains = false;  ///< for dress_windows()
  unsigned pictures = 0;  ///< at most
  Light light = Light::kHome;
};
void finish(FurnishedRoom& room, const Finish& what);
/// A table or cabinet at a wall with objects on it and a picture or mirror above.
void dressed_console(FurnishedRoom& room, const FurnitureShape& shape, bool mirror);
/// Small objects along the top of a piece.
void clutter(FurnishedRoom& room, const GroupFrame& frame, const GroupItem& below,
             std::string_view kind);
/// Armchair, lamp, small table.
void reading_corner(FurnishedRoom& room);
void bookshelves(FurnishedRoom& room, unsigned at_most);
/// Table with chairs around it, near the room's middle or `off` metres from it along x.
std::optional<GroupFrame> table_with_chairs(FurnishedRoom& room, const FurnitureShape& table,
                                            FurnitureSize size, std::string_view chair = "chair",
                                            double off = 0);
/// Along a wall: hooks with coats.
void coat_hooks(FurnishedRoom& room);

// --- rooms ---

void furnish_bedroom(FurnishedRoom& room);
void furnish_living(FurnishedRoom& room, bool television);
void furnish_dining(FurnishedRoom& room);
void furnish_booth(FurnishedRoom& room);
void furnish_kitchen(FurnishedRoom& room);
void furnish_bath(FurnishedRoom& room);
void furnish_toilet(FurnishedRoom& room);
void furnish_spa(FurnishedRoom& room);
void furnish_laundry(FurnishedRoom& room);
void furnish_office(FurnishedRoom& room);
void furnish_meeting(FurnishedRoom& room);
void furnish_classroom(FurnishedRoom& room);
void furnish_library(FurnishedRoom& room);
void furnish_entry(FurnishedRoom& room);
void furnish_hallway(FurnishedRoom& room);
void furnish_storage(FurnishedRoom& room, bool garage);
void furnish_closet(FurnishedRoom& room);
void furnish_gym(FurnishedRoom& room);
void furnish_games(FurnishedRoom& room);
void furnish_bar(FurnishedRoom& room);
void furnish_outdoors(FurnishedRoom& room, bool garden);

/// Furnishes a room: first the required pieces of its type (bed against a wall, chairs around a
/// table, sink below a mirror, desks with chairs, ...). Then optional ones that fit, clutter on
/// surfaces, pictures and curtains on walls, a rug, lamps. A way of at least 0.75 m stays free from
/// every door to every other. Draws from `rng` only.
void furnish(const looks::RoomSpace& space, const looks::RoomStyle& style, Rng& rng,
             looks::HomeParts parts);

}  // namespace enfilade::homes::furniture
