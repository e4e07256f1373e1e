/// \file  What a reader of weights makes of a file.
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

struct StoredArrays {
  std::vector<NamedArray> arrays;
  std::map<std::string, std::string> metadata;
  std::vector<std::shared_ptr<const void>> memory;  ///< that some of the arrays lie in

  /// The bytes themselves if an element of this type may lie there, else a copy.
  std::span<const std::byte> aligned(std::span<const std::byte> bytes, DType type);
  /// Uninitialised memory, kept as long as this.
  std::span<std::byte> allocate(std::size_t bytes);
};

/// None if the product of a shape and the size of its elements is beyond size_t.
std::optional<std::size_t> bytes_of_shape(std::span<const std::int64_t> shape, DType type) noexcept;

}  // namespace enfilade::features::formats
