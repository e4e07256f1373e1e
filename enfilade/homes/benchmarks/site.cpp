#include "enfilade/homes/benchmarks/site.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"

namespace enfilade::homes::benchmarks {
namespace {

// Rays around the horizon: boxes are exact to 6 pixels in the middle of a view. With more, sets
// without pictures would take more than twice the time that they take without boxes.
constexpr std::uint32_t kRays = 240;
// Below this share of interest (speaking::weight_of) no object is asked for.
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

Site::Site(const BuiltHome& built, const graph::NavGraph& graph, const speaking::Sights& sights,
           int threads)
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
    if (room) in_room_[*room].push_back(ViewpointIndex(i));
  }
  for (std::size_t i = 0; i < home().things.size(); ++i) {
    const std::uint32_t object = home().things[i].object;
    if (object < thing_of_.size()) thing_of_[object] = i;
  }
}

void Site::add_boxes(tasks::ObjectBoxes& boxes) const {
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

std::vector<std::size_t> Site::things_at(ViewpointIndex v) const {
  std::vector<std::size_t> things;
  const auto here = room(v);
  for (const capture::ObjectInView& seen : around(v)) {
    const auto thing = thing_of_[seen.object];
    if (!thing || !here || home().things[*thing].room != *here) continue;
    if (speaking::weight_of(home(), *thing) >= kLeastWeight) things.push_back(*thing);
  }
  return things;
}

const capture::ObjectInView* Site::view_of(std::size_t thing, ViewpointIndex v) const {
  const auto found = std::ranges::find(around_[v.at()], home().things[thing].object,
                                       &capture::ObjectInView::object);
  return found == around_[v.at()].end() ? nullptr : &*found;
}

RoomWords Site::room_words(std::size_t room, Rng& rng) const {
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

std::vector<std::size_t> Site::things_in(std::span<const std::size_t> rooms) const {
  std::vector<std::size_t> things;
  for (std::size_t i = 0; i < home().things.size(); ++i) {
    if (std::ranges::count(rooms, home().things[i].room) > 0) things.push_back(i);
  }
  return things;
}

std::optional<std::string> Site::thing_words(std::size_t thing, std::span<const std::size_t> rooms,
                                             Rng& rng) const {
  return naming_.thing_among(thing, things_in(rooms), speaking::Detail::kPlain, rng);
}

std::vector<ViewpointIndex> Site::look_up(const std::vector<std::string>& ids) const {
  std::vector<ViewpointIndex> viewpoints;
  for (const std::string& id : ids) viewpoints.push_back(graph().find(id).value());
  return viewpoints;
}

std::vector<std::string> Site::ids(std::span<const ViewpointIndex> path) const {
  std::vector<std::string> ids;
  for (const ViewpointIndex v : path) ids.emplace_back(graph().id(v));
  return ids;
}

double Site::heading(ViewpointIndex from, ViewpointIndex to) const {
  const Vec3d step = to_double(graph().position(to)) - to_double(graph().position(from));
  return wrap_heading(Radians(std::atan2(step.x, step.y))).value;
}

Rng rng_for(std::uint64_t seed, const tasks::PathAnnotation& path, const char* purpose) {
  return Rng(seed, stream_of(purpose, std::strlen(purpose)),
             static_cast<std::uint64_t>(path.path_id));
}

}  // namespace enfilade::homes::benchmarks
