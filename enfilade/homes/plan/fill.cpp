#include "enfilade/homes/plan/draws.h"

#include <algorithm>
#include <span>
#include <utility>

namespace enfilade::homes::plan {
namespace {

constexpr double kMostAspect = 2.6;  // of middle lines; of inner faces a little more
constexpr double kDoorWall = 1.35;   // metres between middle lines that a door needs
constexpr std::string_view kHabitable = "bdfiklnorvwmCS";
constexpr std::string_view kThrough = "ldkfn";     // one passes them on the way to others
constexpr std::string_view kNeedCorridor = "bat";  // or a bedroom that they belong to

struct Range {
  double low = 0, want = 0, high = 0;
};

Range room_range(char type, double area, double depth) {
  const RoomSize& size = room_size(type);
  const double low = std::max({size.least_side, size.least / depth, depth / kMostAspect});
  const double high = std::min(size.most / depth, kMostAspect * depth);
  return {low, std::clamp(area / depth, low, std::max(low, high)), high};
}
Range pair_range(char near, char far, double area, double depth) {
  const double half = depth / 2;
  const Range n = room_range(near, area / 2, half), f = room_range(far, area / 2, half);
  Range r{std::max({n.low, f.low, 1.65}), 0, std::min({n.high, f.high, 3.2})};
  r.want = std::clamp(area / depth, r.low, std::max(r.low, r.high));
  return r;
}
Range item_range(const ChainItem& item, double depth) {
  switch (item.shape) {
    case ChainItem::Form::kRoom:
      return room_range(item.type, item.area, depth);
    case ChainItem::Form::kPair:
      return pair_range(item.near, item.far, item.area, depth);
    case ChainItem::Form::kSuite: {
      const Range a = room_range('b', item.area * 0.63, depth);
      const Range b = pair_range(item.near, item.far, item.area * 0.37, depth);
      if (a.low > a.high || b.low > b.high) return {1, 1, 0};
      return {a.low + b.low, a.want + b.want, a.high + b.high};
    }
    case ChainItem::Form::kHotelRoom:
      break;
  }
  if (depth < 6) return {1, 1, 0};
  return {3.5, std::clamp(item.area / depth, 3.5, 5.2), 5.4};
}

// Where an item lies in its block.
struct Placed {
  const ChainItem* item = nullptr;
  Range range;
  double from = 0, to = 0;
  bool flipped = false;  // a suite's baths and a hotel room's bath at its other end
};
struct Strip {
  const RoomStrip* block = nullptr;
  double length = 0, depth = 0;
  std::vector<Placed> placed;
  double used = 0;  // sum of lowest widths
  double wanted = 0;
};

// Piece of a strip: along it, and from the corridor's side (0) away from it.
Rect piece(const RoomStrip& block, double a0, double a1, double n0, double n1) {
  const bool along_x = runs_along_x(block.faces), high = is_high(block.faces);
  const double start = block.box.range(along_x).first, edge = block.box.at(block.faces);
  return laid_rect(along_x, snap(start + a0), snap(start + a1), snap(high ? edge - n1 : edge + n0),
                   snap(high ? edge - n0 : edge + n1));
}

// Widths between their limits that fill the strip: wanted widths times one factor, found by
// halving. False if the limits forbid it.
bool set_widths(Strip& strip) {
  double low_sum = 0, high_sum = 0;
  for (const Placed& p : strip.placed) {
    low_sum += p.range.low;
    high_sum += p.range.high;
  }
  if (strip.placed.empty() || low_sum > strip.length || high_sum < strip.length) return false;
  const auto width = [](const Placed& p, double s) {
    return std::clamp(p.range.want * s, p.range.low, p.range.high);
  };
  double s0 = 0, s1 = 16;
  for (int i = 0; i < 40; ++i) {
    const double s = (s0 + s1) / 2;
    double sum = 0;
    for (const Placed& p : strip.placed) sum += width(p, s);
    (sum < strip.length ? s0 : s1) = s;
  }
  double at = 0;
  for (Placed& p : strip.placed) {
    p.from = snap(at);
    at += width(p, s1);
    p.to = snap(at);
  }
  strip.placed.back().to = strip.length;
  return true;
}

void add_cell(std::vector<Cell>& cells, const Rect& box, char type, std::string name, double wanted,
              std::optional<std::size_t> host = {}) {
  cells.push_back({box, type, std::move(name), false, false, wanted, host, {}});
}

void add_suite(std::vector<Cell>& cells, const Strip& strip, const Placed& p) {
  const ChainItem& item = *p.item;
  const double width = p.to - p.from, depth = strip.depth;
  const Range side = pair_range(item.near, item.far, item.area * 0.37, depth);
  const Range bed = room_range('b', item.area * 0.63, depth);
  const double baths = snap(std::clamp(width * 0.33, std::max(side.low, width - bed.high),
                                       std::min(side.high, width - bed.low)));
  const double cut = p.flipped ? p.from + baths : p.to - baths;
  const double half = snap(depth / 2);
  const auto rect = [&](bool bedroom, double n0, double n1) {
    const bool first = bedroom != p.flipped;
    return piece(*strip.block, first ? p.from : cut, first ? cut : p.to, n0, n1);
  };
  const std::size_t host = cells.size();
  add_cell(cells, rect(true, 0, depth), 'b', item.name, item.area * 0.63);
  add_cell(cells, rect(false, 0, half), item.near, item.near_name, item.area * 0.18, host);
  add_cell(cells, rect(false, half, depth), item.far, item.far_name, item.area * 0.18, host);
}

void add_hotel_room(std::vector<Cell>& cells, const Strip& strip, const Placed& p) {
  constexpr double kBathDepth = 2.45, kHall = 1.5;
  const double cut = p.flipped ? p.from + kHall : p.to - kHall;
  const auto part = [&](bool hall, double n0, double n1) {
    const bool first = hall == p.flipped;
    return piece(*strip.block, first ? p.from : cut, first ? cut : p.to, n0, n1);
  };
  const std::size_t hall = cells.size();
  add_cell(cells, part(true, 0, kBathDepth), 'e', "room entry", 0);
  add_cell(cells, piece(*strip.block, p.from, p.to, kBathDepth, strip.depth), 'b', p.item->name, 0,
           hall);
  add_cell(cells, part(false, 0, kBathDepth), 'a', "bathroom", 0, hall);
}

std::vector<Cell> make_cells(const StoreyFrame& frame, const std::vector<Strip>& strips) {
  std::vector<Cell> cells;
  for (const CorridorPiece& p : frame.spine) {
    const char* name = p.type == 'e' ? "entrance hall" : p.type == 's' ? "stairs" : "hallway";
    cells.push_back({p.box, p.type, name, true, false, 0, {}, {}});
  }
  for (const Strip& strip : strips) {
    for (const Placed& p : strip.placed) {
      const ChainItem& item = *p.item;
      const auto box = [&](double n0, double n1) {
        return piece(*strip.block, p.from, p.to, n0, n1);
      };
      switch (item.shape) {
        case ChainItem::Form::kRoom:
          add_cell(cells, box(0, strip.depth), item.type, item.name, item.area);
          cells.back().inner = strip.block->inner;
          break;
        case ChainItem::Form::kPair: {
          const double half = snap(strip.depth / 2);
          add_cell(cells, box(0, half), item.near, item.near_name, item.area / 2);
          add_cell(cells, box(half, strip.depth), item.far, item.far_name, item.area / 2);
          cells.back().hosts = item.far_hosts;
          break;
        }
        case ChainItem::Form::kSuite:
          add_suite(cells, strip, p);
          break;
        case ChainItem::Form::kHotelRoom:
          add_hotel_room(cells, strip, p);
          break;
      }
    }
  }
  return cells;
}

// Chains are cut here and there, turned round, and laid into strips with room for them.
bool place_items(std::vector<Strip>& strips, const std::vector<Chain>& program, Rng& rng) {
  struct Run {
    std::vector<const ChainItem*> items;
    double wanted = 0;
    bool inner = false;
  };
  std::vector<Run> runs;
  for (const Chain& whole : program) {
    const std::vector<ChainItem>& chain = whole.items;
    runs.emplace_back();
    runs.back().inner = whole.inner;
    for (std::size_t i = 0; i < chain.size(); ++i) {
      // A pair stays with the room before it, through which its far room is reached.
      const bool may_cut = i > 0 && chain[i].shape != ChainItem::Form::kPair;
      if (may_cut && chance(rng, 0.45)) runs.push_back({{}, 0, whole.inner});
      runs.back().items.push_back(&chain[i]);
      runs.back().wanted += chain[i].area;
    }
  }
  rng.shuffle(std::span(runs));
  std::stable_sort(runs.begin(), runs.end(),
                   [](const Run& a, const Run& b) { return a.items.size() > b.items.size(); });
  for (Run& run : runs) {
    if (chance(rng, 0.5)) std::reverse(run.items.begin(), run.items.end());
    Strip* chosen = nullptr;
    double most = 0;
    for (Strip& strip : strips) {
      if (strip.block->inner != run.inner) continue;
      double low = 0;
      for (const ChainItem* item : run.items) {
        const Range r = item_range(*item, strip.depth);
        low += r.low > r.high ? 1e9 : r.low;
      }
      if (strip.length - strip.used - low < 0) continue;
      // Mostly where there is most space left.
      const double left = strip.length - strip.wanted - 0.6 * run.wanted / strip.depth;
      const double value = std::max(left, 0.05) * draw(rng, 0.25, 1);
      if (value <= most) continue;
      most = value;
      chosen = &strip;
    }
    if (chosen == nullptr) return false;
    Strip& strip = *chosen;
    std::vector<Placed> placed;
    for (const ChainItem* item : run.items) {
      placed.push_back({item, item_range(*item, strip.depth), 0, 0, chance(rng, 0.5)});
      strip.used += placed.back().range.low;
      strip.wanted += placed.back().range.want;
    }
    strip.placed.insert(chance(rng, 0.5) ? strip.placed.begin() : strip.placed.end(),
                        placed.begin(), placed.end());
  }
  return true;
}

double outer_wall(const BuildingFrame& b, const Rect& box) {
  double longest = 0;
  constexpr double kAt = 1e-6;
  if (box.x0 < kAt || box.x1 > b.width - kAt) longest = box.depth();
  if (box.y0 < kAt || box.y1 > b.depth - kAt) longest = std::max(longest, box.width());
  return longest;
}
bool has_corner(const BuildingFrame& b, const Rect& box) {
  constexpr double kAt = 1e-6;
  return (box.x0 < kAt || box.x1 > b.width - kAt) && (box.y0 < kAt || box.y1 > b.depth - kAt);
}

// Finds through which room each far room of a pair is reached. False if one has none.
bool host_far_rooms(std::vector<Cell>& cells) {
  for (Cell& far : cells) {
    if (far.hosts.empty()) continue;
    double best = 0;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (cells[c].spine || !is_one_of(cells[c].type, far.hosts)) continue;
      const double room = door_room(far.box, cells[c].box, std::nullopt);
      if (room > best && room >= kDoorWall) {
        best = room;
        far.host = c;
      }
    }
    if (!far.host) return false;
  }
  return true;
}

// Hosts for rooms away from the corridor: rooms that one passes anyway. False if one is out of
// reach.
bool host_rest(std::vector<Cell>& cells, const std::optional<Flight>& flight) {
  std::vector<bool> reached(cells.size(), false);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (cells[c].spine || cells[c].host) reached[c] = true;
    for (std::size_t s = 0; s < cells.size() && cells[s].spine && !reached[c]; ++s) {
      reached[c] = door_room(cells[c].box, cells[s].box, flight) >= kDoorWall;
    }
  }
  for (bool more = true; more;) {
    more = false;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (reached[c] || is_one_of(cells[c].type, kNeedCorridor)) continue;
      for (std::size_t t = 0; t < cells.size(); ++t) {
        const bool open = is_one_of(cells[t].type, kThrough) ||
                          (is_one_of(cells[c].type, "yp") && cells[t].type == 'b');
        if (!reached[t] || !open || cells[t].spine) continue;
        if (door_room(cells[c].box, cells[t].box, flight) < kDoorWall) continue;
        cells[c].host = t;
        reached[c] = more = true;
        break;
      }
    }
  }
  return std::all_of(reached.begin(), reached.end(), [](bool r) { return r; });
}

