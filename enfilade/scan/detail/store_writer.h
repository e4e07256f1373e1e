/// \file  Writes a store, panorama by panorama; a killed run can be continued.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/core/part_file.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/detail/store_format.h"

namespace enfilade::scan::detail {

/// A panorama that is to be packed.
struct PlannedPanorama {
  ViewpointIndex viewpoint;
  FaceSizes source_sizes{};  ///< of its faces, texels
  FaceSizes sizes{};         ///< that they will have in the store
};

/// A record without its place in the file: offsets count from the first byte behind its header.
struct EncodedPanorama {
  RecordHeader header;
  std::vector<std::uint8_t> payload;
};

/// Writes `<file>.part` and renames it to `<file>` when it is whole. One process at a time.
class StoreWriter {
 public:
  /// Continues a part of the same fingerprint. Keeps the whole records that are `plan`'s first, and
  /// cuts off the rest. Any other part, and any part if the fingerprint is 0, is overwritten.
  /// \throws FileError, also if another process is writing it
  StoreWriter(const std::filesystem::path& file, std::uint64_t fingerprint,
              std::span<const PlannedPanorama> plan);

  std::size_t panoramas() const noexcept { return records_.size(); }  ///< kept or appended

  void append(EncodedPanorama panorama);  ///< \throws FileError
  /// Writes the catalogue, then the header, waits for the disk and renames. Returns the size of the
  /// file. \throws FileError
  std::uint64_t finish(const Connectivity& graph);

 private:
  std::uint64_t resume(std::span<const PlannedPanorama> plan);
  void write_at(std::uint64_t offset, image::Bytes bytes);

  PartFile part_;
  std::uint64_t fingerprint_;
  std::uint64_t end_ = 0;  // of the records
  std::vector<RecordHeader> records_;
};

}  // namespace enfilade::scan::detail
