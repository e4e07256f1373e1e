/// \file  Annotation files of the benchmarks that were recorded with the scores of their public
/// code. They lie beside the data that ENFILADE_DATA names.
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "enfilade/core/gzip.h"
#include "enfilade/scan/data_root.h"

namespace enfilade::tests {

/// Why a test is skipped where recorded_annotations() gives nothing.
inline constexpr const char* kNoRecordedAnnotations =
    "ENFILADE_DATA is not set, or no recorded annotations lie beside it";

/// The text of a file, unpacked; nothing if there is none.
inline std::optional<std::string> recorded_annotations(const std::string& name) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) return std::nullopt;
  const std::filesystem::path file = std::filesystem::absolute(data->folder()) / ".." /
                                     "reference" / "benchmarks_public" / "annotations" / name;
  if (!std::filesystem::exists(file)) return std::nullopt;
  return read_text_file(file);
}

}  // namespace enfilade::tests
