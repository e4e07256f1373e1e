/// \file  The batched simulator of continuous environments: VLN-CE's actions (Krantz et al., ECCV
/// 2020) on navigation meshes, our own or Habitat's (Floor).
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "enfilade/continuous/buildings.h"
#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::continuous {

/// World frame. Single precision, as Habitat and VLN-CE's files have positions.
struct Pose {
  Vec3f position;     ///< of the feet: a point of the floor, metres
  Radians heading;    ///< clockwise from +y, [0, 2 pi)
  Radians elevation;  ///< of the camera, up positive
};

/// Actions of a body in one step. The first four have VLN-CE's numbers.
enum class Action : std::uint8_t { kStop, kForward, kLeft, kRight, kLookUp, kLookDown };
/// How many there are.
inline constexpr std::size_t kActions = 6;

/// Everything that a Simulator is made from; nothing can be changed later.
struct SimulatorConfig {
  std::size_t batch_size = 1;            ///< agents, >= 1
  double forward = 0.25;                 ///< metres, as seen from above; (0, 5]
  Radians turn = degrees(15);            ///< (0, pi]
  Radians look = degrees(30);            ///< (0, pi / 2]
  Radians most_elevation = degrees(60);  ///< up and down; looking further changes nothing
  Walls walls = Walls::kSlide;
  double eye_height = 1.25;        ///< metres above the floor; the body's height does not limit it
  std::uint32_t most_steps = 500;  ///< actions; the last one ends the episode whatever it is
  Reach start_reach{0.5F, 0.5F};   ///< how far from its start an agent may be put on the floor
  int threads = 1;                 ///< that step() may use, 0: all cores. Never changes a result

  /// VLN-CE's tasks: steps of 0.25 m, turns of 15 degrees, sliding along walls.
  static SimulatorConfig room_to_room();
  /// RxR-CE's: turns of 30 degrees, looking up and down, no sliding, eyes 0.88 m above the floor.
  static SimulatorConfig room_across_room();
};
/// \throws ArgumentError naming the field, its value and the allowed range
void validate(const SimulatorConfig& config);

/// Bodies of the two benchmarks, which their floors are made for. Radius and height of R2R's are
/// Habitat's defaults; step and slope of both are.
inline constexpr mesh::Body kRoomToRoomBody{.radius = 0.1, .height = 1.5, .step = 0.2, .slope = 45};
inline constexpr mesh::Body kRoomAcrossRoomBody{
    .radius = 0.18, .height = 0.88, .step = 0.2, .slope = 45};

/// Where an agent starts.
struct EpisodeStart {
  std::size_t building = 0;
  Pose pose;
};

/// How an agent's episode stands.
enum class EpisodeState : std::uint8_t {
  kWalking,
  kStopped,   ///< it said stop
  kCutShort,  ///< it had most_steps actions
};

/// The state of a batch: one array a quantity, shape (batch). Valid as long as the simulator.
struct StateSpans {
  std::span<const std::uint32_t> building;
  std::span<const Vec3f> position;            ///< of the feet; exactly the start's until its first
                                              ///< move
  std::span<const double> heading;            ///< radians, [0, 2 pi)
  std::span<const double> elevation;          ///< radians
  std::span<const std::uint32_t> steps;       ///< actions since the start, stop too
  std::span<const std::uint32_t> collisions;  ///< steps forward that a wall cut short
  std::span<const std::uint8_t> collided;     ///< whether the last action was one of them
  std::span<const EpisodeState> episode;
  std::span<const float> off_floor;  ///< metres from the start's position to the floor under it
};

using enfilade::ActionError;

/// Properties of a start, to check it in advance.
struct StartCheck {
  std::optional<FloorPoint> floor;  ///< the nearest point of the floor; no value: none in reach
  double off_floor = 0;             ///< metres to it
  double area_m2 = 0;               ///< of the floor that can be reached from there
};
StartCheck check_start(const Floor& floor, Vec3f position, Reach reach);

/// Walks a batch of bodies through buildings. Needs no picture and no GPU. Same start and actions
/// give the same bytes at any batch size and thread count. step() allocates nothing with one
/// thread. One thread at a time per simulator; any number of simulators share Buildings.
///
///     continuous::Simulator simulator(buildings, SimulatorConfig::room_to_room());
///     simulator.new_episode(0, {.building = buildings->at("home0001"), .pose = pose});
///     simulator.step(std::vector{Action::kForward});
///     simulator.state().position[0];
class Simulator {
 public:
  /// \throws ArgumentError as validate(), or if `buildings` is null
  Simulator(std::shared_ptr<const Buildings> buildings, const SimulatorConfig& config);
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  const SimulatorConfig& config() const noexcept;
  std::size_t batch_size() const noexcept { return config().batch_size; }
  StateSpans state() const noexcept;

  /// Starts an episode for one agent. Until its first move its position is exactly that of `start`.
  /// As VLN-CE's starts, it may be a little above or beside the floor. If it throws, nothing has
  /// changed.
  /// \throws ActionError for an unknown building, a pose that is not finite, or a position without
  /// floor in config().start_reach (with its distance, if known)
  /// \throws errors of the building's file
  void new_episode(std::size_t agent, const EpisodeStart& start);
  /// The same for every agent. \throws ArgumentError if starts.size() != batch_size()
  void new_episodes(std::span<const EpisodeStart> starts);

  /// One action per agent. Agents whose episode has ended do not move. If it throws, nothing has
  /// changed.
  /// \throws ArgumentError if actions.size() != batch_size() or an agent has no episode yet
  /// \throws ActionError for an invalid action
  void step(std::span<const Action> actions);

  /// The point of the floor where an agent stands. \pre it has an episode
  const FloorPoint& floor_point(std::size_t agent) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::continuous
