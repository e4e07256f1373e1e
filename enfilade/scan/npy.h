/// \file  NumPy's arrays as files (numpy.org, "numpy.lib.format"): `.npz` files are zip files of
/// them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::scan {

/// The kind of an array's elements.
enum class NpyKind : std::uint8_t { kFloat, kInteger, kUnsigned, kBool, kText, kBytes };

/// An array, read. Its elements are taken in C order, whatever the file's is.
class NpyArray {
 public:
  /// Reads `.npy` of versions 1, 2 and 3: numbers of 1 to 8 bytes of either order, bools, texts of
  /// a fixed length (`<U32`, `|S32`).
  /// \throws Error naming what was found and what is expected, for a damaged header, another type
  /// or another size than the shape needs. Objects are Python code, and are never read.
  static NpyArray parse(std::string bytes);

  NpyKind kind() const noexcept { return kind_; }
  bool is_number() const noexcept { return kind_ < NpyKind::kText; }
  bool is_text() const noexcept { return !is_number(); }
  const std::string& type() const noexcept { return type_; }  ///< "<f4", as in the file
  /// Empty: a scalar. The product is size(), which has no overflow.
  const std::vector<std::size_t>& shape() const noexcept { return shape_; }
  std::string shape_text() const;  ///< "(3, 16)"
  std::size_t size() const noexcept { return size_; }

  /// Element i in C order. A bool is 0 or 1. \pre is_number(), i < size()
  double number(std::size_t i) const;
  /// Writes the elements in C order, little-endian. \param out size() times item_bytes()
  void copy_elements(std::span<std::byte> out) const;
  std::size_t item_bytes() const noexcept { return item_; }  ///< of an element
  /// UTF-8; zeros at its end do not count. A code that is no character is U+FFFD. \pre is_text()
  std::string text(std::size_t i) const;

 private:
  void put_in_order(bool fortran, bool big_endian);
  std::uint64_t integer(std::size_t begin, std::size_t bytes) const;

  std::string bytes_, type_;
  NpyKind kind_ = NpyKind::kFloat;
  std::size_t item_ = 1, data_ = 0, size_ = 1;
  std::vector<std::size_t> shape_;
};

/// \name `.npy` of version 1, C order, little-endian.
/// @{
/// \pre the product of `shape` is the size of `values`
std::string write_npy(std::span<const float> values, const std::vector<std::size_t>& shape);
std::string write_npy(std::span<const std::uint8_t> bools, const std::vector<std::size_t>& shape);
/// As long as the longest. \throws ArgumentError for text that is not UTF-8
std::string write_npy(std::span<const std::string> texts, const std::vector<std::size_t>& shape);
/// @}

}  // namespace enfilade::scan
