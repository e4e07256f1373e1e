/// \file  The one way in which files with computed names are written: below a folder, never
/// outside.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/mapped_file.h"

namespace enfilade {

/// A folder that a program fills. All names are relative to it, with `/` between folders. Each part
/// of a name is a name of a file (is_file_name()). The folder itself may be a link. No link below
/// it is followed, at any time: one that another user put there leads nowhere. Any thread may call
/// the const functions at once, for different names.
class OutputFolder {
 public:
  /// Makes the folder and its parents if they do not exist.
  /// \throws FileError naming the path and the system's reason
  explicit OutputFolder(std::filesystem::path folder);

  const std::filesystem::path& path() const noexcept { return path_; }

  /// Writes a whole file, and the folders of its name. It replaces an older file of that name, and
  /// a link instead of the link's target. Readers see the old content or the new.
  /// \throws ArgumentError for a name that leads elsewhere; FileError naming the path and the
  /// system's reason, also for a link among the folders
  void write(std::string_view name, std::string_view content) const;

  /// The path of a file for a writer that opens it by itself (HDF5, databases, PartFile). Makes the
  /// folders of the name. A link in place of the file is removed. \throws as write()
  std::filesystem::path file(std::string_view name) const;

  /// Makes a folder and its parents within this one. The result follows no link on the way from
  /// this one, at any time. A writer that uses its path() does. \throws as write()
  OutputFolder folder(std::string_view name) const;

  /// Removes a file or a link, not its target. Does nothing if there is none. \throws as write()
  void remove(std::string_view name) const;
  /// Removes a folder if it is empty. \returns whether it did. \throws as write()
  bool remove_empty(std::string_view name) const;
  /// Removes a file, or a folder with everything in it; of links nothing but themselves. Does
  /// nothing if there is none. \throws as write()
  void remove_all(std::string_view name) const;
  /// Renames a file or a folder. It replaces a file, a link or an empty folder.
  /// \throws as write(), also if there is no such file; nothing is made then
  void rename(std::string_view from, std::string_view to) const;

  /// remove_unfinished() of core/file.h in a folder, which need not exist; empty: in this one. Does
  /// nothing behind a link. \throws as write()
  void remove_unfinished(std::string_view folder = {}, std::string_view ending = {}) const;

  /// Whether a text is a name that write() takes. The file's own name has at most 243 bytes, as
  /// write() puts ".part<process>" behind it at first.
  static bool is_name(std::string_view name) noexcept;

 private:
  OutputFolder(const OutputFolder& above, std::string_view name);
  // From root_, each checked.
  std::vector<std::string> parts_of(std::string_view name) const;

  std::filesystem::path root_;
  std::string below_;           // within root_; empty: this is the root
  std::filesystem::path path_;  // of both
};

}  // namespace enfilade
