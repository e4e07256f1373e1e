#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "enfilade/homes/benchmarks/described_home.h"
#include "enfilade/homes/instructions/phrases.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::benchmarks {
namespace {

constexpr std::size_t kDescriptions = 3, kStarts = 3;
constexpr double kNear = 1.0;           // metres between the boxes of things beside each other
constexpr double kFarStart = 5.0;       // metres along the graph
constexpr Radians kStartHeading(1.52);  // with which SOON is evaluated

// Between two boxes.
double gap_between(const HomeThing& a, const HomeThing& b) {
  const auto gap = [](double low0, double high0, double low1, double high1) {
    return std::max({low1 - high0, low0 - high1, 0.0});
  };
  const double x = gap(a.low.x, a.high.x, b.low.x, b.high.x);
  const double y = gap(a.low.y, a.high.y, b.low.y, b.high.y);
  return std::hypot(std::hypot(x, y), gap(a.low.z, a.high.z, b.low.z, b.high.z));
}

class Describer {
 public:
  Describer(const DescribedHome& site, const tasks::PathAnnotation& path, std::uint64_t seed)
      : site_(site), path_(path), rng_(rng_for(seed, path, "descriptions")) {}

  std::vector<tasks::PathAnnotation> entry() {
    const ViewpointIndex end = site_.graph().find(path_.path.back()).value();
    std::vector<std::size_t> things = site_.things_at(end);
    rng_.shuffle(std::span(things));
    for (const std::size_t thing : things) {
      if (!box_of(thing, end)) continue;
      tasks::PathAnnotation shared;
      if (!describe(thing, shared)) continue;
      std::vector<ViewpointIndex> ends;
      shared.goal = boxes_of(thing, ends);
      return paths_to(ends, shared);
    }
    return {};
  }

 private:
  std::optional<tasks::NamedBox> box_of(std::size_t thing, ViewpointIndex v) const {
    const capture::ObjectInView* const seen = site_.view_of(thing, v);
    if (seen == nullptr || seen->left >= seen->right) return std::nullopt;
    const auto corner = [](double heading, double elevation) {
      return tasks::Direction{Radians(heading), Radians(elevation)};
    };
    return tasks::NamedBox{std::string(site_.graph().id(v)),
                           site_.home().things[thing].noun,
                           seen->middle,
                           {corner(seen->left, seen->top), corner(seen->right, seen->top),
                            corner(seen->right, seen->bottom), corner(seen->left, seen->bottom)}};
  }

  tasks::NamedBoxes boxes_of(std::size_t thing, std::vector<ViewpointIndex>& ends) const {
    tasks::NamedBoxes goal;
    for (std::size_t i = 0; i < site_.graph().size(); ++i) {
      const ViewpointIndex v(i);
      if (auto box = box_of(thing, v)) {
        goal.boxes.push_back(std::move(*box));
        ends.push_back(v);
      }
    }
    return goal;
  }

  // Fills in instructions and details. False if other things fit the words.
  bool describe(std::size_t thing, tasks::PathAnnotation& entry) {
    for (std::size_t tries = 0; tries < 12 && entry.instructions.size() < kDescriptions; ++tries) {
      const RoomWords room = site_.room_words(site_.home().things[thing].room, rng_);
      const auto words = site_.thing_words(thing, room.fits, rng_);
      if (!words) continue;
      const std::string what = name_of(*words), look = look_of(thing), near = relation_of(thing),
                        where = region_of(thing, room);
      std::string whole = what + look + near + where;
      whole.pop_back();  // the last blank
      if (std::ranges::count(entry.instructions, whole) > 0) continue;
      entry.instructions.push_back(std::move(whole));
      entry.details.emplace_back().fields = {
          {"obj_name", what}, {"attribute", look}, {"relation", near}, {"region", where}};
    }
    return entry.instructions.size() == kDescriptions;
  }

  std::string said(std::string_view pattern, const instructions::Slots& slots) {
    return instructions::sentence(instructions::expand(pattern, slots, rng_)) + " ";
  }

