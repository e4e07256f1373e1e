/// \file  A room during furnishing: its furniture, its free floor, its passages.
#pragma once
#include <algorithm>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/homes/furniture/shapes.h"

namespace enfilade::homes::furniture {

/// A piece of a group, in the group's frame. Its x is along the wall, y from the wall (or the
/// group's back edge) into the room, z from the floor. With `turned` 0 it faces the room.
struct Item {
  Item(const Shape& what, Size of, double at_x, double at_y, double at_z = 0, double turn = 0)
      : shape(&what), size(of), x(at_x), y(at_y), z(at_z), turned(turn) {}
  /// In the shape's usual size.
  Item(const Shape& what, double at_x, double at_y, double at_z = 0, double turn = 0)
      : Item(what, what.size, at_x, at_y, at_z, turn) {}

  const Shape* shape;
  Size size;
  double x, y, z;    ///< of its middle; z: of its lowest point
  double turned;     ///< radians, counter-clockwise
  double power = 1;  ///< of its lamps
};

/// Pieces that belong together: `w` along the wall, `d` into the room. The `front` metres before it
/// stay free for their users.
struct Group {
  double w = 0, d = 0, front = 0;
  std::vector<Item> items;
};

/// Where a group may go: its frame's origin and quarter turns.
struct Frame {
  Vec3d origin;
  unsigned quarters = 0;  ///< 0: the room is in +y of it
  Vec3d to_world(double x, double y, double z = 0) const;
  double angle() const;
};

/// A place at a wall, with the inputs of its score.
struct Spot {
  Frame frame;
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
  const Shape& pick(std::string_view noun);

  /// The best place that is free and leaves all ways open; builds the group there. The scores are
  /// jittered, so that rooms differ.
  std::optional<Spot> place_at_wall(const Group& group, const Score& score);
  std::optional<Spot> place_at_wall(const Shape& shape, const Score& score, double front = 0.5);
  /// Anywhere in the room, in any of the four directions; nearer to `towards` is better.
  std::optional<Frame> place_free(const Group& group, Vec3d towards);
  /// Exactly there, if it is free.
  bool place(const Group& group, const Frame& frame);

  /// Builds it there without checking for free space: objects on objects, lamps at ceilings.
  void put(const Item& item, const Frame& frame);
  /// As put(), unless it would meet something. Returns whether it was built.
  bool put_if_clear(const Item& item, const Frame& frame);
  /// Puts it on a wall, above the furniture there: `low` metres above the floor, at most `slide`
  /// from `along`. It is `apart` from doors, windows and other hanging objects.
  bool hang(const Shape& shape, Size size, Side wall, double along, double low, double slide = 0,
            double apart = 0.06);
  /// In its usual size, above a place.
  bool hang(const Shape& shape, const Spot& at, double low, double slide) {
    return hang(shape, shape.size, at.wall, at.along, low, slide);
  }
  /// On any wall with room for it, well apart from others. `low` as above.
  bool hang_anywhere(const Shape& shape, double low);
  /// On the floor, below what stands there; cut to the room's size.
  bool lay(const Shape& shape, Size size, const Frame& frame, double x, double y);

  Frame wall_frame(Side wall, double along) const;
  /// Ends of a wall (x or y).
  std::pair<double, double> wall_ends(Side wall) const;
  Frame middle() const;

 private:
  struct WallItem {
    Side wall;
    double from, to, low, high;
  };
  struct Solid {
    Rect box;
    double low, high;  // above the floor
  };
  Rect footprint(const Item& item, const Frame& frame) const;
  Solid solid(const Item& item, const Frame& frame) const;
  static bool meets_any(const Solid& solid, const std::vector<Solid>& others);
  bool fits(const std::vector<Rect>& rects) const;
  bool commit(const Group& group, const Frame& frame, std::optional<Side> wall);
  std::vector<Spot> spots(const Group& group) const;
  bool wall_is_free(const WallItem& item, double margin) const;
  Spot describe(const Frame& frame, Side wall, double along, double w) const;

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

}  // namespace enfilade::homes::furniture
