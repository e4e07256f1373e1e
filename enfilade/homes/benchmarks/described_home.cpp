#include "enfilade/homes/benchmarks/described_home.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::homes::benchmarks {
namespace {

// Rays around the horizon: boxes are exact to 6 pixels in the middle of a view. With more, sets
// without pictures would take more than twice the time that they take without boxes.
constexpr std::uint32_t kRays = 240;
// Below this share of interest (instructions::weight_of) nobody asks for a thing.
constexpr double kLeastWeight = 0.4;

// "on the second floor": floors are counted from the first.
std::string floor_words(const Plan& plan, unsigned storey, Rng& rng) {
  constexpr std::array<const char*, 3> kNames{"first", "second", "third"};
  const std::size_t ways = plan.storeys.size() == 2 ? 3 : 2;
  switch (rng.below(ways)) {
    case 0:
      return fmt::format("on the {} floor", kNames.at(storey));
    case 1:
      return fmt::format("on level {}", storey + 1);
    default:
      return storey == 0 ? "on the lower floor" : "on the upper floor";
  }
}

}  // namespace

DescribedHome::DescribedHome(const BuiltHome& built, const graph::NavGraph& graph,
                             const instructions::ThingsInView& sights, int threads)
    : spoken_{built.home, graph, sights},
      naming_(spoken_),
      around_(graph.size()),
      in_room_(built.home.plan.rooms.size()),
      thing_of_(built.home.mesh.objects.size()) {
  capture::ObjectBoxOptions options;
  options.around = kRays;
  parallel_for(graph.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ViewpointIndex v(i);
      if (!graph.included(v)) continue;
      around_[i] = capture::objects_in_view(*built.tracer, graph.position(v), options);
      std::erase_if(around_[i], [](const auto& seen) { return seen.views.empty(); });
    }
  });
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const auto room = sights.room(ViewpointIndex(i));
    if (room) in_room_[*room].emplace_back(i);
  }
  for (std::size_t i = 0; i < home().things.size(); ++i) {
    const std::uint32_t object = home().things[i].object;
    if (object < thing_of_.size()) thing_of_[object] = i;
  }
}

void DescribedHome::add_boxes(tasks::ObjectBoxes& boxes) const {
  for (std::size_t i = 0; i < graph().size(); ++i) {
    const ViewpointIndex v(i);
    if (!graph().included(v)) continue;
    std::vector<tasks::ViewedObject> objects;
    for (const capture::ObjectInView& seen : around_[i]) {
      objects.push_back(
          {seen.object, home().mesh.objects[seen.object].name, seen.views, seen.boxes});
    }
    boxes.add(graph().scan(), std::string(graph().id(v)), std::move(objects));
  }
}

std::vector<std::size_t> DescribedHome::things_at(ViewpointIndex v) const {
  std::vector<std::size_t> things;
  const auto here = room(v);
  for (const capture::ObjectInView& seen : around(v)) {
    const auto thing = thing_of_[seen.object];
    if (!thing || !here || home().things[*thing].room != *here) continue;
    if (instructions::weight_of(home(), *thing) >= kLeastWeight) things.push_back(*thing);
  }
  return things;
}

const capture::ObjectInView* DescribedHome::view_of(std::size_t thing, ViewpointIndex v) const {
  const auto found = std::ranges::find(around_[v.at()], home().things[thing].object,
                                       &capture::ObjectInView::object);
  return found == around_[v.at()].end() ? nullptr : &*found;
}

RoomWords DescribedHome::room_words(std::size_t room, Rng& rng) const {
  const Plan& plan = home().plan;
  RoomWords words{"the " + naming_.room(room, rng), {}};
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    if (naming_.same_room_name(i, room)) words.fits.push_back(i);
  }
  const auto mark = words.fits.size() > 1 ? naming_.mark_of(room, rng) : std::nullopt;
  if (mark) {
    words.text += " with the " + *mark;
    words.fits = {room};
  }
  if (plan.storeys.size() > 1 && (words.fits.size() > 1 || rng.below(2) == 0)) {
    words.text += " " + floor_words(plan, plan.rooms[room].storey, rng);
    std::erase_if(words.fits,
                  [&](std::size_t i) { return plan.rooms[i].storey != plan.rooms[room].storey; });
  }
  return words;
}

std::vector<std::size_t> DescribedHome::things_in(std::span<const std::size_t> rooms) const {
  std::vector<std::size_t> things;
  for (std::size_t i = 0; i < home().things.size(); ++i) {
    if (std::ranges::count(rooms, home().things[i].room) > 0) things.push_back(i);
  }
  return things;
}

std::optional<std::string> DescribedHome::thing_words(std::size_t thing,
                                                      std::span<const std::size_t> rooms,
                                                      Rng& rng) const {
  return naming_.thing_among(thing, things_in(rooms), instructions::Detail::kPlain, rng);
}

std::vector<ViewpointIndex> DescribedHome::look_up(const std::vector<std::string>& ids) const {
  std::vector<ViewpointIndex> viewpoints;
  for (const std::string& id : ids) viewpoints.push_back(graph().find(id).value());
  return viewpoints;
}

std::vector<std::string> DescribedHome::ids(std::span<const ViewpointIndex> path) const {
  std::vector<std::string> ids;
  for (const ViewpointIndex v : path) ids.emplace_back(graph().id(v));
  return ids;
}

double DescribedHome::heading(ViewpointIndex from, ViewpointIndex to) const {
  const Vec3d step = to_double(graph().position(to)) - to_double(graph().position(from));
  return wrap_heading(Radians(std::atan2(step.x, step.y))).value;
}

Rng rng_for(std::uint64_t seed, const tasks::PathAnnotation& path, const char* purpose) {
  return Rng(seed, stream_of(purpose, std::strlen(purpose)),
             static_cast<std::uint64_t>(path.path_id));
}

tasks::PathAnnotation last_sentences(tasks::PathAnnotation path) {
  for (std::string& text : path.instructions) {
    const std::size_t stop = text.rfind(". ");  // the text itself ends with a full stop
    if (stop != std::string::npos) text.erase(0, stop + 2);
  }
  return path;
}

tasks::PathAnnotation there_and_back(tasks::PathAnnotation path) {
  constexpr std::array<const char*, 3> kBack{" Then return to the place where you started.",
                                             " Afterwards go back to the start the way you came.",
                                             " After that, walk back to where you began."};
  for (std::size_t k = 0; k < path.instructions.size(); ++k) {
    path.instructions[k] += kBack.at((k + static_cast<std::size_t>(path.path_id)) % kBack.size());
  }
  if (path.path.empty()) return path;
  path.goal = tasks::NamedTurningPoint{path.path.back()};
  for (std::size_t i = path.path.size() - 1; i > 0; --i) path.path.push_back(path.path[i - 1]);
  if (path.distance) *path.distance *= 2;
  return path;
}

tasks::PathAnnotation in_pieces(tasks::PathAnnotation path,
                                const std::vector<std::vector<instructions::SpokenPart>>& spoken) {
  path.details.clear();
  for (const std::vector<instructions::SpokenPart>& instruction : spoken) {
    tasks::InstructionDetails& details = path.details.emplace_back();
    for (const instructions::SpokenPart& part : instruction) {
      details.parts.push_back({tasks::tokenize(part.text), std::pair(part.first, part.last)});
    }
  }
  return path;
}

}  // namespace enfilade::homes::benchmarks
