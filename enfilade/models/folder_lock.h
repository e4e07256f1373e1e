/// \file  One process at a time in a folder.
#pragma once
#include <filesystem>

namespace enfilade::models {

/// Held as long as this object, and no longer than the process, however that ends.
class FolderLock {
 public:
  /// \param file made if it is not there, and left there
  /// \throws FileError if another process holds it, or it cannot be made
  explicit FolderLock(const std::filesystem::path& file);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace enfilade::models
