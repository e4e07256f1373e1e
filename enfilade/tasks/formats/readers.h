/// \file  The files of each benchmark on graphs, read and written. tasks/files.h finds the form.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

// R2R's form and its descendants: token ids, lines, R2R-Last, R2R-Back, R4R.

/// Reads `R2R_<split>.json` and files of its form, a list or lines:
/// - with `instr_encodings`: token ids, one list per instruction
/// - with `midstop` (R2R-Back): goals are NamedTurningPoint
/// - R4R's, whose `first_path_id` and so on are ignored
/// - HAMT's for pretraining, one instruction per record (`instr_id, scan, path, heading,
///   instr_encoding`, optional `instruction`): a file whose first record has an `instr_id`
/// - PREVALENT's and ScaleVLN's, whose path ids are texts ("00000-kfPV7w3FaU5_12"). That text is a
///   path's id; its path_id is the number of the first record with it.
///
/// A record of HAMT's form becomes a path of its own, with the path_id of its id ("4332_0") as its
/// group; without `heading` it is 0.
/// \param task  R2R-Back needs `midstop` in each entry with more than one viewpoint; if an entry
/// has just one and no `midstop`, the goal is hidden
/// \throws InvalidInput listing its faults with JSON paths: as parse_annotations(), and
/// - another number of `instr_encodings` than of instructions
/// - `midstop` in another task's file
/// - an `instr_id` that is repeated, or that is not `<path_id>_<k>`
Annotations parse_r2r_family(std::string_view text, const std::string& file, std::string split,
                             Task task);

/// R2R's form with all tokens, parts and turning points of the details. It is read back equal by
/// parse_fine_grained() if instructions have parts, else by parse_r2r_family(). Lines, if each path
/// has one instruction with an id and without a text, as HAMT's have; else a list, one entry per
/// line.
/// \throws ArgumentError as to_json(), and for an instruction in which only some parts have
/// positions
std::string to_r2r_family(const Annotations& annotations);

// Fine-grained R2R: which piece of an instruction describes which piece of its path.

/// Reads fine-grained R2R (github.com/YicongHong/Fine-Grained-R2R): R2R's entries with two more
/// fields. `new_instructions` is a text that holds a Python literal: lists of lists of words, by
/// instruction and sub-instruction. `chunk_view` has `[first, last]` by sub-instruction, 1-based
/// positions on the path; test splits have none. They become the parts of the instructions'
/// details. The literal may have fewer lists than there are instructions (path 757 of val seen
/// does): then the last ones have no parts. `instr_encodings` become tokens. A list, or lines.
/// \throws InvalidInput listing its faults with JSON paths: as parse_r2r_family(), and
/// - a literal that is not of that form, or with more lists than instructions
/// - another number of chunks than of sub-instructions
/// - a position beyond the path, a last one before the first
Annotations parse_fine_grained(std::string_view json, const std::string& file, std::string split);

// REVERIE's annotations: `REVERIE_<split>.json`, versions 1 and 2. The boxes of objects in
// views are read by objects.h.

/// Reads a file of annotations: a list, or lines. Goals are NamedObject; a path of R2R with several
/// objects is a group. An entry without `objId`, as in the test split, has a hidden goal. Its `id`
/// is the path's number, and its path only the start. An entry with an `objId` may have a number as
/// its `id`, too: goals of a test split, whose ids must not give them away. Other fields are
/// ignored, such as `distance`, `ix` and `instructions_l` of version 1. The field `instr_encodings`
/// becomes tokens.
/// \throws InvalidInput listing its faults with JSON paths:
/// - missing or wrongly typed fields, an empty path, a negative id
/// - an `id` that is repeated, or that is neither `<path_id>_<objId>` nor a number
/// - more than the start of a path whose goal is hidden
/// - another number of `instr_encodings` than of instructions
Annotations parse_reverie(std::string_view json, const std::string& file, std::string split);

/// A list, one entry per line: a result of parse_reverie() is read back equal. Lengths of paths are
/// left out, as in version 2.
/// \throws ArgumentError for other annotations than REVERIE's, naming the entry; for infinite
/// numbers and text that is not UTF-8
std::string to_reverie(const Annotations& annotations);

// Instructions to find objects, an instruction a record, as HM3DAutoVLN's files have them
// (github.com/cshizhe/HM3DAutoVLN): REVERIE's task in other buildings.

