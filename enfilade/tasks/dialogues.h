/// \file  Whole dialogues of CVDN: a navigator who searches for an object in a building, an oracle
/// who sees the shortest path. CVDN's task from dialogue history (Task::kCvdn) was cut from them.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks {

/// A dialogue's record of one of its two people. All may be absent.
struct DialoguePerson {
  std::optional<std::int64_t> id;         ///< `navigator`, `oracle`: the same in all dialogues
  std::string worker;                     ///< `navigator_mturk`, `oracle_mturk`
  std::optional<double> quality;          ///< given by the other one in this dialogue, 1 to 5
  std::optional<double> average_quality;  ///< over all of the person's dialogues
  friend bool operator==(const DialoguePerson&, const DialoguePerson&) = default;
};

/// A dialogue, from the start to the goal.
struct Dialogue {
  std::int64_t id = 0;  ///< `idx`
  std::string scan;
  std::string target;  ///< the searched object: "plant"
  std::string start;   ///< `start_pano`: a viewpoint
  /// \name Empty in test splits, which hide them
  /// @{
  std::vector<std::string> ends;     ///< `end_panos`: the viewpoints of the goal's region
  std::vector<std::string> steps;    ///< `nav_steps`: where the navigator went, from `start` on
  std::vector<std::string> planned;  ///< `planner_nav_steps`: the shortest path to the region
  std::vector<DialogueTurn> turns;   ///< `nav_step` of each is a place in `steps`
  std::vector<std::size_t>
      stops;  ///< `stop_history`: places where the navigator claimed to be there
  /// @}
  DialoguePerson navigator, oracle;
  std::optional<std::int64_t> problem;  ///< how many people reported technical problems, 0 to 2
  /// `nav_camera` as JSON without blanks, or empty: the navigator's views. Its inner form is not
  /// published, so it is kept unchanged.
  std::string camera;

  bool goal_hidden() const noexcept { return ends.empty(); }
  friend bool operator==(const Dialogue&, const Dialogue&) = default;
};

/// Reads a file of dialogues: a list, or lines, packed (".gz") or not. Fields of other names, such
/// as `R2R_spl`, are ignored. If there is one of `end_panos`, `nav_steps`, `planner_nav_steps`,
/// `dialog_history`, all four are needed.
/// \throws FileError
/// \throws InvalidInput listing its faults (up to 1000) with their JSON paths:
/// - not JSON, missing, repeated or wrongly typed fields
/// - a negative id, a repeated `idx`, an empty region
/// - steps that are empty or do not begin at the start, a turn or stop beyond the steps
/// - a role that is neither "navigator" nor "oracle"
std::vector<Dialogue> load_dialogues(const std::filesystem::path& file);
std::vector<Dialogue> parse_dialogues(std::string_view json, const std::string& file);

/// A list with one dialogue per line; parse_dialogues() reads it back equal.
/// \throws ArgumentError for infinite numbers, text that is not UTF-8, and a `camera` that is not
/// JSON
std::string to_json(const std::vector<Dialogue>& dialogues);

}  // namespace enfilade::tasks