  std::string name_of(const std::string& words) {
    return said(
        "find the $thing|I want to find the $thing|look for the $thing|"
        "this is the $thing",
        {{"thing", words}});
  }

  std::string look_of(std::size_t thing) {
    const HomeThing& t = site_.home().things[thing];
    const Vec3d size = t.high - t.low;
    const auto centimetres = static_cast<int>(10 * std::lround(size.z * 10));
    if (!t.colour.empty() && !t.material.empty() && rng_.below(2) == 0) {
      return said("it is $colour and $material", {{"colour", t.colour}, {"material", t.material}});
    }
    if (!t.colour.empty()) return said("[it is|its colour is] $colour", {{"colour", t.colour}});
    if (centimetres >= 10) {
      return said("it is about $n centimetres high", {{"n", fmt::to_string(centimetres)}});
    }
    return said("it is flat", {});
  }

  // The nearest thing in the room that has words of its own.
  std::string relation_of(std::size_t thing) {
    const std::vector<HomeThing>& things = site_.home().things;
    const std::vector<std::size_t> room = site_.things_in(std::vector{things[thing].room});
    double least = kNear;
    std::optional<std::string> name;
    for (const std::size_t other : room) {
      const double gap = gap_between(things[thing], things[other]);
      if (other == thing || gap >= least || instructions::weight_of(site_.home(), other) < 0.4)
        continue;
      auto words = site_.naming().thing_among(other, room, instructions::Detail::kPlain, rng_);
      if (!words) continue;
      least = gap;
      name = std::move(words);
    }
    if (!name) return said("[there is nothing|nothing much is] [near|close to] it", {});
    return said("it is [near|close to|next to|beside] the $other", {{"other", *name}});
  }

  std::string region_of(std::size_t thing, const RoomWords& room) {
    std::string text = said("it is in $room", {{"room", room.text}});
    const auto next = neighbour_of(site_.home().things[thing].room);
    if (next && rng_.below(2) == 0) {
      text += said("a door leads [from there|] to the $room",
                   {{"room", site_.naming().room(*next, rng_)}});
    }
    return text;
  }

  // A room behind a door.
  std::optional<std::size_t> neighbour_of(std::size_t room) {
    std::vector<std::size_t> found;
    for (const Opening& o : site_.home().plan.openings) {
      if (o.kind != OpeningKind::kDoor || !o.room1) continue;
      if (o.room0 == room) found.push_back(*o.room1);
      if (*o.room1 == room) found.push_back(o.room0);
    }
    if (found.empty()) return std::nullopt;
    return found[rng_.below(found.size())];
  }

  std::vector<tasks::PathAnnotation> paths_to(const std::vector<ViewpointIndex>& ends,
                                              tasks::PathAnnotation shared) {
    shared.scan = path_.scan;
    shared.heading = kStartHeading;
    shared.group = path_.path_id;
    std::vector<tasks::PathAnnotation> paths{shared};
    paths[0].path = path_.path;
    std::vector<ViewpointIndex> starts = starts_for(ends);
    for (const ViewpointIndex start : starts) {
      if (paths.size() == kStarts) break;
      paths.push_back(shared);
      paths.back().path = site_.ids(site_.graph().path(start, nearest(start, ends)).value());
    }
    return paths;
  }

  ViewpointIndex nearest(ViewpointIndex from, const std::vector<ViewpointIndex>& ends) const {
    return *std::ranges::min_element(
        ends, {}, [&](ViewpointIndex v) { return site_.graph().distance(from, v); });
  }

  // Viewpoints that are far from all ends, in random order.
  std::vector<ViewpointIndex> starts_for(const std::vector<ViewpointIndex>& ends) {
    std::vector<ViewpointIndex> starts;
    const graph::NavGraph& graph = site_.graph();
    const ViewpointIndex own = graph.find(path_.path.front()).value();
    for (std::size_t i = 0; i < graph.size(); ++i) {
      const ViewpointIndex v(i);
      const double far = graph.distance(v, nearest(v, ends));
      if (v == own || !graph.included(v) || far < kFarStart || !std::isfinite(far)) continue;
      starts.push_back(v);
    }
    rng_.shuffle(std::span(starts));
    return starts;
  }

