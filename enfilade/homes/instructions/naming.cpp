#include "enfilade/homes/instructions/naming.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "enfilade/mesh/mpcat40.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::homes::instructions {
namespace {

using Group = std::vector<std::string_view>;

// Synonyms. A word of the generator that is in no group has no synonyms.
const std::vector<Group>& thing_groups() {
  static const std::vector<Group> kGroups{
      {"sofa", "couch", "settee", "divan"},
      {"armchair", "easy chair", "lounge chair", "club chair"},
      {"bookshelf", "bookcase", "bookshelves"},
      {"television", "TV", "tv", "flat screen", "television set"},
      {"fridge", "refrigerator"},
      {"plant", "potted plant", "house plant", "houseplant"},
      {"nightstand", "bedside table", "night table"},
      {"chest of drawers", "dresser", "bureau"},
      {"painting", "picture", "framed picture"},
      {"rug", "area rug", "carpet"},
      {"runner", "hall runner", "carpet runner", "long rug"},
      {"bath mat", "bath rug"},
      {"doormat", "welcome mat", "entrance mat"},
      {"bathtub", "tub"},
      {"toilet", "lavatory", "commode"},
      {"sink", "washbasin", "basin", "hand basin"},
      {"utility sink", "laundry sink"},
      {"sink cabinet", "vanity", "vanity unit", "washstand"},
      {"bathroom cabinet", "bathroom cupboard"},
      {"medicine cabinet", "mirror cabinet"},
      {"wall cabinet", "wall cupboard"},
      {"counter", "countertop", "worktop", "work surface"},
      {"kitchen cabinet", "kitchen cupboard"},
      {"kitchen island", "island"},
      {"washing machine", "washer", "laundry machine"},
      {"dryer", "tumble dryer"},
      {"clothes dryer", "tumble dryer"},
      {"stove", "cooker", "oven", "cooking range"},
      {"range hood", "cooker hood", "extractor hood", "extractor fan"},
      {"microwave", "microwave oven"},
      {"coffee maker", "coffee machine", "espresso machine"},
      {"fruit bowl", "bowl of fruit"},
      {"flowers", "bouquet", "blossoms", "bunch of flowers"},
      {"curtain", "drape"},
      {"curtains", "drapes"},
      {"blinds", "window shades", "window blinds"},
      {"cushion", "throw pillow", "scatter cushion"},
      {"bin", "wastebasket"},
      {"trash can", "rubbish bin", "garbage can", "dustbin", "trash bin"},
      {"basket", "hamper"},
      {"box", "storage box", "crate", "carton"},
      {"toy box", "toy chest"},
      {"sideboard", "credenza", "buffet"},
      {"console table", "hall table", "narrow table"},
      {"ottoman", "footstool", "pouffe"},
      {"exercise bike", "stationary bike"},
      {"treadmill", "running machine"},
      {"column", "pillar"},
      {"coat rack", "coat stand", "hat stand"},
      {"coat", "jacket", "overcoat", "raincoat"},
      {"books", "pile of books"},
      {"vase", "flower vase"},
      {"toilet paper", "toilet roll"},
      {"cups", "mugs"},
      {"bowl", "dish"},
      {"round table", "circular table"},
      {"towel rack", "towel rail"},
      {"hanging clothes", "clothes rail", "rack of clothes", "garments"},
      {"bathrobe", "robe", "dressing gown"},
      {"towel", "bath towel", "hand towel"},
      {"shoes", "pair of shoes", "footwear"},
      {"statue", "sculpture"},
      {"filing cabinet", "file cabinet"},
      {"office chair", "swivel chair", "desk chair"},
      {"desk", "writing desk", "workstation"},
      {"desk lamp", "reading lamp"},
      {"wall lamp", "wall light", "sconce"},
      {"printer", "copier"},
      {"wall tv", "wall-mounted TV"},
      {"radiator", "heater"},
      {"chandelier", "hanging light"},
      {"floor lamp", "standing lamp"},
      {"standing mirror", "full-length mirror"},
      {"mirror", "wall mirror"},
      {"clock", "wall clock"},
      {"candles", "candlesticks"},
      {"monitor", "computer screen"},
      {"laptop", "notebook computer"},
      {"notice board", "bulletin board", "pinboard"},
      {"whiteboard", "dry-erase board"},
      {"wardrobe", "armoire", "clothes cupboard"},
      {"fireplace", "hearth"},
      {"pool table", "billiard table"},
      {"shower", "shower stall", "shower cubicle", "shower enclosure"},
      {"coffee table", "low table"},
      {"dining table", "dinner table"},
      {"conference table", "meeting table"},
      {"shoe rack", "shoe shelf"},
      {"storage shelf", "storage rack", "shelving unit"},
      {"loveseat", "small sofa", "two-seater"},
      {"corner sofa", "sectional sofa", "sectional"},
      {"ping pong table", "table tennis table"},
      {"display cabinet", "china cabinet"},
      {"single bed", "twin bed"},
      {"bunk bed", "bunks"},
      {"tv stand", "TV stand", "entertainment center", "media console"},
  };
  return kGroups;
}

const std::vector<Group>& room_groups() {
  static const std::vector<Group> kGroups{
      {"living room", "lounge", "sitting room", "front room"},
      {"hallway", "hall", "corridor", "passage", "passageway"},
      {"bathroom", "bath", "washroom"},
      {"toilet", "powder room", "restroom", "half bath", "WC", "water closet"},
      {"dining room", "dining area", "eating area"},
      {"entrance hall", "entryway", "foyer", "entry", "vestibule", "front hall", "room entry"},
      {"office", "study"},
      {"laundry room", "laundry"},
      {"closet", "walk-in closet", "dressing room"},
      {"coat closet", "cloakroom"},
      {"gym", "home gym", "exercise room", "workout room", "fitness room"},
      {"library", "reading room"},
      {"family room", "den"},
      {"meeting room", "conference room"},
      {"game room", "games room", "rec room"},
      {"TV room", "tv room", "media room"},
      {"utility room", "utility area"},
      {"master bedroom", "main bedroom", "primary bedroom"},
      {"guest room", "guest bedroom", "spare bedroom"},
      {"hotel room", "suite"},
      {"child's bedroom", "kid's room", "child's room"},
      {"board room", "boardroom"},
      {"terrace", "patio"},
      {"store room", "storeroom", "storage room"},
      {"lobby", "reception", "reception area"},
      {"pantry", "larder"},
      {"balcony"},
      {"porch", "veranda"},
  };
  return kGroups;
}

const Group* group_of(const std::vector<Group>& groups, std::string_view word) {
  for (const Group& group : groups) {
    if (std::ranges::find(group, word) != group.end()) return &group;
  }
  return nullptr;
}

Group words_for(const std::vector<Group>& groups, std::string_view word) {
  const Group* group = group_of(groups, word);
  return group ? *group : Group{word};
}

// The colour or, one time out of three, a synonym of it.
std::string spoken_colour(const std::string& colour, Rng& rng) {
  static const std::map<std::string_view, std::string_view> kAlso{
      {"grey", "gray"},       {"cream", "ivory"},   {"light blue", "pale blue"},
      {"light brown", "tan"}, {"golden", "gold"},   {"turquoise", "teal"},
      {"dark blue", "navy"},  {"purple", "violet"}, {"mustard yellow", "mustard"}};
  const auto also = kAlso.find(colour);
  return also != kAlso.end() && rng.below(3) == 0 ? std::string(also->second) : colour;
}

// Whether speakers use the spelling: they say "TV", not "tv".
bool is_sayable(std::string_view word) {
  static const std::set<std::string_view> kNot{"tv", "tv stand", "wall tv"};
  return !kNot.contains(word);
}

// Whether speakers call a room that. "The toilet" would be the thing.
bool is_sayable_room(std::string_view word) { return word != "tv room" && word != "toilet"; }

constexpr double kLargeThing = 0.8;  // metres: seen at once from the door
constexpr double kFar = 9;           // metres: things beyond are not mistaken for near ones

// Whether a point of a storey is in a room or in a doorway.
bool is_open(const Plan& plan, unsigned storey, double x, double y) {
  constexpr double kWall = 0.3;  // metres: thicker than any wall
  const auto in_room = [&](const PlanRoom& r) {
    return r.storey == storey && r.floor.contains(x, y);
  };
  return std::ranges::any_of(plan.rooms, in_room) ||
         std::ranges::any_of(plan.openings, [&](const Opening& o) {
           const double along = o.along_x ? x : y, across = o.along_x ? y : x;
           return o.kind != OpeningKind::kWindow && plan.rooms[o.room0].storey == storey &&
                  std::abs(across - o.wall) < kWall && along > o.from && along < o.to;
         });
}

bool is_open_between(const Plan& plan, unsigned storey, double x0, double y0, double x1,
                     double y1) {
  constexpr double kStep = 0.05;  // metres: thinner than any wall
  const double steps = std::ceil(std::hypot(x1 - x0, y1 - y0) / kStep);
  for (double k = 1; k < steps; ++k) {
    const double share = k / steps;
    if (!is_open(plan, storey, x0 + share * (x1 - x0), y0 + share * (y1 - y0))) return false;
  }
  return true;
}

Vec3d middle_of(const HomeThing& t) { return 0.5 * (t.low + t.high); }

// Whether `word` can mean a thing of that name: "chair" can mean an armchair.
bool fits(std::string_view word, std::string_view name) { return name.ends_with(word); }

bool fits_any(std::string_view word, const HomeThing& other) {
  const Group names = words_for(thing_groups(), other.noun);
  return std::ranges::any_of(names, [&](std::string_view name) { return fits(word, name); });
}

std::string spoken_material(const std::string& material, Rng& rng) {
  return material == "wooden" && rng.below(3) == 0 ? "wood" : material;
}

// The material if people mention it. Nobody calls a window wooden.
std::string material_of(const HomeThing& thing) {
  static const std::set<std::string_view> kSpoken{"wooden", "leather", "marble", "metal", "glass",
                                                  "brick",  "stone",   "clay",   "wicker"};
  const bool said = kSpoken.contains(thing.material) && !fits("window", thing.noun);
  return said ? thing.material : std::string();
}

// Whether the words describe the thing. A dark green plant is also a green one.
bool looks(const HomeThing& thing, const std::string& said) {
  const std::string all = " " + thing.colour + " " + thing.material + " ";
  std::istringstream words(said);
  for (std::string word; words >> word;) {
    if (all.find(" " + word + " ") == std::string::npos) return false;
  }
  return true;
}

// One of the words for a thing: the generator's own half of the time, so that common words stay
// common.
std::string spoken_noun(const HomeThing& thing, Rng& rng) {
  Group nouns = words_for(thing_groups(), thing.noun);
  std::erase_if(nouns, [](std::string_view w) { return !is_sayable(w); });
  if (rng.below(2) == 0 && is_sayable(thing.noun)) return thing.noun;
  return std::string(nouns[rng.below(nouns.size())]);
}

// How much people care for an object, [0, 1].
double object_weight(const mesh::Object& object) {
  using enum mesh::Mpcat40::Category;
  static constexpr std::array kPassed{kWindow, kRailing};  // on the way, but never asked for
  static constexpr std::array kSometimes{kCushion, kCurtain, kTowel,  kLighting,
                                         kBlinds,  kClothes, kObjects};
  const auto is_in = [&](const auto& list) {
    return std::ranges::count(list, object.category) > 0;
  };
  if (is_in(kPassed)) return 0.1;
  if (!tasks::can_be_asked_for(object.name)) return 0;
  return is_in(kSometimes) ? 0.4 : 1;
}

}  // namespace

