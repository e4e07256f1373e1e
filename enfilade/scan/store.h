/// \file  One scan in one file: `<scan>.enfilade`, mapped into memory and shared by all processes.
/// Format: docs/store.md.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/progress.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan {

/// Version of the format, written into each file. Files of another version are refused.
inline constexpr std::uint32_t kStoreVersion = 1;

/// `<directory>/<scan>.enfilade`. \throws LookupError if `scan` is no scan id
std::filesystem::path store_file(const std::filesystem::path& directory, const std::string& scan);

/// How RGB faces are kept.
enum class ColourCoding : std::uint8_t {
  kKeep,  ///< the source's own JPEG bytes, where it has them at the wanted size; else kJpeg
  kJpeg,  ///< encoded again
  kRaw,   ///< uncompressed: decoding is a copy, a panorama takes 4.5 MiB at 512
};

/// Which parts of a scan are packed, and how.
struct PackOptions {
  ColourCoding colour = ColourCoding::kKeep;
  std::uint32_t face_size = 0;  ///< texels; 0: as the source has them; larger ones are shrunk
  int jpeg_quality = 95;        ///< 1 .. 100; 4:4:4 from 90 on
  bool included_only = true;    ///< leave out the pictures (not poses) of excluded viewpoints
  /// All layers in the renderer's memory layout (image/face_cells.h). The file is rendered from as
  /// it is, without decoding or copies. 5.7 MB of colour per panorama at 512, 3.1 MB of depth.
  bool decoded = false;
  int threads = 0;  ///< 0: all cores
};

/// The result of packing.
struct PackReport {
  std::filesystem::path file;
  std::size_t panoramas = 0;         ///< with pictures
  std::size_t resumed = 0;           ///< of them, taken from an earlier run that was killed
  std::uint64_t bytes = 0;           ///< of the file
  bool was_complete = false;         ///< the store of this input existed; nothing was done
  std::vector<std::string> without;  ///< included viewpoints that have no pictures
};

/// Packs a source into the store `<directory>/<scan>.enfilade`. The same input gives the same bytes
/// for any number of threads. Writes `<scan>.enfilade.part` and renames it when it is complete. The
/// part of a killed run is continued if input and options are the same, else overwritten.
/// \throws the source's errors; the part is kept, so that the run can be continued when the file is
/// repaired
/// \throws FileError if the directory can't be written
/// \throws ArgumentError for options out of range, or if no panorama has colour
PackReport pack(const PanoramaSource& source, const std::filesystem::path& directory,
                const PackOptions& options, const Progress& progress = {});

/// A packed scan. Opening maps the file and checks header and index; each face is compared with its
/// checksum when it is decoded, or first drawn from.
class Store final : public PanoramaSource {
 public:
  /// \throws FileError; InvalidInput if the file is not a store, is of another version, is
  /// truncated, or if its header or index was changed
  static std::shared_ptr<const Store> open(const std::filesystem::path& file);
  ~Store() override;

  Connectivity connectivity() const override;
  FaceSizes face_sizes(ViewpointIndex viewpoint) const override;
  std::optional<std::array<std::string, kCubeFaces>> colour_jpegs(
      ViewpointIndex viewpoint) const override;
  bool reads_rows(ViewpointIndex viewpoint, CubeFace face) const override;
  void read_colour_rows(ViewpointIndex viewpoint, CubeFace face, image::RowRange rows,
                        const image::ColourCells& buffer) const override;
  bool has_cells(Layer layer, ViewpointIndex viewpoint) const override;
  const std::uint8_t* cells(Layer layer, ViewpointIndex viewpoint, CubeFace face) const override;
  void release(ViewpointIndex viewpoint) const override;
  std::string state() const override;  ///< its checksums

  /// Reads everything and compares all checksums; each fault is an error with code "bad-checksum".
  std::vector<Diagnostic> verify(int threads = 0, const Progress& progress = {}) const;
  std::uint64_t bytes() const noexcept;  ///< of the file
  /// Hash of the input and options that it was packed from; 0 if unknown.
  std::uint64_t fingerprint() const noexcept;

 private:
  struct Impl;
  void read(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
            const FaceBuffers& buffers) const override;
  Store(std::unique_ptr<Impl> impl, std::string scan, std::string origin,
        std::vector<PanoramaPose> poses);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::scan
