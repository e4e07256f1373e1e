#include "enfilade/image/detail/block_kernels.h"

#include <algorithm>
#include <array>

namespace enfilade::image::detail {
namespace {

std::int32_t saturated16(std::int32_t value) { return std::clamp(value, -32768, 32767); }

// Sums of two 16-bit numbers wrap around, as they do in vector registers.
std::int32_t wrapped(std::int32_t value) { return static_cast<std::int16_t>(value); }

// One pass over eight numbers.
void transform8(const std::array<std::int32_t, 8>& in, int drop, std::array<std::int32_t, 8>& out) {
  using C = TransformConstants;
  const std::int32_t even2 = in[2] * C::k0541 + in[6] * (C::k0541 - C::k1847);
  const std::int32_t even3 = in[2] * (C::k0541 + C::k0765) + in[6] * C::k0541;
  const std::int32_t even0 = wrapped(in[0] + in[4]) * (1 << C::kBits);
  const std::int32_t even1 = wrapped(in[0] - in[4]) * (1 << C::kBits);
  const std::array<std::int32_t, 4> even{even0 + even3, even1 + even2, even1 - even2,
                                         even0 - even3};
  const std::int32_t z3 = wrapped(in[7] + in[3]), z4 = wrapped(in[5] + in[1]);
  const std::int32_t s3 = z3 * (C::k1175 - C::k1961) + z4 * C::k1175;
  const std::int32_t s4 = z3 * C::k1175 + z4 * (C::k1175 - C::k0390);
  const std::array<std::int32_t, 4> odd{
      in[7] * -C::k0899 + in[1] * (C::k1501 - C::k0899) + s4,
      in[5] * -C::k2562 + in[3] * (C::k3072 - C::k2562) + s3,
      in[5] * (C::k2053 - C::k2562) + in[3] * -C::k2562 + s4,
      in[7] * (C::k0298 - C::k0899) + in[1] * -C::k0899 + s3,
  };
  const std::int32_t half = 1 << (drop - 1);
  for (std::size_t k = 0; k < 4; ++k) {
    out[k] = saturated16((even[k] + odd[k] + half) >> drop);
    out[7 - k] = saturated16((even[k] - odd[k] + half) >> drop);
  }
}

void transform_one(const std::int16_t* block, std::uint8_t* out, std::size_t pitch) {
  using C = TransformConstants;
  std::array<std::array<std::int32_t, 8>, 8> columns{};
  std::array<std::int32_t, 8> in{}, row{};
  for (std::size_t x = 0; x < 8; ++x) {
    for (std::size_t y = 0; y < 8; ++y) in[y] = block[8 * y + x];
    transform8(in, C::kFirst, columns[x]);
  }
  for (std::size_t y = 0; y < 8; ++y) {
    for (std::size_t x = 0; x < 8; ++x) in[x] = columns[x][y];
    transform8(in, C::kSecond, row);
    for (std::size_t x = 0; x < 8; ++x) {
      out[y * pitch + x] = static_cast<std::uint8_t>(std::clamp(row[x], -128, 127) + 128);
    }
  }
}

void transform(const std::int16_t* blocks, std::uint8_t* first, std::uint8_t* second,
               std::size_t pitch) {
  transform_one(blocks, first, pitch);
  transform_one(blocks + 64, second, pitch);
}

void upsample(ChromaRows rows, std::size_t width, std::uint16_t* sums, std::uint8_t* out) {
  for (std::size_t x = 0; x < width; ++x) {
    sums[x + 1] = static_cast<std::uint16_t>(3 * rows.near[x] + rows.far[x]);
  }
  sums[0] = sums[1];
  sums[width + 1] = sums[width];
  for (std::size_t x = 0; x < width; ++x) {
    out[2 * x] = static_cast<std::uint8_t>((3 * sums[x + 1] + sums[x] + 8) >> 4);
    out[2 * x + 1] = static_cast<std::uint8_t>((3 * sums[x + 1] + sums[x + 2] + 7) >> 4);
  }
}

void to_rgb(const std::uint8_t* y, const std::uint8_t* cb, const std::uint8_t* cr,
            std::size_t width, std::uint8_t* rgb) {
  using C = ColourConstants;
  constexpr std::int32_t kHalf = 1 << 15;
  const auto byte = [](std::int32_t value) {
    return static_cast<std::uint8_t>(std::clamp(value, 0, 255));
  };
  for (std::size_t x = 0; x < width; ++x, rgb += 3) {
    const std::int32_t blue = cb[x] - 128, red = cr[x] - 128;
    rgb[0] = byte(y[x] + ((C::k1402 * red + kHalf) >> 16));
    rgb[1] = byte(y[x] + ((-C::k0344 * blue - C::k0714 * red + kHalf) >> 16));
    rgb[2] = byte(y[x] + ((C::k1772 * blue + kHalf) >> 16));
  }
}

}  // namespace

const BlockKernels& scalar_block_kernels() noexcept {
  static constexpr BlockKernels kKernels{transform, upsample, to_rgb};
  return kKernels;
}

}  // namespace enfilade::image::detail
