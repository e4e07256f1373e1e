#include "enfilade/synth/detail/naming.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <string_view>

namespace enfilade::synth::detail {
namespace {

using Group = std::vector<std::string_view>;

// Words for the same thing. A word that the generator uses and that stands nowhere here is said as
// it is.
const std::vector<Group>& thing_groups() {
  static const std::vector<Group> kGroups{
      {"sofa", "couch", "settee"},
      {"armchair", "easy chair"},
      {"bookshelf", "bookcase"},
      {"television", "TV", "tv", "flat screen"},
      {"fridge", "refrigerator"},
      {"plant", "potted plant", "house plant"},
      {"nightstand", "bedside table", "night table"},
      {"chest of drawers", "dresser"},
      {"painting", "picture", "framed picture"},
      {"rug", "area rug"},
      {"bathtub", "tub"},
      {"sink", "washbasin", "basin"},
      {"counter", "countertop", "worktop"},
      {"kitchen island", "island"},
      {"washing machine", "washer"},
      {"dryer", "tumble dryer"},
      {"stove", "cooker"},
      {"curtain", "drape"},
      {"curtains", "drapes"},
      {"cushion", "throw pillow"},
      {"bin", "wastebasket"},
      {"trash can", "rubbish bin"},
      {"sideboard", "credenza"},
      {"ottoman", "footstool", "pouffe"},
      {"exercise bike", "stationary bike"},
      {"treadmill", "running machine"},
      {"column", "pillar"},
      {"coat rack", "coat stand"},
      {"statue", "sculpture"},
      {"filing cabinet", "file cabinet"},
      {"office chair", "swivel chair", "desk chair"},
      {"desk", "writing desk"},
      {"printer", "copier"},
      {"wall tv", "wall-mounted TV"},
      {"radiator", "heater"},
      {"chandelier", "hanging light"},
      {"floor lamp", "standing lamp"},
      {"monitor", "computer screen"},
      {"wardrobe", "armoire"},
      {"fireplace", "hearth"},
      {"pool table", "billiard table"},
      {"shower", "shower stall"},
      {"coffee table", "low table"},
      {"shoe rack", "shoe shelf"},
      {"loveseat", "small sofa"},
      {"corner sofa", "sectional sofa", "sectional"},
      {"ping pong table", "table tennis table"},
      {"display cabinet", "china cabinet"},
      {"tv stand", "TV stand", "entertainment center"},
  };
  return kGroups;
}

const std::vector<Group>& room_groups() {
  static const std::vector<Group> kGroups{
      {"living room", "lounge", "sitting room"},
      {"hallway", "hall", "corridor", "passage", "passageway"},
      {"bathroom", "bath", "washroom"},
      {"toilet", "powder room", "restroom", "half bath", "WC"},
      {"dining room", "dining area"},
      {"entrance hall", "entryway", "foyer", "entry", "vestibule", "room entry"},
      {"office", "study"},
      {"laundry room", "laundry", "wash room"},
      {"closet", "walk-in closet"},
      {"gym", "home gym", "exercise room", "workout room", "fitness room"},
      {"library", "reading room"},
      {"family room", "den"},
      {"meeting room", "conference room"},
      {"game room", "games room", "rec room"},
      {"TV room", "tv room", "media room"},
      {"utility room", "utility area"},
      {"master bedroom", "main bedroom"},
      {"guest room", "guest bedroom", "spare bedroom"},
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

// Spellings that are known but not said: "TV" is.
bool is_sayable(std::string_view word) {
  static const std::set<std::string_view> kNot{"tv", "tv stand", "wall tv"};
  return !kNot.contains(word);
}

// "the toilet" is a thing.
bool is_sayable_room(std::string_view word) { return word != "tv room" && word != "toilet"; }

constexpr double kLargeThing = 0.8;  // metres: seen at once when one comes in

constexpr double kFar = 9;  // metres: beyond, things are not mistaken for near ones

Vec3d middle_of(const Thing& t) {
  return {(t.low.x + t.high.x) / 2, (t.low.y + t.high.y) / 2, (t.low.z + t.high.z) / 2};
}

// Could someone point at a thing of that name and say `word`? "chair" fits an armchair.
bool fits(std::string_view word, std::string_view name) {
  return name.size() >= word.size() && name.substr(name.size() - word.size()) == word;
}

bool fits_any(std::string_view word, const Thing& other) {
  const Group names = words_for(thing_groups(), other.noun);
  return std::ranges::any_of(names, [&](std::string_view name) { return fits(word, name); });
}

bool is_spoken_material(std::string_view material) {
  static const std::set<std::string_view> kSpoken{"wooden", "leather", "marble", "metal", "glass",
                                                  "brick",  "stone",   "clay",   "wicker"};
  return kSpoken.contains(material);
}

std::string material_of(const Thing& thing) {
  // A wooden window is a window to everybody.
  const bool said = is_spoken_material(thing.material) && !fits("window", thing.noun);
  return said ? thing.material : std::string();
}

std::string joined(std::initializer_list<std::string_view> words) {
  std::string text;
  for (const std::string_view word : words) {
    if (word.empty()) continue;
    if (!text.empty()) text += ' ';
    text += word;
  }
  return text;
}

// Could one say those words of its looks? A dark green plant is a green one, too.
bool looks(const Thing& thing, const std::string& said) {
  const std::string all = " " + thing.colour + " " + thing.material + " ";
  std::istringstream words(said);
  for (std::string word; words >> word;) {
    if (all.find(" " + word + " ") == std::string::npos) return false;
  }
  return true;
}

// By mpcat40: how gladly people speak of it.
double category_weight(std::uint16_t category) {
  switch (category) {
    case 1:
    case 4:
    case 16:
    case 17:
    case 29:
      return 0;  // NOLINT: wall, door, stairs, ceiling
    case 9:
    case 30:
      return 0.1;  // window, railing
    case 8:
    case 12:
    case 20:
    case 28:
    case 32:
    case 38:
    case 39:
      return 0.4;
    default:
      return 1;
  }
}

}  // namespace

std::vector<std::size_t> Naming::others(std::size_t thing, ViewpointIndex from) const {
  const std::vector<Thing>& things = home_.home.things;
  std::set<std::size_t> found;
  for (const Sight& sight : home_.sights.at(from)) found.insert(sight.thing);
  // What stands in the room, or a few doors away, can come into view with the next step.
  std::set<std::size_t> rooms{things[thing].room};
  const auto here = home_.sights.room(from);
  if (here) rooms.insert(*here);
  for (int doors = 0; doors < 3; ++doors) {
    const std::set<std::size_t> near = rooms;
    for (const Opening& o : home_.home.plan.openings) {
      if (!o.room1 || o.kind == Opening::Kind::kWindow) continue;
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

std::optional<std::string> Naming::thing(std::size_t thing, ViewpointIndex from, Detail detail,
                                         Rng& rng) const {
  const Thing& t = home_.home.things[thing];
  const Group group = words_for(thing_groups(), t.noun);
  std::vector<std::string_view> nouns(group.begin(), group.end());
  std::erase_if(nouns, [](std::string_view w) { return !is_sayable(w); });
  // Half of the time the generator's own word, so that common words stay common.
  const std::string_view noun = rng.below(2) == 0 && is_sayable(t.noun)
                                    ? std::string_view(t.noun)
                                    : nouns[rng.below(nouns.size())];
  bool plain = true, colour = !t.colour.empty(), material = !material_of(t).empty();
  bool both = colour && material;
  for (const std::size_t other : others(thing, from)) {
    const Thing& o = home_.home.things[other];
    if (!fits_any(noun, o)) continue;
    const bool colour_same = looks(o, t.colour), material_same = looks(o, t.material);
    plain = false;
    colour = colour && !colour_same;
    material = material && !material_same;
    both = both && !(colour_same && material_same);
  }
  std::vector<std::string> choices;
  const std::string made_of = material_of(t);
  if (plain && detail == Detail::kPlain) choices.emplace_back(noun);
  if (colour) choices.push_back(joined({t.colour, noun}));
  if (material) choices.push_back(joined({made_of, noun}));
  if (both && (choices.empty() || detail == Detail::kColour)) {
    choices.push_back(joined({t.colour, made_of, noun}));
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
  const std::vector<PlanRoom>& rooms = home_.home.plan.rooms;
  const std::vector<Thing>& things = home_.home.things;
  bool alone = true;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    if (i != room && same_room_name(i, room)) alone = false;
  }
  if (alone || is_way(room)) return std::nullopt;
  std::vector<std::string> marks;
  for (const Thing& t : things) {
    const Vec3d size = t.high - t.low;
    if (t.room != room || t.colour.empty() || std::max(size.x, size.y) < kLargeThing) continue;
    const std::size_t place = static_cast<std::size_t>(&t - things.data());
    const bool unique = std::ranges::none_of(things, [&](const Thing& o) {
      return &o != &t && looks(o, t.colour) && fits_any(t.noun, o) &&
             (o.room == room || same_room_name(o.room, room));
    });
    if (unique && is_sayable(t.noun) && weight_of(home_.home, place) >= 1) {
      marks.push_back(joined({t.colour, t.noun}));
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

bool Naming::is_way(std::size_t room) const {
  const char type = home_.home.plan.rooms[room].type;
  return type == 'h' || type == 'e' || type == 's';
}

double weight_of(const Home& home, std::size_t thing) {
  const std::uint32_t object = home.things[thing].object;
  return object < home.mesh.objects.size() ? category_weight(home.mesh.objects[object].category)
                                           : 1;
}

bool is_plural(std::string_view name) {
  return name.ends_with("s") && !name.ends_with("ss") && !name.ends_with("chest of drawers");
}

bool is_rug(const Thing& thing) {
  const std::string_view noun = thing.noun;
  return fits("rug", noun) || fits("mat", noun) || fits("carpet", noun) || fits("runner", noun);
}

}  // namespace enfilade::synth::detail
