/// \file  The HDF5 library's lock and handles, and datasets of a foreign file that may be read, in
/// a forked copy of the process. Internal, as it includes hdf5.h.
#pragma once
#include <hdf5.h>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/mapped_file.h"

namespace enfilade::features::formats {

/// Held around every use of the library, which is not thread-safe. Its own printing of errors is
/// off meanwhile.
class Hdf5Library {
 public:
  Hdf5Library() : lock_(mutex()) {
    [[maybe_unused]] static const bool kPrepared = prepare();
    H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Hdf5Library() { H5Eset_auto2(H5E_DEFAULT, print_, print_data_); }
  Hdf5Library(const Hdf5Library&) = delete;
  Hdf5Library& operator=(const Hdf5Library&) = delete;

  /// The library's description of its last error.
  static std::string reason();

 private:
  static bool prepare();  ///< once, with the lock held
  static std::mutex& mutex();

  std::lock_guard<std::mutex> lock_;
  H5E_auto2_t print_ = nullptr;
  void* print_data_ = nullptr;
};

/// Owns an object of the library; its id is negative if it could not be opened.
class Hdf5Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Handle(hid_t id, Close closer) : id_(id), close_(closer) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Handle() { close(); }

  hid_t id() const { return id_; }
  bool good() const { return id_ >= 0; }
  bool close() { return id_ < 0 || close_(std::exchange(id_, -1)) >= 0; }

 private:
  hid_t id_;
  Close close_;
};

/// numpy's float16, which HDF5 has no name for. \pre an Hdf5Library is held
Hdf5Handle half_type();

/// The links of a file's root group, up to the first that is not a hard one.
struct Hdf5Links {
  std::vector<std::string> names;
  bool hard = true;  ///< all of them
  bool read = true;  ///< false: the library could not read them
};
Hdf5Links links_of(hid_t file);  ///< \pre an Hdf5Library is held

/// Memory that a process shares with its forked copies.
class SharedMemory {
 public:
  /// 0 bytes. \param file whose content it will hold, for messages \param most bytes
  /// \throws FileError
  explicit SharedMemory(std::string file,
                        std::uint64_t most = std::numeric_limits<std::uint64_t>::max());
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  /// \throws FileError, also beyond the most bytes
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  std::string path() const;  ///< to map it by, while this object exists

 private:
  std::string file_;
  std::uint64_t most_;
  int descriptor_;
};

/// Runs `work` in a forked copy of this process. The copy has the calling thread only, so `work`
/// must not wait for another. Only its output to SharedMemory is kept; its other changes of memory
/// and its output are lost.
/// \param file that it reads, for messages
/// \throws the InvalidInput or FileError that `work` throws
/// \throws InvalidInput with `code` if the copy crashes, is killed, or throws another error
void run_isolated(const std::string& file, const std::string& code,
                  const std::function<void()>& work);

/// Only these types are read. The library converts from any bit layout in a file, even from an
/// impossible one, and then reads outside of its memory.
bool is_plain_float(hid_t type);
bool is_plain_number(hid_t type);  ///< or an integer of 16, 32 or 64 bits

/// A file that is read, with the datasets of its root group. \pre an Hdf5Library is held while it
/// is used
class Hdf5Source {
 public:
  /// \param name for messages
  /// \throws InvalidInput, with code "locked" if another program writes the file
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
  /// For data that cannot be read: names a filter that the library lacks, else as fail_damaged().
  [[noreturn]] void fail_unread(const std::string& dataset, const Hdf5Handle& opened) const;

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
