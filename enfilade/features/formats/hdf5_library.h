/// \file  The HDF5 library's lock and handles, for readers and writers. Internal, as it includes
/// hdf5.h.
#pragma once
#include <hdf5.h>

#include <mutex>
#include <string>
#include <utility>

namespace enfilade::features::formats {

/// Held around every use of the library, which is not thread-safe. Its own printing of errors is
/// off meanwhile.
class Hdf5Library {
 public:
  Hdf5Library() : lock_(mutex()) {
    // A file that could not be closed, as the disk was full, stays open in the library. It would
    // try again when the program ends, and crash. All others are closed by Hdf5Handle.
    [[maybe_unused]] static const herr_t kNothingAtExit = H5dont_atexit();
    H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Hdf5Library() { H5Eset_auto2(H5E_DEFAULT, print_, print_data_); }
  Hdf5Library(const Hdf5Library&) = delete;
  Hdf5Library& operator=(const Hdf5Library&) = delete;

  /// The library's description of its last error.
  static std::string reason();

 private:
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

}  // namespace enfilade::features::formats
