/// \file  libjpeg's own interface, which reports each of its warnings with a code. TurboJPEG's
/// reports the first one's text alone. So TurboJPEG decodes, and this decides about the rest:
/// harmless warnings, CMYK, rare subsampling. Internal.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/image/codecs.h"

namespace enfilade::image::detail {

/// One JPEG. decode() gives TurboJPEG's bytes where that reads the file. Harmless warnings are:
/// - bytes that belong to nothing before a marker, as panoramas of Samsung's phones have them
/// - odd numbers of coefficients or bits in the header of a sequential scan
/// - an unknown revision of JFIF
/// - an unknown number of Adobe's colours
/// - a broken ICC profile
///
/// All others are damage: an early end, a bad code, a missing restart marker.
class LibJpeg {
 public:
  /// Reads the header; keeps a view of `jpeg` and `file`. \throws InvalidInput
  LibJpeg(Bytes jpeg, const std::string& file);
  ~LibJpeg();
  LibJpeg(const LibJpeg&) = delete;
  LibJpeg& operator=(const LibJpeg&) = delete;

  std::uint32_t width() const;
  std::uint32_t height() const;
  /// The file's: 1 for greyscale, 4 for CMYK and YCCK, else 3.
  std::uint32_t channels() const;
  /// Progressive ones have, and some others.
  bool has_several_scans() const;

  /// RGB, 3 x width x height bytes. CMYK's ink is taken off white paper: R = (255 - C) (255 - K) /
  /// 255, likewise G and B. Adobe's files store 255 - C.
  /// \param halvings  of both edges, by halved(); the whole picture is in memory only if it has
  /// several scans  \throws InvalidInput
  void decode(std::uint8_t* rgb, unsigned halvings = 0);
  /// Reads all coefficients, without a picture. \throws InvalidInput
  void check();

  /// What decode() or check() met, as one warning with a count, at most; and a note on CMYK.
  std::vector<Diagnostic> findings() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// decode_jpeg(). Edges are halved while the picture is read, until there are at most `most`
/// pixels. \throws InvalidInput, also if one of several scans has more
Image8 decode_jpeg(Bytes jpeg, const std::string& file, std::uint64_t most,
                   std::vector<Diagnostic>* findings);

}  // namespace enfilade::image::detail
