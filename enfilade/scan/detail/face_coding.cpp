#include "enfilade/scan/detail/face_coding.h"

#include <zstd.h>
#include <limits>
#include <memory>
#include <utility>

#include "enfilade/core/check.h"

namespace enfilade::scan::detail {
namespace {

// Levels of zstd (1 to 22); measurements: docs/design/store.md. Predictors are compared at the
// quick level, which ranks them as the thorough one does.
constexpr int kThorough = 12, kQuick = 3;

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

ZSTD_CCtx* compressor() {
  thread_local const std::unique_ptr<ZSTD_CCtx, FreeContext> kContext(ZSTD_createCCtx());
  EN_CHECK(kContext != nullptr);
  return kContext.get();
}

ZSTD_DCtx* decompressor() {
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeContext> kContext(ZSTD_createDCtx());
  EN_CHECK(kContext != nullptr);
  return kContext.get();
}

// Memory for a face, one per thread, as large as the largest face so far.
std::span<std::uint8_t> scratch(std::size_t bytes) {
  thread_local std::vector<std::uint8_t> memory;
  if (memory.size() < bytes) memory.resize(bytes);
  return {memory.data(), bytes};
}

template <class T>
T fold(T difference) {
  const auto sign = static_cast<T>(0 - (difference >> (8 * sizeof(T) - 1)));
  return static_cast<T>(static_cast<T>(difference << 1) ^ sign);
}

template <class T>
T unfold(T folded) {
  return static_cast<T>((folded >> 1) ^ static_cast<T>(0 - (folded & 1)));
}

// The predicted value of a texel. In the first column it is the texel above, in the first row that
// to the left, for the first texel 0.
template <class T>
T predicted(Coding coding, const T* texel, std::size_t x, std::size_t y, std::size_t size) {
  if (x == 0) return y == 0 ? T{0} : texel[-static_cast<std::ptrdiff_t>(size)];
  const T left = texel[-1];
  if (y == 0 || coding == Coding::kLeft) return left;
  const T above = *(texel - size);
  return coding == Coding::kUp ? above : static_cast<T>(left + above - *(texel - size - 1));
}

template <class T>
std::vector<std::uint8_t> split(Coding coding, std::span<const T> texels, std::size_t size) {
  const std::size_t count = texels.size();
  std::vector<std::uint8_t> planes(count * sizeof(T));
  for (std::size_t y = 0, i = 0; y < size; ++y) {
    for (std::size_t x = 0; x < size; ++x, ++i) {
      T value = texels[i];
      if (coding != Coding::kPlain) {
        value = fold(static_cast<T>(value - predicted(coding, &texels[i], x, y, size)));
      }
      for (std::size_t byte = 0; byte < sizeof(T); ++byte) {
        planes[byte * count + i] = static_cast<std::uint8_t>(value >> (8 * byte));
      }
    }
  }
  return planes;
}

template <class T>
void merge_row(const std::uint8_t* planes, std::size_t count, std::size_t size, T* row) {
  if constexpr (sizeof(T) == 2) {
    for (std::size_t x = 0; x < size; ++x) {
      row[x] = static_cast<T>(planes[x] | planes[count + x] << 8);
    }
  } else {
    for (std::size_t x = 0; x < size; ++x) {
      row[x] = planes[x] | T{planes[count + x]} << 8 | T{planes[2 * count + x]} << 16 |
               T{planes[3 * count + x]} << 24;
    }
  }
}

// Converts folded differences to texels, in place. `above` is the previous row, null for the first.
template <class T>
void restore_row(Coding coding, const T* above, std::size_t size, T* row) {
  for (std::size_t x = 0; x < size; ++x) row[x] = unfold(row[x]);
  if (above != nullptr && coding == Coding::kUp) {
    for (std::size_t x = 0; x < size; ++x) row[x] = static_cast<T>(row[x] + above[x]);
    return;
  }
  // The sum of all differences so far, kept in a register: reading row[x - 1] back would be slower.
  T sum = above != nullptr && coding == Coding::kLeft ? above[0] : T{0};
  for (std::size_t x = 0; x < size; ++x) row[x] = sum = static_cast<T>(sum + row[x]);
  if (above != nullptr && coding == Coding::kGradient) {
    for (std::size_t x = 0; x < size; ++x) row[x] = static_cast<T>(row[x] + above[x]);
  }
}

std::vector<std::uint8_t> compress_at(int level, image::Bytes bytes) {
  std::vector<std::uint8_t> frame(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compressCCtx(compressor(), frame.data(), frame.size(), bytes.data(),
                                             bytes.size(), level);
  EN_CHECK(ZSTD_isError(size) == 0);
  frame.resize(size);
  return frame;
}

}  // namespace

std::vector<std::uint8_t> compress(image::Bytes bytes) { return compress_at(kThorough, bytes); }

bool decompress(image::Bytes frame, std::span<std::uint8_t> to) {
  const std::size_t size =
      ZSTD_decompressDCtx(decompressor(), to.data(), to.size(), frame.data(), frame.size());
  return ZSTD_isError(size) == 0 && size == to.size();
}

template <class T>
CodedFace encode_texels(std::span<const T> texels, std::uint32_t size) {
  EN_CHECK_EQ(texels.size(), std::size_t{size} * size);
  std::vector<std::uint8_t> best;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  Coding chosen = Coding::kAbsent;
  for (const Coding coding : {Coding::kPlain, Coding::kLeft, Coding::kUp, Coding::kGradient}) {
    std::vector<std::uint8_t> planes = split(coding, texels, size);
    const std::size_t bytes = compress_at(kQuick, planes).size();
    if (bytes >= fewest) continue;
    fewest = bytes;
    chosen = coding;
    best = std::move(planes);
  }
  return {chosen, compress_at(kThorough, best)};
}

template <class T>
bool decode_texels(Coding coding, image::Bytes bytes, std::uint32_t size, T* texels) {
  const std::size_t n = size;
  const std::span<std::uint8_t> planes = scratch(n * n * sizeof(T));
  if (!decompress(bytes, planes)) return false;
  for (std::size_t y = 0; y < n; ++y) {
    T* row = texels + y * n;
    merge_row(planes.data() + y * n, n * n, n, row);
    if (coding != Coding::kPlain) restore_row(coding, y == 0 ? nullptr : row - n, n, row);
  }
  return true;
}

template CodedFace encode_texels(std::span<const std::uint16_t>, std::uint32_t);
template CodedFace encode_texels(std::span<const std::uint32_t>, std::uint32_t);
template bool decode_texels(Coding, image::Bytes, std::uint32_t, std::uint16_t*);
template bool decode_texels(Coding, image::Bytes, std::uint32_t, std::uint32_t*);

}  // namespace enfilade::scan::detail
