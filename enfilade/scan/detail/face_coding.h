/// \file  Lossless compression of faces of depth, classes and instances.
///
/// A face's n x n values are
/// (1) predicted from their neighbours, row by row; the difference to the prediction is stored,
/// modulo 2^bits. Differences of either sign are then
/// (2) folded to small numbers: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...,
/// (3) split into planes, all lowest bytes first, and
/// (4) compressed by zstd as one frame.
/// Source of (1) to (3): PNG's filters and Blosc's shuffle. The choices and measurements:
/// docs/design/store.md.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/image/codecs.h"

namespace enfilade::scan::detail {

/// How the bytes of a face are to be read; part of the file format (docs/store.md).
enum class Coding : std::uint8_t {
  kAbsent = 0,     ///< the panorama lacks the layer
  kJpeg = 1,       ///< colour
  kRawRgb = 2,     ///< colour
  kCells = 3,      ///< any layer: cells as image/face_cells.h has them, aligned to 64 bytes
  kPlain = 16,     ///< no prediction: steps 3 and 4 only
  kLeft = 17,      ///< by the texel to the left
  kUp = 18,        ///< by the texel above
  kGradient = 19,  ///< left + above - above left
};

struct CodedFace {
  Coding coding = Coding::kAbsent;
  std::vector<std::uint8_t> bytes;
};

/// The predictor that gives the fewest bytes. T: std::uint16_t or std::uint32_t.
/// \pre texels.size() == size * size > 0
template <class T>
CodedFace encode_texels(std::span<const T> texels, std::uint32_t size);

/// Its inverse. False if the bytes are not size * size values in that coding; `texels` then holds
/// anything. Allocates nothing once a thread has decoded a face of this size.
template <class T>
bool decode_texels(Coding coding, image::Bytes bytes, std::uint32_t size, T* texels);

/// One zstd frame.
std::vector<std::uint8_t> compress(image::Bytes bytes);
/// False unless the frame holds just as many bytes as `to`.
bool decompress(image::Bytes frame, std::span<std::uint8_t> to);

}  // namespace enfilade::scan::detail
