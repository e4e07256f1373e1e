/// \file  The panoramas of a building as the colours of its surfaces.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "enfilade/continuous/scene.h"
#include "enfilade/core/ids.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::continuous {

namespace pixels {
struct Photo;
}

/// How panoramas are kept and chosen.
struct PhotographsOptions {
  /// Longest edge of a face that is kept, texels, 16 .. 2048; larger ones are halved. 256 has about
  /// as many per degree as a picture of 224 pixels over 90 degrees.
  std::uint32_t face_size = 256;
  std::size_t nearest = 4;  ///< panoramas that a view takes colours from, 1 .. 8
  /// Bytes of kept panoramas; the least recently used are dropped, and read again when they are
  /// needed. Does not change the pictures.
  std::size_t bytes = std::size_t{512} << 20U;
};

/// The panoramas of one scan. Each is read at its first use, and kept, 4 MB at 256 texels, while
/// there is room. The mesh is rendered from its eye to find the points that it shows, so that no
/// depth pictures are needed. Any thread may use it.
class Photographs {
 public:
  /// \param scene of the same building, in the same frame
  /// \throws ArgumentError for options out of range or a null pointer; LookupError if no viewpoint
  /// of the scan has pictures; as PanoramaSet::source()
  Photographs(std::shared_ptr<const scan::PanoramaSet> panoramas, ScanIndex scan,
              std::shared_ptr<const Scene> scene, const PhotographsOptions& options = {});
  ~Photographs();
  Photographs(const Photographs&) = delete;
  Photographs& operator=(const Photographs&) = delete;

  std::size_t size() const noexcept;  ///< panoramas with pictures
  const Scene& scene() const noexcept;
  /// Where each was taken, metres, world frame; in the order of the scan.
  std::span<const Vec3d> positions() const noexcept;
  /// Reads all panoramas now. \throws as PanoramaSource::read_colour()
  void load_all(int threads = 0) const;

  /// For this library. The nearest panoramas that see the eye, then others: as many as
  /// the options say. \returns how many
  std::size_t choose(Vec3d eye, std::span<std::size_t> chosen) const;
  /// For this library. \throws as load_all()
  std::shared_ptr<const pixels::Photo> photo(std::size_t k) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::continuous
