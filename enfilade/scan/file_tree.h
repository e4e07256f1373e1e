/// \file  FileTree: the files of a folder or of a zip file. And the writer of small zip files, as
/// NumPy's `.npz` are.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::scan {

/// By what names the files of a zip file are known.
enum class ZipNames : std::uint8_t {
  kBare,   ///< the last part of the path
  kPaths,  ///< the whole path, with its '/'
};

/// Reads files by name. All functions may be called by several threads at once.
class FileTree {
 public:
  virtual ~FileTree() = default;
  /// The files of a folder, not of its subfolders. \throws FileError if `path` is not a folder
  static std::shared_ptr<const FileTree> folder(const std::filesystem::path& path);
  /// The files of a zip file. Its list of entries is read now (100,000 entries: 0.25 s) and once
  /// more for each further thread that reads at the same time.
  /// \throws FileError; InvalidInput if it is damaged, cut off or encrypted
  static std::shared_ptr<const FileTree> zip(const std::filesystem::path& path,
                                             ZipNames names = ZipNames::kBare);
  /// The same for a zip file in memory; `name` stands for it in messages. \throws InvalidInput
  static std::shared_ptr<const FileTree> zip_in_memory(std::string bytes, const std::string& name);

  /// The content of a file by its bare name. In a zip it may lie in any folder: downloads put
  /// `<scan>/<kind>/` before it. No value if it is missing, or if the name has a '/' in it. With
  /// ZipNames::kPaths a name is the path in the zip.
  /// \throws FileError; InvalidInput for a damaged entry (checksums are compared), one that claims
  /// more than 1 GiB, and a name that the zip has twice
  std::optional<std::string> read(std::string_view name) const;
  /// As read(), but only the first `bytes` bytes, or all if the file has fewer. The rest
  /// is not checked.
  virtual std::optional<std::string> read_start(std::string_view name, std::size_t bytes) const = 0;
  virtual bool contains(std::string_view name) const = 0;
  /// Names of all files, sorted.
  virtual std::vector<std::string> names() const = 0;
  /// "path/to/folder/name" or "path/to.zip:name", for messages.
  virtual std::string path_of(std::string_view name) const = 0;
  /// A text that changes when a file does. It holds the current names, sizes and times of a
  /// folder's files, or size and time of a zip file.
  /// \throws FileError
  virtual std::string state() const = 0;
};

/// A file in a zip file.
struct ZipEntry {
  std::string name;  ///< with '/' between folders; unique, not empty, UTF-8, at most 65,535 bytes
  std::string content;
};

/// A zip file with these entries, in this order, each deflated. The same entries give the same
/// bytes: all times are 1980-01-01. FileTree::zip_in_memory() reads it.
/// \throws ArgumentError for an empty, repeated or too long name, more than 65,535 entries, and
/// more than 4 GiB (both need zip64)
std::string zip(std::span<const ZipEntry> entries);

}  // namespace enfilade::scan
