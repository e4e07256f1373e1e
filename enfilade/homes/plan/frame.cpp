#include "enfilade/homes/plan/draws.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace enfilade::homes::plan {
namespace {

using Span = std::pair<double, double>;

constexpr double kShortestPiece = 1.7;  // of a corridor, between middle lines
constexpr double kNarrowSpine = 1.65;   // 1.5 m clear: arches in it are 1.2 m wide
constexpr double kStairSpine = 2.5;     // a flight and a passage of 1.3 m beside it

double stair_length(const FrameNeeds& needs) { return snap(needs.run + 2 * kLanding + 0.1); }

// Depth of the rooms beside a corridor.
double strip_depth(const FrameNeeds& needs, Rng& rng) {
  // A small storey with a flight of stairs has no space to give away.
  if (needs.storeys > 1 && needs.area < 95) {
    return snap(draw(rng, 2.8, 2.95 + 0.02 * (needs.area - 70)));
  }
  const double root = std::sqrt(needs.area);
  double depth = 0;
  switch (needs.kind) {
    case HomeKind::kHouse:
    case HomeKind::kFlat:
      depth = std::clamp(root * 0.41, 3.2, 6.0);
      break;
    case HomeKind::kOffice:
      depth = std::clamp(root * 0.36, 3.4, 7.0);
      break;
    case HomeKind::kHotelFloor:
      depth = root > 15 ? 7.0 : std::clamp(root * 0.38, 3.4, 5.2);
      break;
  }
  return snap(std::max(3.1, depth * draw(rng, 0.88, 1.15)));
}

double spine_width(const FrameNeeds& needs, Rng& rng, bool stairs) {
  if (stairs) return snap(draw(rng, kStairSpine, kStairSpine + (needs.area < 85 ? 0.1 : 0.4)));
  const double more = needs.kind == HomeKind::kOffice ? 0.9 : needs.area > 150 ? 0.6 : 0.3;
  return snap(draw(rng, kNarrowSpine, kNarrowSpine + more));
}

// Cuts a corridor that runs from a0 to a1 where its stairs begin and end; `stairs` = {from, to} or
// empty. Ends too short to be rooms become part of the stairs' piece.
void add_spine(StoreyFrame& frame, bool along_x, Span along, Span across,
               std::optional<Span> stairs) {
  const auto add = [&](double from, double to, char type) {
    frame.spine.push_back({laid_rect(along_x, from, to, across.first, across.second), type});
  };
  if (!stairs) return add(along.first, along.second, 'h');
  auto [from, to] = *stairs;
  if (from - along.first < kShortestPiece) from = along.first;
  if (along.second - to < kShortestPiece) to = along.second;
  if (from > along.first) add(along.first, from, 'h');
  add(from, to, 's');
  if (to < along.second) add(to, along.second, 'h');
}

// A flight in a corridor, along its low or high side.
Flight make_flight(bool along_x, double from, Span across, bool high_side, bool reversed,
                   const FrameNeeds& needs) {
  const double a0 = from + kInnerWall / 2 + kLanding - 0.05, a1 = a0 + needs.run;
  const double low = across.first + kInnerWall / 2, high = across.second - kInnerWall / 2;
  Flight flight;
  flight.box = high_side ? laid_rect(along_x, a0, a1, high - kFlightWidth, high)
                         : laid_rect(along_x, a0, a1, low, low + kFlightWidth);
  const Side rising = along_x ? Side::kPlusX : Side::kPlusY;
  flight.towards = reversed ? opposite(rising) : rising;
  return flight;
}

// The strip along the front, up to x = `end`; on the ground floor with the front door's hall.
void add_front(StoreyFrame& frame, bool ground, double end, double depth, Span hall) {
  if (ground) {
    frame.spine.push_back({{hall.first, 0, hall.second, depth}, 'e'});
    frame.blocks.push_back({{0, 0, hall.first, depth}, Side::kPlusY});
    frame.blocks.push_back({{hall.second, 0, end, depth}, Side::kPlusY});
  } else {
    frame.blocks.push_back({{0, 0, end, depth}, Side::kPlusY});
  }
}

// A hall from the front to the back, rooms on either side; at the ground sometimes rooms across
// the whole back.
std::optional<BuildingFrame> central_hall(const FrameNeeds& needs, Rng& rng) {
  const bool stairs = needs.storeys > 1;
  const double left = strip_depth(needs, rng), right = strip_depth(needs, rng);
  const double spine = spine_width(needs, rng, stairs);
  BuildingFrame b;
  b.width = left + spine + right;
  b.depth = snap(needs.area / b.width);
  const double entry = snap(draw(rng, kShortestPiece, 2.4));
  const double least = stairs ? entry + stair_length(needs) : 6.2;
  if (b.depth < least || b.depth > 2.0 * b.width) return std::nullopt;
  double back = snap(draw(rng, 3.4, 4.8));
  const bool has_back = b.depth - back >= std::max(least, 5.0) && b.width > 8.5 && b.width < 15 &&
                        needs.kind != HomeKind::kHotelFloor && chance(rng, 0.6);
  if (!has_back) back = 0;
  const Span across{left, left + spine};
  std::optional<Span> at;
  if (stairs) {
    at = {entry, entry + stair_length(needs)};
    const bool reversed = chance(rng, 0.25), high = chance(rng, 0.5);
    b.flight = make_flight(false, entry, across, high, reversed, needs);
  }
  for (unsigned s = 0; s < needs.storeys; ++s) {
    const double end = s == 0 ? b.depth - back : b.depth;
    StoreyFrame& f = b.storeys.emplace_back();
    const bool whole = end - entry < kShortestPiece;
    f.spine.push_back({{left, 0, left + spine, whole ? end : entry}, s == 0 ? 'e' : 'h'});
    if (stairs || !whole) add_spine(f, false, {entry, end}, across, at);
    f.blocks.push_back({{0, 0, left, end}, Side::kPlusX});
    f.blocks.push_back({{left + spine, 0, b.width, end}, Side::kMinusX});
    if (end < b.depth) f.blocks.push_back({{0, end, b.width, b.depth}, Side::kMinusY});
  }
  return b;
}

// A corridor from side to side between two strips; the front door's hall is a piece of the front
// strip. Sometimes it ends before a strip along one side.
std::optional<BuildingFrame> corridor_across(const FrameNeeds& needs, Rng& rng) {
  const bool stairs = needs.storeys > 1;
  const double front = strip_depth(needs, rng), rear = strip_depth(needs, rng);
  const double spine = spine_width(needs, rng, stairs);
  BuildingFrame b;
  b.depth = front + spine + rear;
  b.width = snap(needs.area / b.depth);
  double side = spine > 2.3 && b.width > 11 && chance(rng, 0.4) ? snap(draw(rng, 3.8, 5.2)) : 0;
  const double end = b.width - side;
  if (end < (stairs ? stair_length(needs) : 6) || b.width > 3.4 * b.depth) return std::nullopt;
  const double hall = snap(draw(rng, 1.9, 2.6));
  const double least = 3.0;
  if (end - hall < 2 * least) return std::nullopt;
  const double door = snap(draw(rng, least, end - hall - least));
  const Span across{front, front + spine};
  std::optional<Span> at;
  if (stairs) {
    const double from = snap(draw(rng, 0, end - stair_length(needs)));
    const double shifted = from < kShortestPiece ? 0 : from;
    at = {shifted, shifted + stair_length(needs)};
    b.flight = make_flight(true, shifted, across, true, chance(rng, 0.5), needs);
  }
  for (unsigned s = 0; s < needs.storeys; ++s) {
    StoreyFrame& f = b.storeys.emplace_back();
    add_spine(f, true, {0, end}, across, at);
    add_front(f, s == 0, end, front, {door, door + hall});
    f.blocks.push_back({{0, front + spine, end, b.depth}, Side::kMinusY});
    if (side > 0) f.blocks.push_back({{end, 0, b.width, b.depth}, Side::kMinusX});
  }
  return b;
}

// A hall from the front, then a corridor to one side: rooms along the hall, and on both sides of
// the corridor.
std::optional<BuildingFrame> ell(const FrameNeeds& needs, Rng& rng) {
  const bool stairs = needs.storeys > 1;
  const double left = strip_depth(needs, rng), front = strip_depth(needs, rng);
  const double rear = strip_depth(needs, rng), spine = spine_width(needs, rng, stairs);
  const double hall = snap(draw(rng, 1.8, 2.5));
  BuildingFrame b;
  b.depth = front + spine + rear;
  b.width = snap(needs.area / b.depth);
  const double x0 = left, x1 = left + hall;
  if (b.width - x1 < (stairs ? stair_length(needs) : 4.5) || b.width > 2.6 * b.depth) {
    return std::nullopt;
  }
  const Span across{front, front + spine};
  std::optional<Span> at;
  if (stairs) {
    double from = snap(draw(rng, x1, b.width - stair_length(needs)));
    if (from - x1 < kShortestPiece) from = x1;
    at = {from, from + stair_length(needs)};
    const bool reversed = chance(rng, 0.5), high = chance(rng, 0.5);
    b.flight = make_flight(true, from, across, high, reversed, needs);
  }
  for (unsigned s = 0; s < needs.storeys; ++s) {
    StoreyFrame& f = b.storeys.emplace_back();
    f.spine.push_back({{x0, 0, x1, front + spine}, s == 0 ? 'e' : 'h'});
    add_spine(f, true, {x1, b.width}, across, at);
    f.blocks.push_back({{0, 0, left, b.depth}, Side::kPlusX});
    f.blocks.push_back({{x1, 0, b.width, front}, Side::kPlusY});
    f.blocks.push_back({{left, front + spine, b.width, b.depth}, Side::kMinusY});
  }
  return b;
}

// A corridor across and two arms to the back, with rooms between the arms.
std::optional<BuildingFrame> horseshoe(const FrameNeeds& needs, Rng& rng) {
  const bool stairs = needs.storeys > 1;
  const double left = strip_depth(needs, rng), right = strip_depth(needs, rng);
  const double front = strip_depth(needs, rng), spine = spine_width(needs, rng, false);
  const double arm = spine_width(needs, rng, stairs), core = snap(draw(rng, 4.2, 7.5));
  BuildingFrame b;
  b.width = left + arm + core + spine + right;
  b.depth = snap(needs.area / b.width);
  const double y1 = front + spine;
  if (b.depth - y1 < (stairs ? stair_length(needs) : 6) || b.depth > 2.2 * b.width) {
    return std::nullopt;
  }
  const double hall = snap(draw(rng, 2.0, 2.8));
  const double door = snap(draw(rng, 4, b.width - hall - 4));
  std::optional<Span> at;
  const Span across{left, left + arm};
  if (stairs) {
    at = {y1, y1 + stair_length(needs)};
    const bool reversed = chance(rng, 0.3), high = chance(rng, 0.5);
    b.flight = make_flight(false, y1, across, high, reversed, needs);
  }
  for (unsigned s = 0; s < needs.storeys; ++s) {
    StoreyFrame& f = b.storeys.emplace_back();
    add_spine(f, true, {0, b.width}, {front, y1}, std::nullopt);
    add_spine(f, false, {y1, b.depth}, across, at);
    const double x2 = left + arm + core;
    add_spine(f, false, {y1, b.depth}, {x2, x2 + spine}, std::nullopt);
    add_front(f, s == 0, b.width, front, {door, door + hall});
    f.blocks.push_back({{0, y1, left, b.depth}, Side::kPlusX});
    f.blocks.push_back({{left + arm, y1, x2, b.depth}, Side::kMinusX, true});
    f.blocks.push_back({{x2 + spine, y1, b.width, b.depth}, Side::kMinusX});
  }
  return b;
}

// Several corridors across, joined by one from the front: for very large floors.
std::optional<BuildingFrame> comb(const FrameNeeds& needs, Rng& rng) {
  const bool stairs = needs.storeys > 1;
  const double depth = strip_depth(needs, rng), spine = spine_width(needs, rng, stairs);
  const double hall = snap(draw(rng, 2.2, 3.0));
  unsigned corridors = 2;
  const auto whole = [&] { return (corridors + 1) * depth + corridors * spine; };
  while (needs.area / whole() > 1.9 * whole()) ++corridors;
  BuildingFrame b;
  b.depth = snap(whole());
  b.width = snap(needs.area / b.depth);
  if (b.width < 2 * stair_length(needs) + hall || b.depth > 1.6 * b.width) return std::nullopt;
  const double door = snap(draw(rng, 0.3, 0.6) * b.width);
  std::optional<Span> at;
  if (stairs) {
    at = {0, stair_length(needs)};
    b.flight = make_flight(true, 0, {depth, depth + spine}, true, true, needs);
  }
  for (unsigned s = 0; s < needs.storeys; ++s) {
    StoreyFrame& f = b.storeys.emplace_back();
    double y = 0;
    f.spine.push_back({{door, 0, door + hall, depth}, s == 0 ? 'e' : 'h'});
    for (unsigned i = 0; i <= corridors; ++i) {
      const bool last = i == corridors;
      const Span strip{snap(y), last ? b.depth : snap(y + depth)};
      if (!last) {
        const Span across{strip.second, snap(strip.second + spine)};
        add_spine(f, true, {0, b.width}, across, i == 0 ? at : std::nullopt);
        if (i > 0) f.spine.push_back({{door, strip.first, door + hall, strip.second}, 'h'});
        f.blocks.push_back({{0, strip.first, door, strip.second}, Side::kPlusY, i > 0});
        f.blocks.push_back(
            {{door + hall, strip.first, b.width, strip.second}, Side::kPlusY, i > 0});
      } else {
        f.blocks.push_back({{0, strip.first, b.width, strip.second}, Side::kMinusY});
      }
      y += depth + spine;
    }
  }
  return b;
}

}  // namespace

std::optional<BuildingFrame> draw_building(const FrameNeeds& needs, Rng& rng) {
  const double pick = rng.uniform();
  const bool hotel = needs.kind == HomeKind::kHotelFloor;
  if (needs.area > 650)
    return pick < 0.25 && needs.area < 900 ? horseshoe(needs, rng) : comb(needs, rng);
  if (needs.area > 230) {
    if (pick < 0.3) return horseshoe(needs, rng);
    return pick < (hotel ? 0.8 : 0.65) ? corridor_across(needs, rng) : ell(needs, rng);
  }
  if (needs.area > 130) {
    if (pick < 0.25) return central_hall(needs, rng);
    return pick < 0.6 ? corridor_across(needs, rng) : ell(needs, rng);
  }
  if (pick < 0.45) return central_hall(needs, rng);
  return pick < 0.75 ? corridor_across(needs, rng) : ell(needs, rng);
}

}  // namespace enfilade::homes::plan
