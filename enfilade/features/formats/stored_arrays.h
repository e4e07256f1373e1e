/// \file  The result of a reader of weights.
#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/features/tensor_file.h"

namespace enfilade::features::formats {

/// Arrays, and the memory that they point into.
struct StoredArrays {
  std::vector<NamedArray> arrays;
  std::map<std::string, std::string> metadata;
  std::vector<std::shared_ptr<const void>> memory;  ///< of arrays that are not in the mapped file

  /// The bytes themselves if they are aligned for the type, else a copy.
  std::span<const std::byte> aligned(std::span<const std::byte> bytes, DType type);
  /// Uninitialised memory, valid as long as *this.
  std::span<std::byte> allocate(std::size_t bytes);
};

/// Bytes of an array; none if they exceed size_t.
std::optional<std::size_t> bytes_of_shape(std::span<const std::int64_t> shape, DType type) noexcept;

}  // namespace enfilade::features::formats
