#include "enfilade/homes/plan/draws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace enfilade::homes::plan {
namespace {

constexpr std::array<RoomSize, 25> kSizes{{
    {'a', 3.6, 6.0, 14, 1.8}, {'b', 8.5, 13, 34, 2.7},  {'c', 1.9, 4.0, 12, 1.4},
    {'d', 8.5, 13, 45, 2.6},  {'e', 2.0, 5.0, 20, 1.3}, {'f', 11, 18, 60, 2.9},
    {'g', 16, 21, 60, 3.2},   {'h', 2.0, 6.0, 90, 1.3}, {'i', 8, 12, 60, 2.6},
    {'j', 2.8, 5.0, 16, 1.7}, {'k', 8, 12, 45, 2.6},    {'l', 14, 23, 90, 3.2},
    {'m', 9, 18, 90, 2.8},    {'n', 11, 20, 120, 2.9},  {'o', 7, 10.5, 90, 2.6},
    {'p', 5, 8.5, 25, 1.9},   {'r', 11, 18, 90, 2.9},   {'t', 1.7, 2.4, 7, 1.4},
    {'u', 2.5, 5.0, 22, 1.6}, {'v', 10, 14, 60, 2.8},   {'w', 9, 15, 70, 2.7},
    {'y', 4.5, 7.5, 22, 1.7}, {'z', 2.5, 5.0, 40, 1.5}, {'C', 14, 28, 100, 3.4},
    {'S', 9, 16, 60, 2.7},
}};

ChainItem room(char type, std::string name) {
  return {.type = type, .name = std::move(name), .area = room_size(type).usual};
}
ChainItem open_plan() { return {.type = 'o', .name = "open-plan office", .area = 34}; }
ChainItem pair(char near, std::string near_name, char far, std::string far_name,
               std::string hosts) {
  return {.shape = ChainItem::Form::kPair,
          .near = near,
          .far = far,
          .near_name = std::move(near_name),
          .far_name = std::move(far_name),
          .far_hosts = std::move(hosts),
          .area = 2 * std::max({room_size(near).usual, room_size(far).usual, 4.0})};
}
ChainItem suite(std::string name, bool bath_far = true) {
  ChainItem item = bath_far ? pair('c', "closet", 'a', "bathroom", "")
                            : pair('a', "bathroom", 'c', "closet", "");
  item.shape = ChainItem::Form::kSuite;
  item.type = 'b';
  item.name = std::move(name);
  item.area = 16 + 9.5;
  return item;
}
ChainItem hotel_room(double depth, bool large) {
  if (depth < 6) return suite("hotel room", large);
  return {.shape = ChainItem::Form::kHotelRoom,
          .type = 'b',
          .name = large ? "hotel suite" : "hotel room",
          .area = (large ? 4.9 : 4.1) * depth};
}

/// Rooms that a storey may have beyond those that it must have: in this order, each if its turn
/// comes up, until the storey is full.
struct Option {
  double share;
  Chain chain;
};

Chain chain(std::vector<ChainItem> items) { return {std::move(items), false}; }
Option option(double share, std::vector<ChainItem> items, bool inner = false) {
  return {share, {std::move(items), inner}};
}

Chain kitchen_group(Rng& rng, bool with_living) {
  std::vector<ChainItem> items;
  if (with_living) items.push_back(room('l', "living room"));
  items.push_back(room('d', "dining room"));
  items.push_back(room('k', "kitchen"));
  const double pick = rng.uniform();
  if (pick < 0.6) {
    items.push_back(pair('t', "toilet", 'j', "laundry room", "kugd"));
  } else if (pick < 0.85) {
    items.push_back(pair('t', "toilet", 'u', "utility room", "kgd"));
  } else {
    items.push_back(pair('c', "coat closet", 'j', "laundry room", "kgd"));
  }
  return chain(std::move(items));
}

std::vector<Option> house_options(unsigned storey, bool private_rooms, bool public_rooms) {
  std::vector<Option> options;
  if (public_rooms) {
    options = {
        option(0.55, {room('o', "study")}),
        option(0.45, {room('g', "garage"), pair('c', "coat closet", 'u', "utility room", "gk")}),
        option(0.4, {room('v', "TV room")}),
        option(0.45, {room('f', "family room")}),
        option(0.3, {room('p', "porch")}),
        option(0.3, {room('i', "library")}),
        option(0.25, {room('w', "home gym")}),
        option(0.25, {room('r', "playroom")}),
        option(0.3, {room('b', "guest bedroom"), pair('t', "toilet", 'a', "guest bathroom", "b")})};
  }
  if (!private_rooms) return options;
  const std::vector<Option> more{
      option(0.8, {room('b', "bedroom"), pair('c', "linen closet", 'a', "small bathroom", "b")}),
      option(0.9, {room('b', "child's bedroom")}),
      option(0.5, {room('b', "bedroom")}),
      option(0.35, {room('y', storey > 0 ? "balcony" : "terrace")}),
      option(0.4, {room('o', "study")}),
      option(0.25, {room('f', "family room")}),
      option(0.25, {room('r', "playroom")}),
      option(0.3, {pair('u', "utility room", 'c', "walk-in closet", "b")}),
      option(0.25, {room('i', "reading room")}),
      option(0.25, {room('w', "home gym")}),
      option(0.5, {suite("guest bedroom", false)})};
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

std::vector<Option> office_options() {
  return {option(0.8, {room('m', "meeting room")}),
          option(0.9, {room('o', "office")}),
          option(0.6, {room('o', "office"), room('o', "office")}),
          option(0.4, {pair('z', "storage room", 'u', "server room", "omC")}),
          option(0.4, {room('n', "lounge")}),
          option(0.5, {open_plan()}),
          option(0.3, {room('i', "library")}),
          option(0.3, {room('C', "training room")}),
          option(0.25, {room('m', "board room")}),
          option(0.2, {room('w', "gym")}),
          option(0.2, {room('r', "games room")}),
          option(0.25, {room('y', "terrace")}),
          option(0.4, {pair('a', "restroom", 'z', "archive", "omiC")})};
}

std::vector<Option> hotel_options(double depth) {
  return {option(1.0, {hotel_room(depth, false), hotel_room(depth, false)}),
          option(0.9, {hotel_room(depth, false), hotel_room(depth, false)}),
          option(0.4, {hotel_room(depth, true)}),
          option(0.35, {pair('u', "linen room", 'c', "walk-in closet", "b")}),
          option(0.3, {room('w', "gym")}),
          option(0.3, {room('S', "spa")}),
          option(0.3, {room('o', "manager's office")}),
          option(0.9, {hotel_room(depth, false), hotel_room(depth, false)}),
          option(0.25, {room('d', "breakfast room"), room('k', "kitchen")}),
          option(0.3, {room('m', "meeting room")})};
}

double area_of(const Chain& chain) {
  double sum = 0;
  for (const ChainItem& item : chain.items) sum += item.area;
  return sum;
}

// A small home's one bath is for all.
Chain small_bedrooms() {
  return chain({room('b', "bedroom"), pair('a', "bathroom", 'c', "closet", "b")});
}

std::vector<Chain> house_musts(const ProgramNeeds& needs, Rng& rng) {
  if (needs.storeys == 1 && needs.strips < 58) {
    return {chain({room('l', "living room"), room('k', "kitchen")}), small_bedrooms()};
  }
  std::vector<Chain> musts;
  if (needs.storey == 0) {
    const bool together = chance(rng, 0.5);
    if (!together) musts.push_back(chain({room('l', "living room")}));
    musts.push_back(kitchen_group(rng, together));
  }
  if (needs.storeys == 1 && needs.strips < 75) {
    musts.push_back(small_bedrooms());
  } else if (needs.storeys == 1 || needs.storey > 0) {
    musts.push_back(chain({suite(needs.storey < 2 ? "master bedroom" : "guest bedroom")}));
    musts.push_back(
        chain({room('b', "bedroom"), pair('a', "bathroom", 'c', "walk-in closet", "b")}));
  }
  return musts;
}

std::vector<Chain> office_musts(const ProgramNeeds& needs) {
  std::vector<Chain> musts;
  if (needs.storey == 0) musts.push_back(chain({room('n', "reception")}));
  musts.push_back(chain({room('o', "office"), pair('a', "restroom", 'z', "storage room", "omkn")}));
  if (needs.strips > 60) musts.push_back(chain({room('m', "meeting room")}));
  if (needs.strips > 80 && needs.storey == 0) {
    musts.push_back(chain({room('d', "canteen"), room('k', "kitchenette")}));
  } else if (needs.strips > 80) {
    musts.push_back(chain({room('k', "tea kitchen")}));
  }
  return musts;
}

std::vector<Chain> hotel_musts(const ProgramNeeds& needs) {
  std::vector<Chain> musts;
  musts.push_back(chain({hotel_room(needs.depth, false), hotel_room(needs.depth, false)}));
  if (needs.strips > 110) {
    musts.push_back(chain({room('n', "lounge")}));
    const bool deep = needs.depth > 4.5;
    musts.push_back(deep ? chain({pair('u', "linen room", 'j', "laundry room", "non")})
                         : chain({room('j', "laundry room")}));
  }
  return musts;
}

std::vector<Option> inner_options(HomeKind kind) {
  std::vector<Option> options{
      option(0.8, {room('n', "lounge")}, true), option(0.5, {room('w', "gym")}, true),
      option(0.5, {room('r', "games room")}, true), option(0.4, {room('z', "storage room")}, true),
      option(0.4, {room('i', "library")}, true)};
  if (kind == HomeKind::kHouse || kind == HomeKind::kFlat) {
    options.push_back(option(0.6, {room('v', "home theatre")}, true));
  } else {
    options.push_back(option(0.9, {room('m', "meeting room")}, true));
    options.push_back(option(0.6, {room('m', "conference room")}, true));
  }
  return options;
}

// Wanted sizes follow the space that there is, larger where it is plenty.
void scale_to(std::vector<Chain>& program, double strips, bool inner) {
  double sum = 0;
  for (const Chain& chain : program) sum += chain.inner == inner ? area_of(chain) : 0;
  for (Chain& chain : program) {
    if (chain.inner != inner) continue;
    for (ChainItem& item : chain.items) item.area *= strips / sum;
  }
}

void add_options(std::vector<Chain>& program, std::vector<Option> options, double space, Rng& rng) {
  // Larger floors have larger rooms, as well as more of them.
  const double grandeur = std::clamp(std::sqrt(space / 85), 0.85, 1.6);
  double sum = 0;
  for (const Chain& chain : program) sum += area_of(chain) * grandeur;
  for (unsigned round = 0; round < 60 && sum < 0.9 * space; ++round) {
    rng.shuffle(std::span(options));
    for (const Option& o : options) {
      const double area = area_of(o.chain) * grandeur;
      const bool first = program.empty();
      if (!first && (!chance(rng, o.share) || sum + 0.6 * area > space)) continue;
      program.push_back(o.chain);
      sum += area;
    }
  }
}

}  // namespace

const RoomSize& room_size(char type) {
  const auto* found =
      std::find_if(kSizes.begin(), kSizes.end(), [&](const RoomSize& s) { return s.type == type; });
  static constexpr RoomSize kAny{'z', 2.5, 8, 60, 1.5};
  return found == kSizes.end() ? kAny : *found;
}

std::vector<Chain> draw_program(const ProgramNeeds& needs, Rng& rng) {
  std::vector<Chain> program;
  std::vector<Option> options;
  switch (needs.kind) {
    case HomeKind::kHouse:
    case HomeKind::kFlat: {
      program = house_musts(needs, rng);
      const bool one = needs.storeys == 1;
      options = house_options(needs.storey, one || needs.storey > 0, needs.storey == 0);
      if (needs.kind == HomeKind::kFlat) {
        std::erase_if(options,
                      [](const Option& o) { return is_one_of(o.chain.items[0].type, "gp"); });
      }
      break;
    }
    case HomeKind::kOffice:
      program = office_musts(needs);
      options = office_options();
      break;
    case HomeKind::kHotelFloor:
      program = hotel_musts(needs);
      options = hotel_options(needs.depth);
      break;
  }
  add_options(program, std::move(options), needs.strips, rng);
  scale_to(program, needs.strips, false);
  if (needs.inner > 0) {
    std::vector<Chain> inner;
    add_options(inner, inner_options(needs.kind), needs.inner, rng);
    program.insert(program.end(), inner.begin(), inner.end());
    scale_to(program, needs.inner, true);
  }
  return program;
}

}  // namespace enfilade::homes::plan
