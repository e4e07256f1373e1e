/// \file  HDF5 files of named arrays with attributes, in whatever form others read.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace enfilade::features {

/// Type of the numbers of an array in a file; all are little-endian.
enum class Hdf5Type : std::uint8_t {
  kFloat16,  ///< numpy's float16
  kFloat32,
  kFloat64,
  kUint8,
  kUint16,
  kInt64,
};
std::size_t size_of(Hdf5Type type) noexcept;  ///< bytes of a number

/// An array in memory, row-major, without gaps. Does not own its bytes.
struct Hdf5Array {
  Hdf5Type type = Hdf5Type::kFloat32;
  std::vector<std::uint64_t> shape;  ///< not empty; each at least 1
  std::span<const std::byte> bytes;  ///< product of shape times size_of(type)
};

/// Value of an attribute: a text, a number, texts, an array. h5py gives texts as str.
using Hdf5Value =
    std::variant<std::string, std::int64_t, double, std::vector<std::string>, Hdf5Array>;
/// A named value beside an array.
struct Hdf5Attribute {
  std::string name;
  Hdf5Value value;
};

/// One array of a file.
struct Hdf5Dataset {
  std::string name;  ///< in the root group: not empty, without "/"
  Hdf5Array array;
  std::vector<Hdf5Attribute> attributes;  ///< each smaller than 64 kB, as the format requires
};

/// How a file is written.
struct Hdf5Options {
  int gzip = 4;           ///< 0: not packed; 1 (fast) to 9 (small). h5py's own choice is 4
  bool replaces = false;  ///< an array takes the place of an earlier one of its name
  /// Attributes of the file, as texts of fixed length: a damaged file with variable ones can crash
  /// readers. Empty texts are left out.
  std::map<std::string, std::string> texts = {};
};

/// Writes a file, an array at a time, in any order. The file has its name only after finish();
/// until then it is "<file>.part". Several may be used by as many threads; calls into the HDF5
/// library take turns.
class Hdf5Writer {
 public:
  /// Begins anew, whatever an earlier run has left. \throws FileError, also if another process is
  /// writing the file; ArgumentError for options out of range
  explicit Hdf5Writer(const std::filesystem::path& file, const Hdf5Options& options = {});
  ~Hdf5Writer();
  Hdf5Writer(Hdf5Writer&&) noexcept;
  Hdf5Writer& operator=(Hdf5Writer&&) noexcept;

  /// \pre not finished
  /// \throws FileError (the disk is full, ...)
  /// \throws ArgumentError for an invalid or (unless it replaces) repeated name, a shape that is
  /// invalid or does not fit the bytes, and null characters in texts
  void write(const Hdf5Dataset& dataset);
  /// Copies all arrays of a file that an Hdf5Writer has finished, as they are packed.
  /// \throws FileError; ArgumentError for a name that this file has already
  void copy_from(const std::filesystem::path& file);
  void finish();  ///< \throws FileError

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::features
