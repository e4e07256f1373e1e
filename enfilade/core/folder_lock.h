/// \file  A lock file, so that one process at a time works in a folder.
#pragma once
#include <filesystem>

namespace enfilade {

/// Holds the lock while it exists. The system releases it when the process ends, however it ends.
class FolderLock {
 public:
  /// \param file created if it does not exist, and not removed
  /// \throws FileError if another process holds the lock, or the file cannot be created
  explicit FolderLock(const std::filesystem::path& file);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace enfilade
