#include "enfilade/features/formats/stored_arrays.h"

#include <algorithm>
#include <bit>

// Files of weights are little-endian, and so is every machine that this is built for.
static_assert(std::endian::native == std::endian::little);

namespace enfilade::features::formats {

std::span<const std::byte> StoredArrays::aligned(std::span<const std::byte> bytes, DType type) {
  if (std::bit_cast<std::uintptr_t>(bytes.data()) % size_of(type) == 0) return bytes;
  const auto copy = allocate(bytes.size());
  std::ranges::copy(bytes, copy.begin());
  return copy;
}

std::span<std::byte> StoredArrays::allocate(std::size_t bytes) {
  // new[], and not std::make_shared: its memory is aligned for any type.
  const std::shared_ptr<std::byte[]> room(new std::byte[bytes]);
  memory.push_back(room);
  return {room.get(), bytes};
}

std::optional<std::size_t> bytes_of_shape(std::span<const std::int64_t> shape,
                                          DType type) noexcept {
  // An empty array is empty whatever its other sides are.
  if (std::ranges::find(shape, 0) != shape.end()) return 0;
  std::size_t bytes = size_of(type);
  for (const std::int64_t side : shape) {
    if (__builtin_mul_overflow(bytes, static_cast<std::size_t>(side), &bytes)) return std::nullopt;
  }
  return bytes;
}

}  // namespace enfilade::features::formats
