/// \file  JPEGs whose rows of blocks begin after restart markers (ITU-T T.81, B.2.1): each row can
/// be decoded without those before it. So a thread decodes several rows in turn, coefficient by
/// coefficient, while the processor waits for none of them, and threads can share a picture. Why:
/// docs/design/store.md.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/image/codecs.h"
#include "enfilade/image/face_cells.h"

namespace enfilade::image {

/// The same picture, coefficient by coefficient, as a baseline JPEG with a restart marker between
/// rows of blocks (16 rows of pixels at 4:2:0, 8 at 4:4:4). 0.1 to 0.2 % longer if it was baseline
/// before; its comments and camera data are left out unless it was baseline. No value if its codes
/// cannot be written so. Allocates. \throws InvalidInput for a broken file, naming `file`
std::optional<std::vector<std::uint8_t>> mark_rows(Bytes jpeg, const std::string& file);

/// Rows begin .. end - 1 of a face.
struct RowRange {
  std::uint32_t begin = 0, end = 0;
};

/// Whether the file may be one of mark_rows() for decode_rows(): reads its headers only.
bool has_marked_rows(Bytes jpeg);
/// Decodes rows of a face, without its border, to the bytes that decode_jpeg() gives. Bytes may
/// differ for coefficients that no encoder writes. False if the file is not one of mark_rows(), is
/// damaged, or is not a square of the face's size in colour at 4:2:0 or 4:4:4. Then decode_jpeg()
/// reads it or reports its fault, and the rows are unspecified. Ranges of the same face that share
/// no row may be decoded at the same time. After a thread's first call for a size nothing is
/// allocated.
/// \pre rows.begin < rows.end <= face.size
bool decode_rows(Bytes jpeg, RowRange rows, const ColourCells& face);

}  // namespace enfilade::image
