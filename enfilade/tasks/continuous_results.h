/// \file  Results in continuous environments: VLN-CE's two forms of files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::tasks {

/// The trajectory of one episode, as a simulator recorded it or a file has it: n + 1 poses, n
/// actions between them.
struct ContinuousResult {
  static constexpr std::uint8_t kStop = 0;
  std::size_t episode = 0;       ///< index into ContinuousEpisodes::episodes
  std::vector<Vec3f> positions;  ///< world, metres, (n + 1): the start, then after each action
  /// [0, 2 pi), (n + 1); empty if they are not known, as in RxR's form.
  std::vector<Radians> headings;
  /// (n): 0 stop, 1 forward, 2 left, 3 right, 4 up, 5 down. Files do not have them: a reader infers
  /// them from the poses.
  std::vector<std::uint8_t> actions;
  /// Whether each action ended in a collision, (n); empty if unknown, as in files.
  std::vector<std::uint8_t> collided;

  bool stopped() const noexcept { return !actions.empty() && actions.back() == kStop; }
  friend bool operator==(const ContinuousResult&, const ContinuousResult&) = default;
};

/// \param where  for the message
/// \throws ArgumentError if the sizes of the arrays are not as stated
void check_sizes(const ContinuousResult& walk, std::string_view where);

/// Whose files a benchmark has, and in which form results are written.
enum class ContinuousForm : std::uint8_t {
  /// VLN-CE's challenge on R2R: `{"<episode_id>": [{"position": [x, y, z], "heading": h, "stop":
  /// false}, ...], ...}`, a pose before the first action and after each. The heading is the angle
  /// about Habitat's y axis, -pi to pi: ours with the other sign.
  kR2r,
  /// The RxR-Habitat challenge: lines of `{"instruction_id": "26", "path": [[x, y, z], ...]}`, a
  /// position each time that it changed. They end where the agent stopped, or was stopped.
  kRxr,
};

/// Reads a results file, checked against its split: one trajectory per episode, in the order of the
/// episodes. Either form is recognised and read, packed or not. A trajectory of RxR's form ends
/// with stop.
///
/// The action between two poses is inferred:
/// - stop where `stop` becomes true
/// - else forward where the position changed
/// - else left or right by the heading
/// - else forward against a wall
///
/// \throws FileError
/// \throws InvalidInput listing its faults (up to 1000) with their JSON paths:
/// - not JSON, missing, repeated or wrongly typed fields
/// - an unknown episode or instruction, one answered twice or (Coverage::kAll) not at all
/// - no pose, a position that is not three numbers or beyond 1e6 m, poses after stop
/// - a start that is more than 1 cm off the episode's
std::vector<ContinuousResult> load_continuous_results(const std::filesystem::path& file,
                                                      const ContinuousEpisodes& episodes,
                                                      Coverage coverage = Coverage::kAll);
/// The same of a text. \param file  for messages
std::vector<ContinuousResult> parse_continuous_results(std::string_view text,
                                                       const std::string& file,
                                                       const ContinuousEpisodes& episodes,
                                                       Coverage coverage = Coverage::kAll);

/// The text of a results file.
/// - kR2r: one episode per line. parse_continuous_results() reads it back equal, except `collided`,
///   and except actions up and down, which become steps against a wall.
/// - kRxr: ordered by instruction ids, as the public code does.
///
/// \throws ArgumentError for an unknown episode, or numbers that are not finite
/// \throws ArgumentError for a trajectory whose arrays do not fit together or that goes on after
/// stop
/// \throws ArgumentError (kRxr) for an episode without an instruction id
/// \throws ArgumentError (kR2r) for a trajectory without headings
std::string to_json(std::span<const ContinuousResult> walks, const ContinuousEpisodes& episodes,
                    ContinuousForm form);

}  // namespace enfilade::tasks
