/// \file  The bytes of a store, as docs/store.md defines them: header, a record per panorama,
/// catalogue. And their writer.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/core/part_file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/detail/face_coding.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan::detail {

inline constexpr std::array<char, 8> kMagic{'\x89', 'E', 'N', 'F', '\r', '\n', '\x1a', '\n'};
inline constexpr std::array<char, 8> kRecordMagic{'P', 'A', 'N', 'O', 'R', 'A', 'M', 'A'};
inline constexpr std::uint32_t kByteOrder = 0x01020304;
inline constexpr std::uint64_t kLargestGraph = std::uint64_t{1} << 30;

/// At byte 0. Written last: until then `file_bytes` is 0.
struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint32_t version = 0;
  std::uint32_t byte_order = kByteOrder;
  std::uint64_t file_bytes = 0;
  std::uint64_t fingerprint = 0;  ///< of input and options; 0: unknown
  std::uint64_t catalogue = 0;    ///< its offset, which is the end of the records
  std::uint64_t viewpoints = 0;
  std::uint64_t scan_bytes = 0;  ///< of name_bytes, the first
  std::uint64_t name_bytes = 0;
  std::uint64_t graph_bytes = 0;       ///< connectivity JSON, compressed
  std::uint64_t graph_json_bytes = 0;  ///< and as it was
  std::uint64_t graph_checksum = 0;
  std::uint64_t catalogue_checksum = 0;  ///< all of it but the graph
  std::array<std::uint64_t, 3> reserved{};
  std::uint64_t checksum = 0;  ///< of the bytes before
};
static_assert(sizeof(Header) == 128);

/// Where a face's bytes are, the border's after them.
struct FaceEntry {
  std::uint64_t offset = 0;
  std::uint32_t bytes = 0;
  std::uint32_t border_bytes = 0;  ///< colour only
  Coding coding = Coding::kAbsent;
  std::array<std::uint8_t, 7> reserved{};
  std::uint64_t checksum = 0;  ///< of both
  std::uint64_t all_bytes() const { return std::uint64_t{bytes} + border_bytes; }
  friend bool operator==(const FaceEntry&, const FaceEntry&) = default;
};
static_assert(sizeof(FaceEntry) == 32);
using FaceEntries = std::array<FaceEntry, kLayers * kCubeFaces>;
constexpr std::size_t entry_index(Layer layer, std::size_t face) {
  return index(layer) * kCubeFaces + face;
}

/// Begins the record of a panorama; after the padding its faces follow without gaps, in the order
/// of the entries.
struct RecordHeader {
  std::array<char, 8> magic = kRecordMagic;
  std::uint32_t viewpoint = 0;
  std::uint32_t padding = 0;  ///< bytes, so that cells are aligned; part of payload_bytes
  FaceSizes sizes{};
  std::uint64_t payload_bytes = 0;
  FaceEntries faces{};
  std::uint64_t checksum = 0;  ///< of the bytes before
};
static_assert(sizeof(RecordHeader) == 816);

/// A row of the catalogue's table of viewpoints.
struct ViewpointRow {
  std::array<double, 9> world_from_panorama{};
  std::array<double, 3> position{};
  std::uint32_t name_offset = 0;  ///< among the names
  std::uint32_t name_bytes = 0;
  std::uint32_t included = 0;
  FaceSizes sizes{};
  std::uint32_t reserved = 0;
};
static_assert(sizeof(ViewpointRow) == 128);

/// The parts of a store that are read when it is opened.
struct Catalogue {
  Header header;
  std::string scan;
  std::vector<PanoramaPose> poses;
  std::vector<FaceSizes> sizes;
  std::vector<FaceEntries> faces;
  image::Bytes graph;  ///< a view of the file
};

/// XXH3, 64 bits, seed 0.
std::uint64_t checksum(image::Bytes bytes);
/// Checksum of a Header or RecordHeader: all except its last eight bytes.
template <class T>
std::uint64_t checksum_of(const T& header) {
  return checksum({reinterpret_cast<const std::uint8_t*>(&header), sizeof(T) - 8});
}

/// Reads and checks header and catalogue: after it, every offset and size lies in the file.
/// \throws InvalidInput naming `file`
Catalogue read_catalogue(image::Bytes bytes, const std::string& file);

/// The record at an offset; no value unless it is whole. Its checksum must be right. Its faces
/// (whose checksums are not compared) must lie in the file and right after one another.
std::optional<RecordHeader> read_record(image::Bytes bytes, std::uint64_t offset);

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