std::vector<std::size_t> Naming::others(std::size_t thing, ViewpointIndex from) const {
  const std::vector<HomeThing>& things = home_.home.things;
  std::set<std::size_t> found;
  for (const ThingInView& sight : home_.sights.at(from)) found.insert(sight.thing);
  // Things in the room or a few doors away may come into view with the next step.
  std::set<std::size_t> rooms{things[thing].room};
  const auto here = home_.sights.room(from);
  if (here) rooms.insert(*here);
  for (int doors = 0; doors < 3; ++doors) {
    const std::set<std::size_t> near = rooms;
    for (const Opening& o : home_.home.plan.openings) {
      if (!o.room1 || o.kind == OpeningKind::kWindow) continue;
      if (near.contains(o.room0)) rooms.insert(*o.room1);
      if (near.contains(*o.room1)) rooms.insert(o.room0);
    }
    for (const Stairs& s : home_.home.plan.stairs) {
      if (near.contains(s.room_below)) rooms.insert(s.room_above);
      if (near.contains(s.room_above)) rooms.insert(s.room_below);
    }
  }
  const auto eye = home_.graph.position(from);
  for (std::size_t i = 0; i < things.size(); ++i) {
    const Vec3d m = middle_of(things[i]);
    const double far =
        std::hypot(m.x - static_cast<double>(eye.x), m.y - static_cast<double>(eye.y));
    if (things[i].room == things[thing].room || (rooms.contains(things[i].room) && far < kFar)) {
      found.insert(i);
    }
  }
  found.erase(thing);
  return {found.begin(), found.end()};
}

