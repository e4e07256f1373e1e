/// \file  Datasets of a foreign HDF5 file that may be read. Internal, as it includes hdf5.h.
#pragma once
#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/core/mapped_file.h"
#include "enfilade/features/formats/hdf5_library.h"
#include "enfilade/features/formats/isolated.h"

namespace enfilade::features::formats {

/// Only these types are read. The library converts from any bit layout in a file, even from an
/// impossible one, and then reads outside of its memory.
bool is_plain_float(hid_t type);
bool is_plain_number(hid_t type);  ///< or an integer of 16, 32 or 64 bits

/// A file that is read, with the datasets of its root group. \pre an Hdf5Library is held while it
/// is used
class Hdf5Source {
 public:
  /// \param name for messages \throws InvalidInput
  Hdf5Source(const std::filesystem::path& path, std::string name);

  hid_t id() const { return file_.id(); }
  const std::string& name() const { return name_; }
  /// Only hard links are followed: others could lead to other files. \throws InvalidInput
  std::vector<std::string> datasets() const;
  /// \throws InvalidInput
  Hdf5Handle open_dataset(const std::string& dataset) const;
  /// Rows and columns. \throws InvalidInput for another number of sides, 0, or too many numbers
  std::array<hsize_t, 2> size_of(const std::string& dataset, const Hdf5Handle& opened) const;
  /// A dataset without data reads as zeros. The library allocates chunks as large as they claim.
  /// \throws InvalidInput for these, and for data that is in other files
  void check_layout(const std::string& dataset, const Hdf5Handle& opened) const;

  /// \throws InvalidInput naming the dataset
  [[noreturn]] void fail(const std::string& dataset, const char* code, std::string message) const;
  [[noreturn]] void fail_damaged(const std::string& dataset) const;  ///< with the library's reason

 private:
  void check_size(const std::string& dataset, const std::array<hsize_t, 2>& size) const;

  std::string name_;
  Hdf5Handle file_;
};

/// Runs `copy` on a file in a forked copy of the process: damaged files crash the library.
/// \throws FileError; InvalidInput
std::shared_ptr<const MappedFile> read_isolated(const std::filesystem::path& file,
                                                const std::function<void(SharedMemory&)>& copy);

}  // namespace enfilade::features::formats
