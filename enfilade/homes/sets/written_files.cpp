#include "enfilade/homes/sets/written_files.h"

#include <fmt/format.h>
#include <sstream>
#include <system_error>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"

namespace enfilade::homes::sets {
namespace {

namespace fs = std::filesystem;

constexpr const char* kList = "annotations.txt";

// The lines of a list; none where there is no list.
std::vector<fs::path> read_list(const fs::path& list) {
  std::vector<fs::path> files;
  if (!fs::exists(list)) return files;
  std::istringstream lines(read_file(list));
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const fs::path file(line);
    const bool inside = !line.empty() && file.is_relative() && file.has_filename() &&
                        file.lexically_normal() == file && *file.begin() != "..";
    if (!inside) {
      throw InvalidInput(
          {{Severity::kError, list.string(), fmt::format("line {}", number), "bad-path",
            fmt::format("{:?}, not a path of a file below the folder", line)}});
    }
    files.push_back(file);
  }
  return files;
}

// With folders above it that are empty then, up to `folder`.
void remove_file(const fs::path& folder, const fs::path& file) {
  std::error_code error;
  fs::remove(folder / file, error);
  if (error) {
    throw FileError(
        fmt::format("{}: cannot be removed: {}", (folder / file).string(), error.message()));
  }
  for (fs::path above = file.parent_path(); !above.empty(); above = above.parent_path()) {
    std::error_code ignored;  // it has other files
    if (!fs::remove(folder / above, ignored)) return;
  }
}

}  // namespace

void WrittenFiles::write(const fs::path& file, std::string_view text) {
  make_folder((folder_ / file).parent_path());
  write_file_atomically(folder_ / file, text);
  files_.insert(file.generic_string());
}

void WrittenFiles::finish() {
  for (const fs::path& old : read_list(folder_ / kList)) {
    if (!files_.contains(old.generic_string())) remove_file(folder_, old);
  }
  std::string list;
  for (const std::string& file : files_) list += file + "\n";
  write_file_atomically(folder_ / kList, list);
}

}  // namespace enfilade::homes::sets