// Walls of the plan only; furniture that hides the thing is not considered.
bool Naming::is_behind_walls(std::size_t thing, ViewpointIndex from) const {
  const Plan& plan = home_.home.plan;
  const HomeThing& t = home_.home.things[thing];
  const auto here = home_.sights.room(from);
  if (!here || t.room == *here) return false;
  if (std::ranges::count(home_.sights.at(from), thing, &ThingInView::thing) > 0) return false;
  const Vec3f eye = home_.graph.position(from);
  const Vec3d middle = middle_of(t);
  for (const double x : {t.low.x, middle.x, t.high.x}) {
    for (const double y : {t.low.y, middle.y, t.high.y}) {
      if (is_open_between(plan, plan.rooms[*here].storey, static_cast<double>(eye.x),
                          static_cast<double>(eye.y), x, y)) {
        return false;
      }
    }
  }
  return true;
}

std::vector<std::size_t> Naming::rivals_of(std::size_t thing, std::string_view noun,
                                           ViewpointIndex from, Rivals rivals) const {
  const Home& home = home_.home;
  const auto storey = [&](std::size_t t) { return home.plan.rooms[home.things[t].room].storey; };
  const std::vector<std::size_t> near = others(thing, from);
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < home.things.size(); ++i) {
    if (i == thing || !fits_any(noun, home.things[i])) continue;
    const bool rival = rivals == Rivals::kHere && storey(i) == storey(thing)
                           ? !is_behind_walls(i, from)
                           : std::ranges::count(near, i) > 0;
    if (rival) found.push_back(i);
  }
  return found;
}

