/// \file  From coefficients to pixels: the inner loops of decoding a JPEG, which give the bytes
/// that libjpeg-turbo gives. Internal.
#pragma once
#include <cstddef>
#include <cstdint>

namespace enfilade::image::detail {

/// The rows of chroma of half the resolution around a row of pixels.
struct ChromaRows {
  const std::uint8_t* near = nullptr;  ///< the row of chroma that the pixels lie in
  const std::uint8_t* far = nullptr;   ///< the next one, above or below
};

/// Rows passed to these have kRowSlack bytes behind them that may be read and written.
struct BlockKernels {
  static constexpr std::size_t kRowSlack = 64;

  /// The inverse cosine transform of two blocks, each of 64 dequantized coefficients in rows, into
  /// 8 rows of 8 pixels each.
  void (*transform)(const std::int16_t* blocks, std::uint8_t* first, std::uint8_t* second,
                    std::size_t pitch);
  /// Twice as many columns, by the mean with weights 3/4 and 1/4 both ways. \param width of chroma,
  /// at least 1  \param sums room for width + 2 + kRowSlack values
  void (*upsample)(ChromaRows rows, std::size_t width, std::uint16_t* sums, std::uint8_t* out);
  /// Y Cb Cr to R G B.
  void (*to_rgb)(const std::uint8_t* y, const std::uint8_t* cb, const std::uint8_t* cr,
                 std::size_t width, std::uint8_t* rgb);
};

/// For the processor's instruction set; the same bytes as the scalar ones.
const BlockKernels& block_kernels() noexcept;
/// Their plain twins.
const BlockKernels& scalar_block_kernels() noexcept;

/// Constants of the "slow integer" transform (libjpeg's jidctint.c: Loeffler, Ligtenberg and
/// Moschytz 1989), in 8192ths.
struct TransformConstants {
  static constexpr int kBits = 13;
  static constexpr int kFirst = kBits - 2;       ///< bits that the first pass drops
  static constexpr int kSecond = kBits + 2 + 3;  ///< and the second
  static constexpr std::int16_t k0298 = 2446, k0390 = 3196, k0541 = 4433, k0765 = 6270,
                                k0899 = 7373, k1175 = 9633, k1501 = 12299, k1847 = 15137,
                                k1961 = 16069, k2053 = 16819, k2562 = 20995, k3072 = 25172;
};

/// Constants of the conversion of colours, in 65536ths (libjpeg's jdcolor.c): R = Y + 1.402 Cr, G =
/// Y - 0.34414 Cb - 0.71414 Cr, B = Y + 1.772 Cb.
struct ColourConstants {
  static constexpr std::int32_t k0344 = 22554, k0714 = 46802, k1402 = 91881, k1772 = 116130;
};

}  // namespace enfilade::image::detail
