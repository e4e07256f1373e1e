#include "enfilade/continuous/simulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/threads.h"

namespace enfilade::continuous {

namespace {

constexpr std::size_t kLeastChunk = 64;  // agents that are worth a thread

bool is_finite(const Pose& pose) {
  return std::isfinite(pose.position.x) && std::isfinite(pose.position.y) &&
         std::isfinite(pose.position.z) && std::isfinite(pose.heading.value) &&
         std::isfinite(pose.elevation.value);
}

// wrap_heading() may give 2 pi itself.
double wrapped(double heading) {
  const double turned = wrap_heading(Radians(heading)).value;
  return turned < 2 * kPi ? turned : 0;
}

}  // namespace

SimulatorConfig SimulatorConfig::room_to_room() { return {}; }

SimulatorConfig SimulatorConfig::room_across_room() {
  SimulatorConfig config;
  config.turn = degrees(30);
  config.walls = Walls::kStop;
  config.eye_height = 0.88;
  return config;
}

void validate(const SimulatorConfig& c) {
  if (c.batch_size == 0) throw ArgumentError("batch_size: 0, at least 1");
  check_range("forward", c.forward, 1e-3, 5);
  check_range("turn", c.turn.value, 1e-6, kPi);
  check_range("look", c.look.value, 1e-6, kPi / 2);
  check_range("most_elevation", c.most_elevation.value, 0, kPi / 2);
  check_range("eye_height", c.eye_height, 0, 10);
  check_range("start_reach.aside", static_cast<double>(c.start_reach.aside), 0, 100);
  check_range("start_reach.above_below", static_cast<double>(c.start_reach.above_below), 0, 100);
  if (c.most_steps == 0) throw ArgumentError("most_steps: 0, at least 1");
  if (c.threads < 0) throw ArgumentError(fmt::format("threads: {}, at least 0", c.threads));
}

StartCheck check_start(const Floor& floor, Vec3f position, Reach reach) {
  StartCheck check;
  check.floor = floor.nearest(position, reach);
  if (!check.floor) return check;
  check.off_floor = length(to_double(check.floor->point) - to_double(position));
  check.area_m2 = floor.area_m2(floor.area_of(*check.floor));
  return check;
}

struct Simulator::Impl {
  std::shared_ptr<const Buildings> buildings;
  SimulatorConfig config;
  std::vector<Walker> walkers;  // one for each chunk of agents that a thread steps
  std::vector<std::uint8_t> has_episode;
  std::vector<const Floor*> floors;
  std::vector<FloorPoint> at;

  // Turns are counted, so that twenty-four turns of 15 degrees are none.
  std::vector<double> start_heading;
  std::vector<std::int32_t> turns;

  std::vector<std::uint32_t> building, steps, collisions;
  std::vector<Vec3f> position;
  std::vector<double> heading, elevation;
  std::vector<std::uint8_t> collided;
  std::vector<EpisodeState> episode;
  std::vector<float> off_floor;

  Impl(std::shared_ptr<const Buildings> of, const SimulatorConfig& c)
      : buildings(std::move(of)), config(c) {
    const std::size_t n = c.batch_size;
    const std::size_t threads = static_cast<std::size_t>(threads_or_all(c.threads));
    walkers.resize(std::clamp<std::size_t>(n / kLeastChunk, 1, threads));
    const auto resize = [n](auto&... lists) { (lists.resize(n), ...); };
    resize(building, steps, collisions, heading, elevation, start_heading, has_episode, floors, at,
           turns, position, collided, episode, off_floor);
  }