/// Reads records of `instr_id, scan, path, pos_vps, objid` and, optionally, `instruction`,
/// `instr_encoding` and `heading` (else 0). Lines, or a list. Scans and viewpoints may have ids of
/// any form ("00000-kfPV7w3FaU5", "000007"), `objid` is a number or its digits. Each record becomes
/// a path of its own; its goal is a NamedObject with the viewpoints of `pos_vps`. Records whose ids
/// differ only after the last underscore are a group. Other fields are ignored.
/// \throws InvalidInput listing its faults with JSON paths:
/// - missing or wrongly typed fields, an empty path or id, a negative `objid`
/// - no viewpoint that sees the object
/// - a repeated `instr_id`
Annotations parse_object_lines(std::string_view text, const std::string& file, std::string split);

/// Lines: a result of parse_object_lines() is read back equal, if it is not empty.
/// \throws ArgumentError for other annotations than those, infinite numbers, and text that is not
/// UTF-8
std::string to_object_lines(const Annotations& annotations);

// CVDN's navigation from dialogue history (github.com/mmurray/cvdn, tasks/NDH).

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

// RxR's guides (github.com/google-research-datasets/RxR), JSON Lines. Followers: files.h.

/// Reads guide annotations, one instruction per line; also HAMT's with `instr_encoding`. Each line
/// becomes a path with one instruction, whose details have the language and any timed words.
/// Instruction ids are `<path_id>_<instruction_id>`. Test lines have no `path_id`, and only the
/// start as their path; their id is `<instruction_id>`, which is their path_id, too. Lines of one
/// `path_id` are a group. `split`, `annotator_id` and `edit_distance` are ignored.
/// \throws InvalidInput listing its faults with JSON paths (the index counts records from 0):
/// - missing or wrongly typed fields, a negative id, an empty path, an unknown language
/// - more than the start without a path_id
/// - a repeated instruction_id
Annotations parse_rxr_guide(std::string_view lines, const std::string& file, std::string split);

/// A guide's lines: a result of parse_rxr_guide() is read back equal, if it is not empty.
/// `edit_distance` and `annotator_id` are not in the model, and are left out.
/// \throws ArgumentError for other annotations than RxR's, infinite numbers, and text that is not
/// UTF-8
std::string to_rxr_guide(const Annotations& annotations);

// SOON's files, as released (github.com/ZhuFengdaaa/SOON) and as DUET reads them.

/// Reads `<split>.json` as released: entries with several alternative paths. Each alternative
/// becomes a path of its own, with id `<split number>-<running number>` as in DUET's files
/// (numbers: train 0, val_seen_instrs 1, val_unseen_instrs 2, val_unseen_house 3, test 4; other
/// splits 9). Its path_id is the running number, its group the entry.
///
/// Instruction k of an entry is its list of five texts: name, attribute, relation, region, and the
/// whole, which is the text. The first four become the details' fields `obj_name`, `attribute`,
/// `relation`, `region`. An `instr_id` is kept: InstructionDetails::entry.
///
/// Goals are NamedBoxes; hidden without `bboxes`, or if the list is empty. A box has its `target`;
/// its own `heading` and `elevation`, and `mouse_*`, are ignored. The scan is that of the boxes, or
/// the entry's own `scan`. The heading is 1.52, with which DUET evaluates.
/// \throws InvalidInput listing its faults with JSON paths:
/// - missing or wrongly typed fields, no path, an empty path
/// - two scans in one entry, a repeated instr_id
/// - instructions that are not lists of five
/// - alternatives that repeat more than 2 GiB of their entries
Annotations parse_soon(std::string_view json, const std::string& file, std::string split);

/// The same for DUET's lines (`<split>_enc.jsonl`, `<split>_enc_pseudo_obj_label.jsonl`), one path
/// per line. `instructions` is a list of objects with `full` and any of the other four texts.
/// `instr_encodings` has the same keys; that of `full` becomes the tokens. `pseudo_label` is
/// ignored. Lines do not name their entry: there are no groups and first alternatives.
/// \throws InvalidInput as parse_soon(); also for a repeated path_id, one that is not two numbers
/// with "-" between them, and another number of encodings than of instructions
Annotations parse_soon_lines(std::string_view lines, const std::string& file, std::string split);

/// Lines in DUET's form: a result of parse_soon_lines() is read back equal, if it is not empty. So
/// is one of parse_soon(), except groups, first alternatives and entries' ids. Encodings have only
/// `full`.
/// \throws ArgumentError for other annotations than SOON's, infinite numbers, and text that is not
/// UTF-8
std::string to_soon_lines(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