std::optional<std::string> Naming::thing(std::size_t thing, ViewpointIndex from, Detail detail,
                                         Rivals rivals, Rng& rng) const {
  const std::string noun = spoken_noun(home_.home.things[thing], rng);
  return words_of(thing, noun, rivals_of(thing, noun, from, rivals), detail, rng);
}

std::optional<std::string> Naming::thing_among(std::size_t thing,
                                               std::span<const std::size_t> others, Detail detail,
                                               Rng& rng) const {
  const std::string noun = spoken_noun(home_.home.things[thing], rng);
  std::vector<std::size_t> rivals;
  for (const std::size_t other : others) {
    if (other != thing && fits_any(noun, home_.home.things[other])) rivals.push_back(other);
  }
  return words_of(thing, noun, rivals, detail, rng);
}

std::optional<std::string> Naming::words_of(std::size_t thing, std::string_view noun,
                                            std::span<const std::size_t> rivals, Detail detail,
                                            Rng& rng) const {
  const HomeThing& t = home_.home.things[thing];
  bool plain = true, colour = !t.colour.empty() && noun.find(t.colour) == std::string_view::npos,
       material = !material_of(t).empty();
  bool both = colour && material;
  for (const std::size_t other : rivals) {
    const HomeThing& o = home_.home.things[other];
    const bool colour_same = looks(o, t.colour), material_same = looks(o, t.material);
    plain = false;
    colour = colour && !colour_same;
    material = material && !material_same;
    both = both && !(colour_same && material_same);
  }
  std::vector<std::string> choices;
  const std::string made_of = spoken_material(material_of(t), rng);
  if (plain && detail == Detail::kPlain) choices.emplace_back(noun);
  const std::string of_colour = spoken_colour(t.colour, rng);
  if (colour) choices.push_back(fmt::format("{} {}", of_colour, noun));
  if (material) choices.push_back(fmt::format("{} {}", made_of, noun));
  if (both && (choices.empty() || detail == Detail::kColour)) {
    choices.push_back(fmt::format("{} {} {}", of_colour, made_of, noun));
  }
  if (choices.empty() && plain) choices.emplace_back(noun);
  if (choices.empty()) return std::nullopt;
  if (detail == Detail::kPlain) return choices.front();
  return choices[rng.below(choices.size())];
}