// Does each room have the walls that it needs?
bool placed_well(const BuildingFrame& b, unsigned storey, const std::vector<Cell>& cells) {
  for (const Cell& c : cells) {
    if (c.spine) continue;
    const double outer = outer_wall(b, c.box);
    if (is_one_of(c.type, kHabitable) && outer < 1.6 && !c.inner) return false;
    if (is_one_of(c.type, "yp") && outer < 1.8) return false;
    if (c.type == 'g' && (storey > 0 || c.box.y0 > 1e-6 || c.box.width() < 3.1)) return false;
  }
  return true;
}

double score(const BuildingFrame& b, const std::vector<Cell>& cells) {
  double sum = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& c = cells[i];
    if (c.spine) continue;
    const double area = c.box.area();
    if (c.wanted > 0) {
      const double off = std::min(area, c.wanted) / std::max(area, c.wanted) - 1;
      sum -= 6 * off * off;
    }
    const double aspect =
        std::max(c.box.width(), c.box.depth()) / std::min(c.box.width(), c.box.depth());
    if (aspect > 1.7) sum -= 1.5 * (aspect - 1.7);
    if (is_one_of(c.type, "ylp") && has_corner(b, c.box)) sum += 0.5;
    for (const Cell& d : cells) {
      if (door_room(c.box, d.box, std::nullopt) < kDoorWall) continue;
      if (c.type == 'd' && d.type == 'k') sum += 2.5;
      if (c.type == 'd' && d.type == 'l') sum += 1.5;
      if (c.type == 'l' && is_one_of(d.type, "kfe")) sum += 0.8;
      if (c.type == 'b' && d.type == 'e' && d.spine) sum -= 0.7;
      if (c.type == 'b' && is_one_of(d.type, "kg")) sum -= 0.4;
      if (c.type == 'b' && d.type == 'b') sum += 0.15;
    }
  }
  return sum;
}

}  // namespace

