/// \file  Sessions: one episode, walked step by step by whoever reads texts and looks at pictures:
/// a language model, a program, a person. Everything that the goal would tell stays inside.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "enfilade/continuous/pose.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/results.h"

namespace enfilade::arena {

/// What can be done. Each has one argument at most, and all values that the argument may have are
/// listed with each observation, so that nothing has to be parsed and nobody stops by mistake.
enum class Tool : std::uint8_t {
  kGoTo,      ///< place: one that can be reached in one step
  kBackTo,    ///< place: one that was visited before; along known ways
  kLook,      ///< direction: turns without a step
  kMove,      ///< actions, in continuous space: one to four of them, in order
  kTurnBack,  ///< of R2R-Back: says that the way back begins here; the last time counts
  kAnswer,    ///< object, of REVERIE: names it and stops
  kStop,
};
constexpr std::array<std::string_view, 7> names_of(Tool /*enum*/) {
  return {"go_to", "back_to", "look", "move", "turn_back", "answer", "stop"};
}
std::string_view name_of(Tool tool) noexcept;

/// A tool as it can be used now.
struct ToolUse {
  Tool tool = Tool::kStop;
  std::string_view argument;         ///< its name: "place"; empty: it has none
  std::vector<std::string> allowed;  ///< its values. Of kMove: of each part
  bool list = false;                 ///< 1 to kMostMoves values
};
/// Of kMove: actions a call.
inline constexpr std::size_t kMostMoves = 4;

/// What is asked for, as it was read from somebody.
struct Call {
  std::string tool;
  std::string argument;  ///< of a list: its values with commas between; empty: none
  friend bool operator==(const Call&, const Call&) = default;
};

/// A neighbour of the place where one stands. Angles as one looks now.
struct Place {
  std::string name;          ///< "A", ..., "Z", "AA", ...: in the order of first sight, to the end
  Radians turn;              ///< to the right positive, [-pi, pi)
  Radians elevation;         ///< from the horizon, up positive
  double distance = 0;       ///< in a straight line, metres
  bool visited = false;      ///< stood there before
  bool seen_before = false;  ///< from another place, or at an earlier visit of this one
  std::string what = {};     ///< what one sees in its direction, in words; empty: not known
};

/// Something that may be named where one stands.
struct Thing {
  std::string name;         ///< "1", "2", ...: at this place
  std::string category;     ///< "plant"
  Radians turn, elevation;  ///< of the middle of its box in the first view that has it
};

/// A visited place, and the places that were seen from it. \see Observation::map
struct MappedPlace {
  std::string name;
  std::vector<std::string> leads_to;
};

/// What is known at a step. Angles in radians, lengths in metres.
struct Observation {
  std::string instruction;
  std::uint32_t step = 0;        ///< calls that were carried out
  Radians heading;               ///< clockwise from the building's +y, [0, 2 pi)
  Radians elevation;             ///< of the look, up positive
  std::string what;              ///< what is ahead, in words, in continuous space; empty: not known
  std::string here;              ///< the name of the place; empty in continuous space
  std::vector<Place> places;     ///< in the order of their turns, from left to right
  std::vector<Thing> things;     ///< of REVERIE
  std::vector<MappedPlace> map;  ///< in the order of first visits
  std::string told;              ///< what came of the last call, a sentence; empty at the start
  std::vector<ToolUse> tools;    ///< what can be done; none when it is over
};

/// When a session ends on its own.
struct Limits {
  std::uint32_t steps = 30;     ///< calls that were carried out, >= 1
  std::uint32_t mistakes = 10;  ///< calls that were not, one after another, >= 1
};

/// \throws ArgumentError naming the field
void validate(const Limits& limits);

/// How it ended.
enum class Ending : std::uint8_t {
  kStopped,     ///< stop or answer
  kOutOfSteps,  ///< Limits::steps, or the benchmark's actions in continuous space
  kMistakes,    ///< Limits::mistakes
};
constexpr std::array<std::string_view, 3> names_of(Ending /*enum*/) {
  return {"stopped", "out-of-steps", "mistakes"};
}
std::string_view name_of(Ending ending) noexcept;

/// What was walked, as results files have it.
using Walked = std::variant<tasks::Trajectory, tasks::ContinuousResult>;

/// Where somebody stands and looks, for those who draw what is seen from there.
struct Standpoint {
  std::string scan;
  /// Names the place in it, equally on all machines that have the same data set: a viewpoint's id,
  /// or "x/y/z" of the eye in metres.
  std::string place;
  /// On graphs the location; in continuous space the eye, metres, world frame.
  std::variant<graph::Location, Vec3d> eye;
  Radians heading, elevation;
};

/// One episode; World::start() begins it. One thread at a time.
///
///     const auto session = world.start(episode);
///     while (!session->ending()) session->call({"go_to", session->observation().places[0].name});
///
/// Same episode and calls give the same observations, to the bit.
class Session {
 public:
  virtual ~Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Valid until the next call().
  const Observation& observation() const noexcept { return seen_; }
  /// Carries out a call. One that is impossible or that nobody understands changes nothing but
  /// Observation::told, which says what would be possible, and counts as a mistake.
  /// \returns whether it was carried out; false also when it is over
  bool call(const Call& call);
  /// An answer from which no call could be read: a mistake. \param why a sentence for its author
  void misread(std::string_view why);

  std::optional<Ending> ending() const noexcept { return ending_; }  ///< no value: it goes on
  std::uint32_t mistakes() const noexcept { return mistakes_; }      ///< in all
  virtual Walked walked() const = 0;
  virtual std::size_t episode() const = 0;  ///< index into its world's episodes
  /// The instruction's or episode's id, as results files have it.
  virtual std::string episode_id() const = 0;
  virtual Standpoint standpoint() const = 0;

 protected:
  explicit Session(const Limits& limits) : limits_(limits) {}
  /// Carries out a call that observation().tools allow, and tells what came of it.
  virtual void carry_out(Tool tool, const std::vector<std::string>& values) = 0;
  /// Fills places, tools, ... from where one stands. `told` is kept.
  virtual void look_around(Observation& seen) = 0;
  void begin() { look_around(seen_); }
  void tell(std::string text) { seen_.told = std::move(text); }
  void end(Ending ending);

 private:
  void refuse(std::string_view why);

  Limits limits_;
  Observation seen_;
  std::optional<Ending> ending_;
  std::uint32_t mistakes_ = 0, in_a_row_ = 0;
};

/// Where a session on a graph stands and looks.
struct GraphPose {
  graph::Location location;
  Radians heading, elevation;
};

/// A session on a graph. `walked()` is a tasks::Trajectory.
class GraphSession : public Session {
 public:
  virtual GraphPose pose() const = 0;
  /// For oracles and for those who draw maps: what a name stands for. \pre the place was seen; the
  /// object is one of Observation::things
  virtual ViewpointIndex viewpoint_of(std::string_view place) const = 0;
  virtual std::int64_t object_of(std::string_view thing) const = 0;

 protected:
  using Session::Session;
};

/// A session in continuous space. `walked()` is a tasks::ContinuousResult.
class ContinuousSession : public Session {
 public:
  virtual continuous::Pose pose() const = 0;

 protected:
  using Session::Session;
};

}  // namespace enfilade::arena