  // Checks everything, changes nothing.
  FloorPoint find_floor(std::size_t agent, const EpisodeStart& start) const;
  void begin(std::size_t agent, const EpisodeStart& start, const FloorPoint& found);
  void act(std::size_t agent, Action action, Walker& walker);
  void walk(std::size_t agent, Walker& walker);
};

FloorPoint Simulator::Impl::find_floor(std::size_t agent, const EpisodeStart& start) const {
  if (start.building >= buildings->size()) {
    throw ActionError(agent, fmt::format("agent {}: building {}, there are {}", agent,
                                         start.building, buildings->size()));
  }
  const Vec3f p = start.pose.position;
  if (!is_finite(start.pose)) {
    throw ActionError(agent, fmt::format("agent {}: a start at ({}, {}, {}), heading {}, elevation "
                                         "{}: not finite",
                                         agent, p.x, p.y, p.z, start.pose.heading.value,
                                         start.pose.elevation.value));
  }
  const Floor& floor = buildings->floor(start.building);
  if (const auto found = floor.nearest(p, config.start_reach)) return *found;
  const Reach widest = floor.widest_reach();
  const auto far = floor.nearest(p, widest);
  const std::string nearest =
      far ? fmt::format("the nearest is {:.2f} m aside and {:.2f} m {}",
                        std::hypot(far->point.x - p.x, far->point.y - p.y),
                        std::abs(far->point.z - p.z), far->point.z < p.z ? "below" : "above")
          : fmt::format("none within {} m either", widest.aside);
  throw ActionError(
      agent, fmt::format("agent {}: no floor of {} within {} m of its start ({}, {}, {}) and {} m "
                         "above or below; {}",
                         agent, buildings->scan(start.building), config.start_reach.aside, p.x, p.y,
                         p.z, config.start_reach.above_below, nearest));
}

void Simulator::Impl::begin(std::size_t agent, const EpisodeStart& start, const FloorPoint& found) {
  const double most = config.most_elevation.value;
  has_episode[agent] = 1;
  floors[agent] = &buildings->floor(start.building);
  at[agent] = found;
  building[agent] = static_cast<std::uint32_t>(start.building);
  position[agent] = start.pose.position;
  start_heading[agent] = heading[agent] = wrapped(start.pose.heading.value);
  elevation[agent] = std::clamp(start.pose.elevation.value, -most, most);
  turns[agent] = 0;
  steps[agent] = collisions[agent] = 0;
  collided[agent] = 0;
  episode[agent] = EpisodeState::kWalking;
  off_floor[agent] =
      static_cast<float>(length(to_double(found.point) - to_double(start.pose.position)));
}

void Simulator::Impl::walk(std::size_t agent, Walker& walker) {
  const double h = heading[agent];
  const Vec3d by{config.forward * std::sin(h), config.forward * std::cos(h), 0};
  const Walked walked = floors[agent]->move(walker, at[agent], by, config.walls);
  at[agent] = walked.end;
  position[agent] = walked.end.point;
  collided[agent] = walked.at_wall ? 1 : 0;
  collisions[agent] += collided[agent];
}

void Simulator::Impl::act(std::size_t agent, Action action, Walker& walker) {
  if (episode[agent] != EpisodeState::kWalking) return;
  const double most = config.most_elevation.value;
  collided[agent] = 0;
  ++steps[agent];
  switch (action) {
    case Action::kStop:
      episode[agent] = EpisodeState::kStopped;
      return;
    case Action::kForward:
      walk(agent, walker);
      break;
    case Action::kLeft:
    case Action::kRight:
      turns[agent] += action == Action::kRight ? 1 : -1;
      heading[agent] = wrapped(start_heading[agent] + turns[agent] * config.turn.value);
      break;
    case Action::kLookUp:
    case Action::kLookDown:
      elevation[agent] = std::clamp(
          elevation[agent] + (action == Action::kLookUp ? 1 : -1) * config.look.value, -most, most);
      break;
  }
  if (steps[agent] >= config.most_steps) episode[agent] = EpisodeState::kCutShort;
}

Simulator::Simulator(std::shared_ptr<const Buildings> buildings, const SimulatorConfig& config) {
  validate(config);
  if (!buildings) throw ArgumentError("buildings: null");
  impl_ = std::make_unique<Impl>(std::move(buildings), config);
}

Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

const SimulatorConfig& Simulator::config() const noexcept { return impl_->config; }

StateSpans Simulator::state() const noexcept {
  const Impl& s = *impl_;
  return {s.building,   s.position, s.heading, s.elevation, s.steps,
          s.collisions, s.collided, s.episode, s.off_floor};
}

void Simulator::new_episode(std::size_t agent, const EpisodeStart& start) {
  if (agent >= batch_size()) {
    throw ArgumentError(fmt::format("agent: {}, not below {}", agent, batch_size()));
  }
  impl_->begin(agent, start, impl_->find_floor(agent, start));
}

void Simulator::new_episodes(std::span<const EpisodeStart> starts) {
  if (starts.size() != batch_size()) {
    throw ArgumentError(fmt::format("starts: {}, for {} agents", starts.size(), batch_size()));
  }
  std::vector<FloorPoint> found;
  for (std::size_t a = 0; a < starts.size(); ++a) found.push_back(impl_->find_floor(a, starts[a]));
  for (std::size_t a = 0; a < starts.size(); ++a) impl_->begin(a, starts[a], found[a]);
}

void Simulator::step(std::span<const Action> actions) {
  Impl& s = *impl_;
  if (actions.size() != batch_size()) {
    throw ArgumentError(fmt::format("actions: {}, for {} agents", actions.size(), batch_size()));
  }
  for (std::size_t a = 0; a < actions.size(); ++a) {
    if (s.has_episode[a] == 0) {
      throw ArgumentError(fmt::format("agent {}: no episode was started", a));
    }
    if (static_cast<std::size_t>(actions[a]) >= kActions) {
      throw ActionError(a, fmt::format("agent {}: action {}, not below {}", a,
                                       static_cast<int>(actions[a]), kActions));
    }
  }
  const std::size_t chunks = s.walkers.size(), n = actions.size();
  const auto step_chunk = [&](std::size_t chunk) {
    for (std::size_t a = n * chunk / chunks; a < n * (chunk + 1) / chunks; ++a) {
      s.act(a, actions[a], s.walkers[chunk]);
    }
  };
  if (chunks == 1) {
    step_chunk(0);
    return;
  }
  parallel_for(chunks, 1, s.config.threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t chunk = first; chunk < last; ++chunk) step_chunk(chunk);
  });
}

const FloorPoint& Simulator::floor_point(std::size_t agent) const {
  EN_CHECK_LT(agent, batch_size());
  EN_CHECK(impl_->has_episode[agent] != 0);
  return impl_->at[agent];
}

}  // namespace enfilade::continuous
