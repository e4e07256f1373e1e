#include "enfilade/scan/detail/store_writer.h"

#include <algorithm>
#include <cstring>

#include "enfilade/core/mapped_file.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/scan/store.h"

namespace enfilade::scan::detail {
namespace {

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
