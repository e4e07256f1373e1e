#include "enfilade/homes/benchmarks/requests.h"

#include <fmt/format.h>
#include <algorithm>

#include "enfilade/homes/instructions/phrases.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::benchmarks {
namespace {

constexpr std::size_t kObjects = 2, kRequests = 3;

// What is done with things of a category.
std::string_view verbs_for(std::uint16_t category) {
  using enum mesh::Mpcat40::Category;
  switch (category) {
    case kPicture:
    case kMirror:
      return "straighten|dust|look at|take a look at";
    case kCushion:
      return "fluff up|pick up|bring me";
    case kPlant:
      return "water|look after";
    case kSofa:
    case kChair:
    case kStool:
    case kSeating:
      return "sit down on|clean|wipe down";
    case kBed:
      return "make|tidy up";
    case kTable:
    case kCounter:
    case kCabinet:
    case kChestOfDrawers:
    case kShelving:
    case kFurniture:
      return "wipe|dust|clean|tidy up";
    case kSink:
    case kToilet:
    case kBathtub:
    case kShower:
      return "scrub|clean|rinse";
    case kTvMonitor:
    case kLighting:
    case kAppliances:
      return "turn on|switch off|check";
    case kCurtain:
    case kBlinds:
      return "open|close";
    case kTowel:
    case kClothes:
      return "fold|bring me|pick up";
    default:
      return "find|look for|inspect|dust";
  }
}

constexpr std::string_view kPattern =
    "[go|walk|head|make your way|proceed] to $room and $verb the $thing|"
    "2*$verb the $thing in $room|"
    "in $room, $verb the $thing|"
    "[enter|find] $room, [then|and] $verb the $thing|"
    "please $verb the $thing that is in $room";

// Requests for a thing; empty if it has no words of its own.
std::vector<std::string> requests_for(const Site& site, std::size_t thing, Rng& rng) {
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

std::vector<tasks::PathAnnotation> write_requests(const Site& site,
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
