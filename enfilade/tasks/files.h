/// \file  Annotation files of all benchmarks: finds the form, reads it, packed or not.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/goal.h"

namespace enfilade::tasks {

/// A follower's trajectory for one instruction, with the scores of the data set's authors.
struct Demonstration {
  std::int64_t demonstration_id = 0, instruction_id = 0, annotator_id = 0;
  std::vector<std::string> path;
  /// Metres (dtw is not normalised), shares. Against the guide's path of the instruction. Published
  /// ones cannot be reproduced exactly from connectivity files: docs/tasks.md.
  double ne = 0, sr = 0, spl = 0, dtw = 0, ndtw = 0, sdtw = 0;
  friend bool operator==(const Demonstration&, const Demonstration&) = default;
};

/// Which benchmark a text of annotations is of, by the fields of its first record; R2R-Last looks
/// like R2R. No value if it has no record, or the first is no object.
std::optional<Task> find_task(std::string_view text);

/// The same of results: by the fields that only one benchmark's have. No value also for those that
/// could be of several: R2R's form is RxR's and R4R's, too.
std::optional<Task> find_task_of_results(std::string_view text);

/// Reads a file of a benchmark in any form that its public code reads. These are lists and lines,
/// with token ids, fine-grained, HAMT's and DUET's forms. formats/ has a header for each.
/// \throws FileError; InvalidInput listing its faults (up to 1000) with their JSON paths
Annotations load_annotations(const std::filesystem::path& file, std::string split, Task task);
Annotations parse_annotations(std::string_view text, const std::string& file, std::string split,
                              Task task);

/// The text of a file in the benchmark's own form, which parse_annotations() reads back equal. It
/// is empty for no paths in lines. The forms:
/// - R2R and the benchmarks made from it: a list, with token ids and sub-instructions if there are
///   any
/// - RxR: a guide's lines
/// - SOON: DUET's lines
/// - REVERIE: a list
/// - CVDN: a list, in HAMT's form if there are token ids and no texts
/// \throws ArgumentError for annotations that the form cannot express
std::string to_text(const Annotations& annotations);
/// SOON's annotations in their released form, one entry per line. Neighbouring paths of one group
/// are an entry's alternatives; a path without a group is an entry. An entry without an `instr_id`
/// gets its number in the file. Token ids are left out. If the ids are those that the reader gives,
/// parse_annotations() reads the text back equal.
/// \throws ArgumentError for other annotations than SOON's, naming the path:
/// - instructions without the four texts beside the whole
/// - paths of one group that differ in more than the path, two groups of one instr_id
/// - infinite numbers and text that is not UTF-8
std::string to_released_soon(const Annotations& annotations);

/// Whether boxes of objects are needed to find the viewpoints that see a goal. REVERIE's need them.
/// HM3DAutoVLN's lines name the viewpoints, and hidden goals need no boxes.
bool needs_boxes(const Annotations& annotations);
/// Where REVERIE's boxes may be in that folder: a file, or a folder.
std::vector<std::filesystem::path> object_places();
/// Where fine-grained R2R of a split may be in that folder, packed or not. load_annotations() reads
/// it, with Task::kR2r.
std::vector<std::filesystem::path> fine_grained_places(std::string_view split);

/// RxR's followers, one trajectory per line.
/// \throws as load_annotations(): missing or wrongly typed fields, a bad id, an empty path, a
/// repeated demonstration_id
std::vector<Demonstration> load_demonstrations(const std::filesystem::path& file);
std::vector<Demonstration> parse_demonstrations(std::string_view lines, const std::string& file);
/// The lines of a file of RxR's followers, which load_demonstrations() reads back equal.
/// \throws ArgumentError for an infinite number, a negative id, an empty path, text that is not
/// UTF-8
std::string to_text(std::span<const Demonstration> walks);

}  // namespace enfilade::tasks
