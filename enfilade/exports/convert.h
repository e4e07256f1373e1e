/// \file  The same content in another form: annotations, results, boxes, features.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::exports {

/// Content of a file.
enum class FileKind : std::uint8_t {
  kAnnotations,  ///< paths with instructions, of any benchmark
  kFollowers,    ///< RxR's followers
  kResults,      ///< trajectories of agents
  kBoxes,        ///< REVERIE's boxes of objects: a file or a folder
  kFeatures,     ///< of views, by the suffix
};
std::string_view to_string(FileKind kind);  ///< "annotations", "followers", ...

/// By the suffix (features), whether it is a folder (boxes), and the first record's fields.
/// \throws FileError; InvalidInput for a text that begins as none of them
FileKind find_kind(const std::filesystem::path& file);

/// Which names results use where public code differs.
enum class ResultKeys : std::uint8_t {
  kOfficial,  ///< `predObjId` (REVERIE), the number `inst_idx` (CVDN)
  kDuet,      ///< `pred_objid`, the text `instr_id`: HAMT, DUET and their descendants
};
/// A list of results with other keys, one entry per line; the rest does not change. A number
/// `predObjId` stays a number.
/// \throws InvalidInput listing its faults with JSON paths: not a list of objects, both keys in one
/// entry, an instr_id that is not a number for `inst_idx`
std::string with_keys(std::string_view results, const std::string& file, ResultKeys keys,
                      tasks::Task task);

/// How annotations are written.
struct AnnotationForm {
  bool released = false;  ///< SOON's as they were released, not DUET's
  bool lines = false;     ///< JSON Lines, where the form itself is a list
};
/// tasks::to_text(), or to_released_soon(), after a check that the text is read back equal. DUET's
/// lines of SOON do not tell which paths are alternatives of one entry; that is lost.
/// \throws ArgumentError for content that the form cannot hold, naming the first path that would
/// differ
std::string annotations_text(const tasks::Annotations& annotations, const AnnotationForm& form);

}  // namespace enfilade::exports
