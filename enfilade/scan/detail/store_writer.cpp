#include "enfilade/scan/detail/store_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/scan/detail/mapped_file.h"
#include "enfilade/scan/store.h"

namespace enfilade::scan::detail {
namespace {

template <class T>
image::Bytes bytes_of(const T& value) {
  return {reinterpret_cast<const std::uint8_t*>(&value), sizeof(T)};
}

void add(std::vector<std::uint8_t>& to, image::Bytes bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

Header unfinished(std::uint64_t fingerprint) {
  Header header;
  header.version = kStoreVersion;
  header.fingerprint = fingerprint;
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
  for (const ViewpointRow& row : rows) add(bytes, bytes_of(row));
  for (const FaceEntries& entries : faces) add(bytes, bytes_of(entries));
  add(bytes, image::bytes_of(names));
  return bytes;
}

// A new name outlives a power cut only once its folder is on the disk; where folders can't be
// synchronised there is nothing to be done.
void synchronise_folder(const std::filesystem::path& folder) {
  const int descriptor =
      open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

void StoreWriter::fail(const char* doing) const {
  throw FileError(fmt::format("{}: cannot be {}: {}", part_.string(), doing,
                              std::generic_category().message(errno)));
}

StoreWriter::StoreWriter(std::filesystem::path file, std::uint64_t fingerprint,
                         std::span<const PlannedPanorama> plan)
    : file_(std::move(file)), part_(file_.string() + ".part"), fingerprint_(fingerprint) {
  open_locked();
  try {
    end_ = resume(plan);
    if (end_ == 0) {
      cut(0);
      end_ = sizeof(Header);
    }
    // Also over the final header of a run that was killed just before it renamed.
    write_at(0, bytes_of(unfinished(fingerprint_)));
    cut(end_);
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

StoreWriter::~StoreWriter() { close(descriptor_); }  // and with it, the lock

void StoreWriter::open_locked() {
  while (true) {
    descriptor_ = open(part_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail("written");
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      const bool busy = errno == EWOULDBLOCK;
      close(descriptor_);
      if (busy) {
        throw FileError(
            fmt::format("{}: another process is packing this scan just now", part_.string()));
      }
      fail("locked");
    }
    // Whoever held the lock may have finished and renamed the file meanwhile: then what is open is
    // the store itself.
    struct stat opened {
    }, named{};
    if (fstat(descriptor_, &opened) == 0 && stat(part_.c_str(), &named) == 0 &&
        opened.st_ino == named.st_ino && opened.st_dev == named.st_dev) {
      return;
    }
    close(descriptor_);
  }
}

// The end of the records that are kept; 0 if the part is of no use.
std::uint64_t StoreWriter::resume(std::span<const PlannedPanorama> plan) {
  const MappedFile part(part_);
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
  while (!bytes.empty()) {
    const ssize_t written =
        pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0) {
      if (errno == EINTR) continue;
      fail("written");
    }
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void StoreWriter::cut(std::uint64_t bytes) {
  if (ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) fail("cut");
}

void StoreWriter::append(EncodedPanorama panorama) {
  RecordHeader& header = panorama.header;
  for (FaceEntry& face : header.faces) {
    if (face.coding != Coding::kAbsent) face.offset += end_ + sizeof(RecordHeader);
  }
  header.payload_bytes = panorama.payload.size();
  header.checksum = checksum_of(header);
  write_at(end_, bytes_of(header));
  write_at(end_ + sizeof(RecordHeader), panorama.payload);
  end_ += sizeof(RecordHeader) + panorama.payload.size();
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
  // On the disk before the header that vouches for it.
  if (fsync(descriptor_) != 0) fail("written");
  write_at(0, bytes_of(header));
  if (fsync(descriptor_) != 0) fail("written");
  if (std::rename(part_.c_str(), file_.c_str()) != 0) fail("renamed");
  synchronise_folder(file_.parent_path());
  return header.file_bytes;
}

}  // namespace enfilade::scan::detail