  const DescribedHome& site_;
  const tasks::PathAnnotation& path_;
  Rng rng_;
};

}  // namespace

std::vector<tasks::PathAnnotation> write_descriptions(const DescribedHome& site,
                                                      const tasks::PathAnnotation& path,
                                                      std::uint64_t seed) {
  return Describer(site, path, seed).entry();
}

namespace {

constexpr std::size_t kObjects = 2, kRequests = 3;

// What is done with things of a category.
std::string_view verbs_for(std::uint16_t category) {
  using enum mesh::Mpcat40::Category;
  static const std::vector<std::pair<std::vector<std::uint16_t>, std::string_view>> kVerbs{
      {{kPicture, kMirror}, "straighten|dust|look at|take a look at"},
      {{kCushion}, "fluff up|pick up|bring me"},
      {{kPlant}, "water|look after"},
      {{kSofa, kChair, kStool, kSeating}, "sit down on|clean|wipe down"},
      {{kBed}, "make|tidy up"},
      {{kTable, kCounter, kCabinet, kChestOfDrawers, kShelving, kFurniture},
       "wipe|dust|clean|tidy up"},
      {{kSink, kToilet, kBathtub, kShower}, "scrub|clean|rinse"},
      {{kTvMonitor, kLighting, kAppliances}, "turn on|switch off|check"},
      {{kCurtain, kBlinds}, "open|close"},
      {{kTowel, kClothes}, "fold|bring me|pick up"}};
  for (const auto& [categories, verbs] : kVerbs) {
    if (std::ranges::count(categories, category) > 0) return verbs;
  }
  return "find|look for|inspect|dust";
}

constexpr std::string_view kPattern =
    "[go|walk|head|make your way|proceed] to $room and $verb the $thing|"
    "2*$verb the $thing in $room|"
    "in $room, $verb the $thing|"
    "[enter|find] $room, [then|and] $verb the $thing|"
    "please $verb the $thing that is in $room";

// Requests for a thing; empty if it has no words of its own.
std::vector<std::string> requests_for(const DescribedHome& site, std::size_t thing, Rng& rng) {
  const std::uint16_t category =
      site.home().mesh.objects[site.home().things[thing].object].category;
  std::vector<std::string> requests;
  for (std::size_t tries = 0; tries < 12 && requests.size() < kRequests; ++tries) {
    const RoomWords room = site.room_words(site.home().things[thing].room, rng);
    const auto words = site.thing_words(thing, room.fits, rng);
    if (!words) continue;
    const std::string verb = instructions::expand(verbs_for(category), {}, rng);
    const std::string text = instructions::sentence(instructions::expand(
        kPattern, {{"room", room.text}, {"verb", verb}, {"thing", *words}}, rng));
    if (std::ranges::count(requests, text) == 0) requests.push_back(text);
  }
  if (requests.size() < kRequests) requests.clear();
  return requests;
}

}  // namespace

std::vector<tasks::PathAnnotation> write_requests(const DescribedHome& site,
                                                  const tasks::PathAnnotation& path,
                                                  std::uint64_t seed) {
  Rng rng = rng_for(seed, path, "requests");
  const ViewpointIndex end = site.graph().find(path.path.back()).value();
  std::vector<std::size_t> things = site.things_at(end);
  rng.shuffle(std::span(things));
  std::vector<tasks::PathAnnotation> entries;
  for (const std::size_t thing : things) {
    if (entries.size() == kObjects) break;
    std::vector<std::string> requests = requests_for(site, thing, rng);
    if (requests.empty()) continue;
    tasks::PathAnnotation& entry = entries.emplace_back();
    const std::int64_t object = site.home().things[thing].object;
    entry.path_id = path.path_id;
    entry.id = fmt::format("{}_{}", path.path_id, object);
    entry.scan = path.scan;
    entry.heading = path.heading;
    entry.path = path.path;
    entry.instructions = std::move(requests);
    entry.goal = tasks::NamedObject{object};
    entry.group = path.path_id;
  }
  return entries;
}

}  // namespace enfilade::homes::benchmarks