double door_room(const Rect& a, const Rect& b, const std::optional<Flight>& flight) {
  const auto wall = shared_wall(a, b);
  if (!wall) return 0;
  const double whole = wall->to - wall->from;
  if (!flight) return whole;
  const Rect zone = both_sides(wall->along_x, wall->wall, wall->from, wall->to, kStand);
  if (!overlap(zone, flight->box)) return whole;
  const auto [f0, f1] = flight->box.range(wall->along_x);
  return std::max({0.0, f0 - wall->from, wall->to - f1});
}

std::optional<StoreyLayout> fill(const BuildingFrame& building, unsigned storey,
                                 const std::vector<Chain>& program, unsigned trials, Rng& rng) {
  const StoreyFrame& frame = building.storeys[storey];
  std::optional<StoreyLayout> best;
  for (unsigned t = 0; t < trials; ++t) {
    std::vector<Strip> strips;
    for (const RoomStrip& block : frame.blocks) {
      const bool x = runs_along_x(block.faces);
      strips.push_back({&block, block.box.length(x), block.box.length(!x), {}, 0, 0});
    }
    if (!place_items(strips, program, rng)) continue;
    if (!std::all_of(strips.begin(), strips.end(), set_widths)) continue;
    std::vector<Cell> cells = make_cells(frame, strips);
    if (!placed_well(building, storey, cells)) continue;
    if (!host_far_rooms(cells) || !host_rest(cells, building.flight)) continue;
    const double value = score(building, cells);
    if (!best || value > best->score) best = StoreyLayout{std::move(cells), value};
  }
  return best;
}

}  // namespace enfilade::homes::plan
