/// \file  One episode, stepped through text and images by a model, program or person. Anything that
/// would give the goal away stays inside.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "enfilade/core/enum_names.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/results.h"

namespace enfilade::arena {

/// The tools. Each has one argument at most. Each observation lists all values of the argument, so
/// that nothing has to be parsed and no agent stops by mistake.
enum class Tool : std::uint8_t {
  kGoTo,      ///< place: one that can be reached in one step
  kBackTo,    ///< place: one that was visited before; along known ways
  kLook,      ///< direction: turns without a step
  kMove,      ///< actions, in continuous environments: one to four of them, in order
  kTurnBack,  ///< R2R-Back: marks the turning point; the last call counts
  kAnswer,    ///< object, of REVERIE: names it and stops
  kStop,
};
constexpr std::array<std::string_view, 7> names_of(Tool /*enum*/) {
  return {"go_to", "back_to", "look", "move", "turn_back", "answer", "stop"};
}
inline std::string_view name_of(Tool tool) noexcept { return enum_name(tool); }

/// A tool as it can be used now.
struct ToolUse {
  Tool tool = Tool::kStop;
  std::string_view argument;         ///< its name: "place"; empty: it has none
  std::vector<std::string> allowed;  ///< its values. For kMove: those of each part.
  bool list = false;                 ///< 1 to kMostMoves values
};
/// Most actions per call of kMove.
inline constexpr std::size_t kMostMoves = 4;

/// A tool call parsed from an answer.
struct Call {
  std::string tool;
  std::string argument;  ///< for a list its values with commas between; empty: none
  friend bool operator==(const Call&, const Call&) = default;
};

/// A neighbour of the current viewpoint. Angles relative to the current view.
struct Neighbour {
  std::string name;          ///< "A", ..., "Z", "AA", ...: in the order of first sight, to the end
  Radians turn;              ///< to the right positive, [-pi, pi)
  Radians elevation;         ///< from the horizon, up positive
  double distance = 0;       ///< in a straight line, metres
  bool visited = false;      ///< stood there before
  bool seen_before = false;  ///< from another place, or at an earlier visit of this one
  std::string what = {};     ///< the view in its direction, in words; empty: unknown
};

/// Something that may be named where one stands.
struct VisibleObject {
  std::string name;         ///< "1", "2", ...: at this place
  std::string category;     ///< "plant"
  Radians turn, elevation;  ///< of the middle of its box in the first view that has it
};

/// A visited place, and the places that were seen from it. \see SessionObservation::map
struct MappedPlace {
  std::string name;
  std::vector<std::string> leads_to;
};

/// The observation at a step. Angles in radians, lengths in metres.
struct SessionObservation {
  std::string instruction;
  std::uint32_t step = 0;             ///< accepted calls
  Radians heading;                    ///< clockwise from the building's +y, [0, 2 pi)
  Radians elevation;                  ///< of the view, up positive
  std::string what;                   ///< the view ahead in words (continuous); empty: unknown
  std::string here;                   ///< the name of the place; empty in continuous space
  std::vector<Neighbour> places;      ///< in the order of their turns, from left to right
  std::vector<VisibleObject> things;  ///< REVERIE only
  std::vector<MappedPlace> map;       ///< in the order of first visits
  std::string told;                   ///< feedback on the last call, a sentence; empty at the start
  std::vector<ToolUse> tools;         ///< possible calls; none after the end
};

/// When a session ends on its own.
struct SessionLimits {
  std::uint32_t steps = 30;     ///< accepted calls, >= 1
  std::uint32_t mistakes = 10;  ///< calls that were not, one after another, >= 1
};

/// \throws ArgumentError naming the field
void validate(const SessionLimits& limits);

/// How it ended.
enum class Ending : std::uint8_t {
  kStopped,     ///< stop or answer
  kOutOfSteps,  ///< SessionLimits::steps, or the benchmark's actions in continuous space
  kMistakes,    ///< SessionLimits::mistakes
  kRefused,     ///< break_off(): the model or its server gives no answer
};
constexpr std::array<std::string_view, 4> names_of(Ending /*enum*/) {
  return {"stopped", "out-of-steps", "mistakes", "refused"};
}
inline std::string_view name_of(Ending ending) noexcept { return enum_name(ending); }

/// The trajectory, in the form of results files.
using Walked = std::variant<tasks::Trajectory, tasks::ContinuousResult>;

/// Position and direction of a session, for rendering its view.
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
  const SessionObservation& observation() const noexcept { return seen_; }
  /// Performs a call. An impossible or unknown one counts as a mistake. It changes nothing except
  /// SessionObservation::told, which lists the possible calls.
  /// \returns whether it was accepted; false also after the end
  bool call(const Call& call);
  /// The last accepted call, in the words of observation().tools whatever the caller's were.
  const Call& last_call() const noexcept { return last_call_; }
  /// An answer from which no call could be read: a mistake. \param why a sentence for its author
  void misread(std::string_view why);
  /// Ends the session where it is, without a stop: no more calls can be had for it. Also one that
  /// SessionLimits::mistakes ended.
  void break_off();

  std::optional<Ending> ending() const noexcept { return ending_; }  ///< no value: it goes on
  std::uint32_t mistakes() const noexcept { return mistakes_; }      ///< in all
  virtual Walked walked() const = 0;
  virtual std::size_t episode() const = 0;  ///< index into its world's episodes
  /// The instruction's or episode's id, as results files have it.
  virtual std::string episode_id() const = 0;
  virtual Standpoint standpoint() const = 0;

 protected:
  explicit Session(const SessionLimits& limits) : limits_(limits) {}
  /// Performs a call that observation().tools allow, and reports its result.
  virtual void carry_out(Tool tool, const std::vector<std::string>& values) = 0;
  /// Fills places, tools, ... from the current position. `told` is kept.
  virtual void look_around(SessionObservation& seen) = 0;
  void begin() { look_around(seen_); }
  void tell(std::string text) { seen_.told = std::move(text); }
  void end(Ending ending);

 private:
  void refuse(std::string_view why);

  SessionLimits limits_;
  SessionObservation seen_;
  Call last_call_;
  std::optional<Ending> ending_;
  std::uint32_t mistakes_ = 0, in_a_row_ = 0;
};

/// Location and direction of a session on a graph.
struct GraphPose {
  graph::Location location;
  Radians heading, elevation;
};

/// A session on a graph. `walked()` is a tasks::Trajectory.
class GraphSession : public Session {
 public:
  virtual GraphPose pose() const = 0;
  /// The viewpoint or object of a name, for oracles and maps.
  /// \pre the place was seen; the object is one of SessionObservation::things
  virtual ViewpointIndex viewpoint_of(std::string_view place) const = 0;
  virtual std::int64_t object_of(std::string_view thing) const = 0;

 protected:
  using Session::Session;
};

}  // namespace enfilade::arena