std::string Naming::room(std::size_t room, Rng& rng) const {
  const std::vector<PlanRoom>& rooms = home_.home.plan.rooms;
  const std::string& own = rooms[room].name;
  if (is_stairs(room)) return rng.below(2) == 0 ? "stairwell" : "stair hall";
  const Group group = words_for(room_groups(), own);
  std::vector<std::string_view> choices;
  for (const std::string_view word : group) {
    const bool taken = std::ranges::any_of(rooms, [&](const PlanRoom& other) {
      return !std::ranges::count(group, other.name) &&
             (std::string_view(other.name) == word ||
              (group_of(room_groups(), other.name) == nullptr && fits(word, other.name)));
    });
    if (!taken && is_sayable_room(word)) choices.push_back(word);
  }
  if (choices.empty() || (rng.below(2) == 0 && is_sayable_room(own))) return own;
  return std::string(choices[rng.below(choices.size())]);
}

std::optional<std::string> Naming::mark_of(std::size_t room, Rng& rng) const {
  const std::vector<HomeThing>& things = home_.home.things;
  if (rooms_of_name(room) == 1 || is_way(room)) return std::nullopt;
  std::vector<std::string> marks;
  for (const HomeThing& t : things) {
    const Vec3d size = t.high - t.low;
    if (t.room != room || t.colour.empty() || std::max(size.x, size.y) < kLargeThing) continue;
    const std::size_t place = static_cast<std::size_t>(&t - things.data());
    const bool unique = std::ranges::none_of(things, [&](const HomeThing& o) {
      return &o != &t && looks(o, t.colour) && fits_any(t.noun, o) &&
             (o.room == room || same_room_name(o.room, room));
    });
    if (unique && is_sayable(t.noun) && weight_of(home_.home, place) >= 1) {
      marks.push_back(fmt::format("{} {}", t.colour, t.noun));
    }
  }
  if (marks.empty()) return std::nullopt;
  return marks[rng.below(marks.size())];
}

bool Naming::same_room_name(std::size_t a, std::size_t b) const {
  const std::string& x = home_.home.plan.rooms[a].name;
  const std::string& y = home_.home.plan.rooms[b].name;
  const Group* group = group_of(room_groups(), x);
  return x == y || (group != nullptr && group == group_of(room_groups(), y));
}

std::size_t Naming::rooms_of_name(std::size_t room) const {
  std::size_t alike = 0;
  for (std::size_t i = 0; i < home_.home.plan.rooms.size(); ++i) {
    if (same_room_name(i, room)) ++alike;
  }
  return alike;
}

bool Naming::is_way(std::size_t room) const {
  const char type = home_.home.plan.rooms[room].type;
  return type == 'h' || type == 'e' || type == 's';
}

double weight_of(const Home& home, std::size_t thing) {
  const std::uint32_t object = home.things[thing].object;
  return object < home.mesh.objects.size() ? object_weight(home.mesh.objects[object]) : 1;
}

bool is_plural(std::string_view name) {
  return name.ends_with("s") && !name.ends_with("ss") &&
         name.find(" of ") == std::string_view::npos;
}

bool is_rug(const HomeThing& thing) {
  const std::string_view noun = thing.noun;
  return fits("rug", noun) || fits("mat", noun) || fits("carpet", noun) || fits("runner", noun);
}

}  // namespace enfilade::homes::instructions
