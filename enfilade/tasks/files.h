/// \file  Annotation files of all benchmarks: finds the form, reads it, packed or not.
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/demonstrations.h"
#include "enfilade/tasks/goal.h"

namespace enfilade::tasks {

/// A benchmark's name in commands and files: "r2r", "r2r-last", "r2r-back", "r4r", "rxr",
/// "reverie", "cvdn", "soon".
std::string_view name_of(Task task) noexcept;
/// For people: "R2R-Last".
std::string_view title_of(Task task) noexcept;
/// By name_of(). \throws LookupError listing the benchmarks
Task task_named(std::string_view name);

/// The benchmark of a text of annotations, by the fields of its first record; R2R-Last is taken for
/// R2R. No value if it has no record, or the first is not an object.
std::optional<Task> find_task(std::string_view text);

/// The same for results: by fields that occur in one benchmark only. No value also if several are
/// possible: R2R's form is RxR's and R4R's, too.
std::optional<Task> find_task_of_results(std::string_view text);

/// Reads a file of a benchmark in any form that its public code reads. These are lists and lines,
/// with token ids, fine-grained, HAMT's and DUET's forms; formats/ has a header for each.
/// \throws FileError; InvalidInput listing its faults (up to 1000) with their JSON paths
Annotations load_annotations(const std::filesystem::path& file, std::string split, Task task);
Annotations parse_annotations(std::string_view text, const std::string& file, std::string split,
                              Task task);

/// The text of a file in the benchmark's own form, which parse_annotations() reads back equal:
/// - R2R and its descendants: a list, with any token ids and sub-instructions
/// - RxR: a guide's lines
/// - SOON: DUET's lines
/// - REVERIE: a list
/// - CVDN: a list; in HAMT's form if there are token ids and no texts
///
/// Empty for no paths in lines. \throws ArgumentError for content that the form cannot express
std::string to_text(const Annotations& annotations);
/// SOON's annotations in the form of their release. They are read back equal by parse_annotations()
/// if their ids are those that the reader gives. Neighbouring paths of one group are alternatives.
/// Token ids are left out.
/// \throws ArgumentError for other annotations; for instructions without the four texts beside the
/// whole
std::string to_released_soon(const Annotations& annotations);

/// Candidate paths of a split's annotations in a folder of data, relative to it, in the order of
/// the search. Enfilade's layout ("reverie/REVERIE_val_unseen.json"), that of the public code
/// ("REVERIE/annotations/REVERIE_val_unseen_enc.json"), side by side; each also packed (".gz").
std::vector<std::filesystem::path> annotation_places(Task task, std::string_view split);
/// The splits in a benchmark's public files, in their order, by the names of those files: "train",
/// "val_seen", "val_unseen", "test". CVDN has "test_cleaned", RxR and SOON have others too. Any
/// other name is allowed, too.
std::span<const std::string_view> usual_splits(Task task) noexcept;
/// Whether object boxes are needed to find the viewpoints that see a goal. REVERIE's goals need
/// them; HM3DAutoVLN's lines name the viewpoints themselves, and hidden goals have none.
bool needs_boxes(const Annotations& annotations);
/// Where REVERIE's boxes may be in that folder: a file, or a folder.
std::vector<std::filesystem::path> object_places();

/// RxR's followers. \throws as load_annotations()
std::vector<Demonstration> load_demonstrations(const std::filesystem::path& file);
std::vector<Demonstration> parse_demonstrations(std::string_view lines, const std::string& file);
/// The lines of a file of RxR's followers, which load_demonstrations() reads back equal.
/// \throws ArgumentError for an infinite number, a negative id, an empty path, text that is not
/// UTF-8
std::string to_text(std::span<const Demonstration> walks);

}  // namespace enfilade::tasks
