#include "enfilade/scan/detail/store_format.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "enfilade/core/errors.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/scan/store.h"

namespace enfilade::scan::detail {
namespace {

// --- reading ---

// \pre offset + sizeof(T) <= bytes.size()
template <class T>
T read_at(image::Bytes bytes, std::uint64_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

Header read_header(image::Bytes bytes, const std::string& file) {
  if (bytes.size() < sizeof(Header)) {
    refuse(file, "header", "truncated",
           fmt::format("{} bytes; a store has {} at least", bytes.size(), sizeof(Header)));
  }
  const auto header = read_at<Header>(bytes, 0);
  if (header.magic != kMagic) {
    refuse(file, "header", "not-a-store", "does not begin as an Enfilade store does");
  }
  if (header.byte_order != kByteOrder) {
    refuse(file, "header", "wrong-byte-order",
           "was damaged, or written on a machine of another byte order; pack it there anew");
  }
  if (header.version != kStoreVersion) {
    refuse(file, "header", "wrong-version",
           fmt::format("version {} of the format; this program reads version {}: pack it anew",
                       header.version, kStoreVersion));
  }
  if (header.checksum != checksum_of(header)) {
    refuse(file, "header", "bad-checksum", "the header was changed; pack it anew");
  }
  if (header.file_bytes == 0) {
    refuse(file, "header", "unfinished", "packing was not finished; run it again");
  }
  if (header.file_bytes != bytes.size()) {
    refuse(file, "header", "truncated",
           fmt::format("{} bytes, not the {} that it was written with", bytes.size(),
                       header.file_bytes));
  }
  return header;
}

// Whether the parts of the catalogue fill the rest of the file. Subtracts, to avoid overflow.
bool parts_fit(const Header& header) {
  const std::uint64_t end = header.file_bytes;
  if (header.catalogue < sizeof(Header) || header.catalogue > end) return false;
  std::uint64_t room = end - header.catalogue;
  constexpr std::uint64_t kRow = sizeof(ViewpointRow) + sizeof(FaceEntries);
  if (header.viewpoints > room / kRow) return false;
  room -= header.viewpoints * kRow;
  if (header.name_bytes > room || header.scan_bytes > header.name_bytes) return false;
  room -= header.name_bytes;
  return header.graph_bytes == room && header.graph_json_bytes <= kLargestGraph;
}

// The parts of the catalogue, in the order of the file.
struct Parts {
  image::Bytes rows, faces, names, graph;
};

Parts split_parts(image::Bytes bytes, const Header& header, const std::string& file) {
  if (!parts_fit(header)) {
    refuse(file, "header", "bad-index", "the parts of its catalogue don't fill the file");
  }
  auto part = [&, at = header.catalogue](std::uint64_t size) mutable {
    at += size;
    return bytes.subspan(at - size, size);
  };
  Parts parts;
  parts.rows = part(header.viewpoints * sizeof(ViewpointRow));
  parts.faces = part(header.viewpoints * sizeof(FaceEntries));
  parts.names = part(header.name_bytes);
  parts.graph = part(header.graph_bytes);
  const std::size_t checked = parts.rows.size() + parts.faces.size() + parts.names.size();
  if (checksum({parts.rows.data(), checked}) != header.catalogue_checksum) {
    refuse(file, "catalogue", "bad-checksum", "the catalogue was changed; pack it anew");
  }
  return parts;
}

std::string_view name_at(image::Bytes names, std::uint64_t offset, std::uint64_t size) {
  if (size == 0 || offset > names.size() || size > names.size() - offset) return {};
  return {reinterpret_cast<const char*>(names.data()) + offset, size};
}

// Describes what is wrong with a row; empty if it is valid.
std::string fault_of(const ViewpointRow& row, std::string_view name) {
  if (name.empty()) return "its id lies outside the names";
  if (row.included > 1) return fmt::format("included is {}, not 0 or 1", row.included);
  for (const double metres : row.position) {
    if (!(std::abs(metres) <= kMostMetres))
      return fmt::format("{} is no position in metres", metres);
  }
  return {};
}

bool is_possible(Coding coding, Layer layer) {
  if (coding == Coding::kCells) return true;
  if (layer == Layer::kColour) return coding == Coding::kJpeg || coding == Coding::kRawRgb;
  return coding >= Coding::kPlain && coding <= Coding::kGradient;
}

std::string fault_of(const FaceEntry& entry, Layer layer, std::uint64_t size, std::uint64_t end) {
  if (size == 0) return entry == FaceEntry{} ? "" : "is listed, but the panorama lacks the layer";
  const std::uint64_t all = entry.all_bytes();
  if (entry.offset < sizeof(Header) || entry.offset > end || all > end - entry.offset) {
    return "lies outside the records";
  }
  if (!is_possible(entry.coding, layer)) {
    return fmt::format("has the unknown coding {}", static_cast<int>(entry.coding));
  }
  if (entry.coding == Coding::kRawRgb && entry.bytes != 3 * size * size) {
    return fmt::format("is {} bytes of raw colour, not {}", entry.bytes, 3 * size * size);
  }
  if (entry.coding == Coding::kCells) {
    const std::uint64_t cells = cells_bytes(layer, static_cast<std::uint32_t>(size));
    if (entry.bytes != cells || entry.border_bytes != 0) {
      return fmt::format("is {} bytes of cells, not {}", all, cells);
    }
    if (entry.offset % image::kCellBytes != 0) return "has cells that are not aligned to 64 bytes";
  }
  if (layer != Layer::kColour && entry.border_bytes != 0) return "has a border, as colour only may";
  return {};
}

// What is wrong with a panorama's sizes and faces; empty if they are possible: known codings, faces
// between the header and `end`.
std::string fault_of(const FaceSizes& sizes, const FaceEntries& faces, std::uint64_t end) {
  for (std::size_t l = 0; l < kLayers; ++l) {
    const auto layer = static_cast<Layer>(l);
    if (sizes[l] > image::kLargestCellFace) {
      return fmt::format("{}: faces of {} texels, more than {}", to_string(layer), sizes[l],
                         image::kLargestCellFace);
    }
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      const std::string fault = fault_of(faces[entry_index(layer, k)], layer, sizes[l], end);
      if (!fault.empty()) return fmt::format("{}, face {}: {}", to_string(layer), k, fault);
    }
  }
  return {};
}

// --- writing ---

template <class T>
image::Bytes object_bytes(const T& value) {
  return {reinterpret_cast<const std::uint8_t*>(&value), sizeof(T)};
}

void add(std::vector<std::uint8_t>& to, image::Bytes bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

Header unfinished(std::uint64_t fingerprint) {
  Header header{.version = kStoreVersion, .fingerprint = fingerprint};
  header.checksum = checksum_of(header);
  return header;
}

// Rows, faces and names, in the order of the file; the scan's id is the first name.
std::vector<std::uint8_t> catalogue_of(const Connectivity& graph,
                                       std::span<const RecordHeader> records,
                                       std::uint64_t& name_bytes) {
  const std::vector<PanoramaPose> poses = poses_of(graph);
  std::vector<ViewpointRow> rows(poses.size());
  std::vector<FaceEntries> faces(poses.size());
  std::string names = graph.scan;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const PanoramaPose& pose = poses[i];
    rows[i].world_from_panorama = pose.world_from_panorama.m;
    rows[i].position = {pose.position.x, pose.position.y, pose.position.z};
    rows[i].name_offset = static_cast<std::uint32_t>(names.size());
    rows[i].name_bytes = static_cast<std::uint32_t>(pose.viewpoint.size());
    rows[i].included = pose.included ? 1 : 0;
    names += pose.viewpoint;
  }
  for (const RecordHeader& record : records) {
    rows[record.viewpoint].sizes = record.sizes;
    faces[record.viewpoint] = record.faces;
  }
  name_bytes = names.size();
  std::vector<std::uint8_t> bytes;
  for (const ViewpointRow& row : rows) add(bytes, object_bytes(row));
  for (const FaceEntries& entries : faces) add(bytes, object_bytes(entries));
  add(bytes, image::bytes_of(names));
  return bytes;
}

}  // namespace

std::uint64_t checksum(image::Bytes bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

Catalogue read_catalogue(image::Bytes bytes, const std::string& file) {
  Catalogue result;
  result.header = read_header(bytes, file);
  const Parts parts = split_parts(bytes, result.header, file);
  result.graph = parts.graph;
  result.scan = name_at(parts.names, 0, result.header.scan_bytes);
  if (std::string fault = fault_of_id(result.scan); !fault.empty()) {
    refuse(file, "catalogue", "bad-id", std::move(fault));
  }
  // As Connectivity, since poses_of() checks the rotations.
  Connectivity rows{result.scan, file, {}};
  std::set<std::string_view> seen;
  for (std::uint64_t i = 0; i < result.header.viewpoints; ++i) {
    const auto row = read_at<ViewpointRow>(parts.rows, i * sizeof(ViewpointRow));
    const auto& faces =
        result.faces.emplace_back(read_at<FaceEntries>(parts.faces, i * sizeof(FaceEntries)));
    const std::string_view name = name_at(parts.names, row.name_offset, row.name_bytes);
    std::string fault = fault_of(row, name);
    if (fault.empty() && !seen.insert(name).second)
      fault = fmt::format("{} stands twice", quote(name));
    if (fault.empty()) fault = fault_of(row.sizes, faces, result.header.catalogue);
    const std::string where = fmt::format("viewpoint {}", i);
    if (!fault.empty()) refuse(file, where, "bad-index", fault);
    if (fault = fault_of_id(name); !fault.empty()) refuse(file, where, "bad-id", fault);
    const auto& [x, y, z] = row.position;
    rows.entries.push_back({.id = std::string(name),
                            .pose = pose_matrix({row.world_from_panorama}, {x, y, z}),
                            .included = row.included == 1,
                            .height = 0,
                            .unobstructed = {},
                            .visible = {}});
    result.sizes.push_back(row.sizes);
  }
  result.poses = poses_of(rows);
  return result;
}

std::optional<RecordHeader> read_record(image::Bytes bytes, std::uint64_t offset) {
  if (offset > bytes.size() || bytes.size() - offset < sizeof(RecordHeader)) return std::nullopt;
  const auto record = read_at<RecordHeader>(bytes, offset);
  if (record.magic != kRecordMagic || record.checksum != checksum_of(record)) return std::nullopt;
  if (!fault_of(record.sizes, record.faces, bytes.size()).empty()) return std::nullopt;
  if (record.padding >= image::kCellBytes) return std::nullopt;
  std::uint64_t next = offset + sizeof(RecordHeader) + record.padding;
  for (const FaceEntry& entry : record.faces) {
    if (entry.coding == Coding::kAbsent) continue;
    if (entry.offset != next) return std::nullopt;
    next += entry.all_bytes();
  }
  if (next != offset + sizeof(RecordHeader) + record.payload_bytes) return std::nullopt;
  return record;
}

StoreWriter::StoreWriter(const std::filesystem::path& file, std::uint64_t fingerprint,
                         std::span<const PlannedPanorama> plan)
    : part_(file), fingerprint_(fingerprint) {
  end_ = resume(plan);
  if (end_ == 0) {
    part_.resize(0);
    end_ = sizeof(Header);
  }
  // Replaces also the final header of a run that was killed before it renamed the file.
  write_at(0, object_bytes(unfinished(fingerprint_)));
  part_.resize(end_);
}

// The end of the records that are kept; 0 if the part cannot be used.
std::uint64_t StoreWriter::resume(std::span<const PlannedPanorama> plan) {
  const MappedFile part(part_.path());
  const image::Bytes bytes = part.bytes();
  Header header;
  if (fingerprint_ == 0 || bytes.size() < sizeof(Header)) return 0;
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (header.magic != kMagic || header.byte_order != kByteOrder ||
      header.version != kStoreVersion || header.fingerprint != fingerprint_ ||
      header.checksum != checksum_of(header)) {
    return 0;
  }
  std::uint64_t at = sizeof(Header);
  for (const PlannedPanorama& planned : plan) {
    const auto record = read_record(bytes, at);
    if (!record || record->viewpoint != planned.viewpoint.value || record->sizes != planned.sizes) {
      break;
    }
    bool whole = true;
    for (const FaceEntry& face : record->faces) {
      whole = whole && (face.coding == Coding::kAbsent ||
                        checksum(bytes.subspan(face.offset, face.all_bytes())) == face.checksum);
    }
    if (!whole) break;
    records_.push_back(*record);
    at += sizeof(RecordHeader) + record->payload_bytes;
  }
  return at;
}

void StoreWriter::write_at(std::uint64_t offset, image::Bytes bytes) {
  part_.write_at(offset, std::as_bytes(bytes));
}

void StoreWriter::append(EncodedPanorama panorama) {
  RecordHeader& header = panorama.header;
  std::uint64_t payload = end_ + sizeof(RecordHeader);
  if (std::ranges::find(header.faces, Coding::kCells, &FaceEntry::coding) != header.faces.end()) {
    header.padding = static_cast<std::uint32_t>((image::kCellBytes - payload % image::kCellBytes) %
                                                image::kCellBytes);
    payload += header.padding;
  }
  for (FaceEntry& face : header.faces) {
    if (face.coding != Coding::kAbsent) face.offset += payload;
  }
  header.payload_bytes = header.padding + panorama.payload.size();
  header.checksum = checksum_of(header);
  write_at(end_, object_bytes(header));
  write_at(payload, panorama.payload);
  end_ = payload + panorama.payload.size();
  records_.push_back(header);
}

std::uint64_t StoreWriter::finish(const Connectivity& graph) {
  Header header = unfinished(fingerprint_);
  const std::vector<std::uint8_t> catalogue = catalogue_of(graph, records_, header.name_bytes);
  const std::string json = to_json(graph);
  const std::vector<std::uint8_t> packed_json = compress(image::bytes_of(json));
  header.catalogue = end_;
  header.viewpoints = graph.entries.size();
  header.scan_bytes = graph.scan.size();
  header.graph_bytes = packed_json.size();
  header.graph_json_bytes = json.size();
  header.graph_checksum = checksum(packed_json);
  header.catalogue_checksum = checksum(catalogue);
  header.file_bytes = end_ + catalogue.size() + packed_json.size();
  header.checksum = checksum_of(header);
  write_at(end_, catalogue);
  write_at(end_ + catalogue.size(), packed_json);
  part_.synchronise();  // before the header that declares it complete
  write_at(0, object_bytes(header));
  part_.finish();
  return header.file_bytes;
}

}  // namespace enfilade::scan::detail
