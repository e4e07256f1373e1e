/// \file  CVDN's navigation from dialogue history (github.com/mmurray/cvdn, tasks/NDH).
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads `train.json`, `val_seen.json`, `val_unseen.json`, `test_cleaned.json`. Each instance
/// becomes a path with one instruction. Its id is `inst_idx`; its text is the turns and the target
/// as HAMT writes them ("<NAV> ... <ORA> ... <TAR> plant"); its details have the turns. The path is
/// the trusted one: `player_path` if the planner's last viewpoint is in player_path[1:], else
/// `planner_path`. It starts at `start_pano`, which is the whole path if the goal is hidden (no
/// `end_panos`). `game_idx` is the group, if there is one. `nav_history`, `nav_camera`, the start's
/// elevation, the qualities and `R2R_*` are ignored.
/// \throws InvalidInput listing its faults with JSON paths:
/// - missing or wrongly typed fields, empty `end_panos` or paths
/// - a negative inst_idx or nav_idx, a repeated inst_idx
/// - a role that is neither navigator nor oracle
/// - a player's or planner's path that starts elsewhere or is there without `end_panos`
Annotations parse_cvdn(std::string_view json, const std::string& file, std::string split);

/// The same for HAMT's `<split>_enc.json`: `instr_id` (a text), `scan, target` (which may be
/// absent), `start_pano` (a bare id), `start_heading, end_panos, nav_steps, nav_idx,
/// instr_encoding`. `nav_steps` is the navigator's whole trajectory; from `nav_idx` on, where
/// `start_pano` is, it is the path and the player's path. The text is empty, and there is no
/// planner's path and no group. The path_id is the number that instr_id is, else that of the
/// record. If the goal is hidden, `nav_steps` and `nav_idx` are ignored.
/// \throws InvalidInput as parse_cvdn(); also for an empty instr_id, a nav_idx beyond nav_steps
Annotations parse_cvdn_encoded(std::string_view json, const std::string& file, std::string split);

/// A list, one instance per line; a result of parse_cvdn() is read back equal. If the first
/// instance has token ids and no text, all are written in HAMT's form. Then `nav_steps` begins at
/// the start, and parse_cvdn_encoded() reads them back equal. The model lacks three fields:
/// `nav_history` and `nav_camera` are empty, the start's elevation is 0.
/// \throws ArgumentError for other annotations than CVDN's, naming the instance; for infinite
/// numbers and text that is not UTF-8
std::string to_cvdn(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
