#include "enfilade/scan/store.h"

#include <fmt/format.h>
#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/scan/detail/face_coding.h"
#include "enfilade/scan/detail/store_format.h"

namespace enfilade::scan {

using detail::Coding;
using detail::FaceEntry;
using detail::Header;
using detail::RecordHeader;

namespace {

// A face of a store, for messages.
struct FaceName {
  const PanoramaSource& store;
  ViewpointIndex viewpoint;
  Layer layer;
  std::size_t face;
};

constexpr const char* kChanged = "its bytes differ from those that were packed";

Diagnostic fault(const FaceName& name, std::string code, std::string message) {
  return {Severity::kError, name.store.origin(),
          fmt::format("scan {}, viewpoint {}, {}, face {}", quote(name.store.scan()),
                      quote(name.store.poses()[name.viewpoint.at()].viewpoint),
                      to_string(name.layer), name.face),
          std::move(code), std::move(message)};
}

[[noreturn]] void refuse_face(const FaceName& name, std::string code, std::string message) {
  throw InvalidInput({fault(name, std::move(code), std::move(message))});
}

// Memory of this thread, as large as the largest request so far; each call ends the last one's use.
std::span<std::uint8_t> room(std::size_t bytes) {
  thread_local std::vector<std::uint8_t> memory;
  if (memory.size() < bytes) memory.resize(bytes);
  return {memory.data(), bytes};
}

}  // namespace

struct Store::Impl {
  explicit Impl(const std::filesystem::path& path)
      : file(path),
        catalogue(detail::read_catalogue(file.bytes(), path.string())),
        compared(catalogue.faces.size() * kLayers * kCubeFaces) {}

  const FaceEntry& entry(const FaceName& name) const {
    return catalogue.faces[name.viewpoint.at()][detail::entry_index(name.layer, name.face)];
  }
  // The bytes of a face and, after them, of its border, if it has one.
  image::Bytes bytes_of(const FaceEntry& entry) const {
    return file.bytes().subspan(entry.offset, entry.all_bytes());
  }
  bool is_whole(const FaceEntry& entry) const {
    return detail::checksum(bytes_of(entry)) == entry.checksum;
  }
  const FaceEntry& whole_entry(const FaceName& name) const {
    const FaceEntry& found = entry(name);
    if (!is_whole(found)) refuse_face(name, "bad-checksum", kChanged);
    return found;
  }

  std::uint32_t size_of(const PanoramaSource& store, ViewpointIndex viewpoint, Layer layer) const;
  void read_colour_rows(const FaceName& name, image::RowRange rows,
                        const image::ColourCells& face) const;
  template <class T>
  void read_face(const FaceName& name, std::uint32_t size, T* buffer) const;
  void verify_records(const std::string& origin, std::vector<Diagnostic>& faults) const;
  void verify_faces(const PanoramaSource& store, ViewpointIndex viewpoint, std::mutex& mutex,
                    std::vector<Diagnostic>& faults) const;

  MappedFile file;
  detail::Catalogue catalogue;
  std::vector<std::atomic<bool>> compared;  // faces in cells that have the checksum they should
};

std::uint32_t Store::Impl::size_of(const PanoramaSource& store, ViewpointIndex viewpoint,
                                   Layer layer) const {
  const std::uint32_t size = catalogue.sizes.at(viewpoint.at())[index(layer)];
  if (size == 0) throw store.lacks(layer, viewpoint);
  return size;
}

void Store::Impl::read_colour_rows(const FaceName& name, image::RowRange rows,
                                   const image::ColourCells& face) const {
  const FaceEntry& found = whole_entry(name);
  const image::Bytes bytes = bytes_of(found);
  if (found.coding == Coding::kCells) {  // whole faces only: reads_rows() is false
    std::ranges::copy(bytes, face.cells);
    return;
  }
  const image::Bytes picture = bytes.first(found.bytes);
  const auto write = [&](const std::uint8_t* rgb) {
    for (std::size_t y = rows.begin; y < rows.end; ++y) face.write_row(y, rgb + 3 * y * face.size);
  };
  if (found.coding == Coding::kRawRgb) {
    write(picture.data());
  } else if (!image::decode_rows(picture, rows, face)) {
    try {
      const std::span<std::uint8_t> rgb = room(3 * std::size_t{face.size} * face.size);
      image::decode_jpeg(picture, face.size, face.size, rgb, name.store.origin());
      write(rgb.data());
    } catch (const Error& error) {  // it does not name the viewpoint
      refuse_face(name, "damaged-face", error.what());
    }
  }
  const std::span<std::uint8_t> border = room(3 * image::border_texels(face.size));
  if (!detail::decompress(bytes.subspan(found.bytes), border)) {
    refuse_face(name, "damaged-face", "its border cannot be decompressed");
  }
  image::write_border_rows(face, border, rows.begin, rows.end);
}

template <class T>
void Store::Impl::read_face(const FaceName& name, std::uint32_t size, T* buffer) const {
  const FaceEntry& found = whole_entry(name);
  if (found.coding == Coding::kCells) {
    return image::ValueCells<T>::to_rows(bytes_of(found).data(), size, buffer);
  }
  if (!detail::decode_texels(found.coding, bytes_of(found), size, buffer)) {
    refuse_face(name, "damaged-face",
                fmt::format("cannot be decompressed to {} x {} values", size, size));
  }
}

// Checks that the records follow each other without gaps up to the catalogue and agree with it.
void Store::Impl::verify_records(const std::string& origin, std::vector<Diagnostic>& faults) const {
  std::uint64_t at = sizeof(Header);
  const auto report = [&](std::string message) {
    faults.push_back({Severity::kError, origin, fmt::format("record at byte {}", at),
                      "bad-checksum", std::move(message)});
  };
  std::vector<bool> seen(catalogue.faces.size(), false);
  while (at < catalogue.header.catalogue) {
    const auto record = detail::read_record(file.bytes().first(catalogue.header.catalogue), at);
    if (!record) return report("its header was changed");
    const std::size_t viewpoint = record->viewpoint;
    if (viewpoint >= seen.size() || seen[viewpoint] ||
        record->faces != catalogue.faces[viewpoint] ||
        record->sizes != catalogue.sizes[viewpoint]) {
      return report("its header and the catalogue differ");
    }
    seen[viewpoint] = true;
    at += sizeof(RecordHeader) + record->payload_bytes;
  }
  for (std::size_t v = 0; v < seen.size(); ++v) {
    if (seen[v] == (catalogue.sizes[v] == FaceSizes{})) {
      report(fmt::format("viewpoint {} has no record, or one without pictures", v));
    }
  }
}

void Store::Impl::verify_faces(const PanoramaSource& store, ViewpointIndex viewpoint,
                               std::mutex& mutex, std::vector<Diagnostic>& faults) const {
  for (std::size_t l = 0; l < kLayers; ++l) {
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      const FaceName name{store, viewpoint, static_cast<Layer>(l), k};
      const FaceEntry& found = entry(name);
      if (found.coding == Coding::kAbsent || is_whole(found)) continue;
      const std::scoped_lock lock(mutex);
      faults.push_back(fault(name, "bad-checksum", kChanged));
    }
  }
}

std::filesystem::path store_file(const std::filesystem::path& directory, const std::string& scan) {
  require_scan_id(scan);
  return directory / (scan + ".enfilade");
}

Store::Store(std::unique_ptr<Impl> impl, std::string scan, std::string origin,
             std::vector<PanoramaPose> poses)
    : PanoramaSource(std::move(scan), std::move(origin), std::move(poses)),
      impl_(std::move(impl)) {}

Store::~Store() = default;

std::shared_ptr<const Store> Store::open(const std::filesystem::path& file) {
  auto impl = std::make_unique<Impl>(file);
  std::string scan = impl->catalogue.scan;
  std::vector<PanoramaPose> poses = std::move(impl->catalogue.poses);
  return std::shared_ptr<Store>(
      new Store(std::move(impl), std::move(scan), file.string(), std::move(poses)));
}

Connectivity Store::connectivity() const {
  if (detail::checksum(impl_->catalogue.graph) != impl_->catalogue.header.graph_checksum) {
    refuse(origin(), "graph", "bad-checksum", kChanged);
  }
  std::vector<std::uint8_t> json(impl_->catalogue.header.graph_json_bytes);
  if (!detail::decompress(impl_->catalogue.graph, json)) {
    refuse(origin(), "graph", "bad-index",
           "cannot be decompressed to the size that the header states");
  }
  Connectivity graph = parse_connectivity({reinterpret_cast<const char*>(json.data()), json.size()},
                                          scan(), origin());
  if (!std::ranges::equal(graph.entries, poses(), {}, &ConnectivityEntry::id,
                          &PanoramaPose::viewpoint)) {
    refuse(origin(), "graph", "bad-index", "its viewpoints are not those of the catalogue");
  }
  return graph;
}

FaceSizes Store::face_sizes(ViewpointIndex viewpoint) const {
  return impl_->catalogue.sizes.at(viewpoint.at());
}

void Store::read(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
                 const FaceBuffers& buffers) const {
  const std::uint32_t size = impl_->size_of(*this, viewpoint, layer);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    if ((wanted >> k & 1) == 0) continue;
    const FaceName name{*this, viewpoint, layer, k};
    if (const auto* colour = std::get_if<ColourFaces>(&buffers)) {
      EN_CHECK_EQ((*colour)[k].size, size);
      impl_->read_colour_rows(name, {0, size}, (*colour)[k]);
    } else if (const auto* values = std::get_if<Faces16>(&buffers)) {
      impl_->read_face(name, size, (*values)[k]);
    } else {
      impl_->read_face(name, size, std::get<Faces32>(buffers)[k]);
    }
  }
}

std::optional<std::array<std::string, kCubeFaces>> Store::colour_jpegs(
    ViewpointIndex viewpoint) const {
  impl_->size_of(*this, viewpoint, Layer::kColour);
  std::array<std::string, kCubeFaces> jpegs;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const FaceEntry& found = impl_->whole_entry({*this, viewpoint, Layer::kColour, k});
    if (found.coding != Coding::kJpeg) return std::nullopt;
    const image::Bytes bytes = impl_->bytes_of(found);
    jpegs[k].assign(reinterpret_cast<const char*>(bytes.data()), found.bytes);
  }
  return jpegs;
}

bool Store::reads_rows(ViewpointIndex viewpoint, CubeFace face) const {
  const FaceEntry& found = impl_->entry({*this, viewpoint, Layer::kColour, index(face)});
  return found.coding == Coding::kJpeg &&
         image::has_marked_rows(impl_->bytes_of(found).first(found.bytes));
}

void Store::read_colour_rows(ViewpointIndex viewpoint, CubeFace face, image::RowRange rows,
                             const image::ColourCells& buffer) const {
  EN_CHECK_EQ(buffer.size, impl_->size_of(*this, viewpoint, Layer::kColour));
  impl_->read_colour_rows({*this, viewpoint, Layer::kColour, index(face)}, rows, buffer);
}

bool Store::has_cells(Layer layer, ViewpointIndex viewpoint) const {
  return impl_->entry({*this, viewpoint, layer, 0}).coding == Coding::kCells;
}

const std::uint8_t* Store::cells(Layer layer, ViewpointIndex viewpoint, CubeFace face) const {
  const FaceName name{*this, viewpoint, layer, index(face)};
  const FaceEntry& found = impl_->entry(name);
  EN_CHECK(found.coding == Coding::kCells);
  // The whole face is read for its checksum, so once is enough: a change of the file after that is
  // as one of the memory of any other program.
  auto& compared = impl_->compared[viewpoint.at() * kLayers * kCubeFaces +
                                   detail::entry_index(layer, index(face))];
  if (!compared.load(std::memory_order_relaxed)) {
    impl_->whole_entry(name);
    compared.store(true, std::memory_order_relaxed);
  }
  return impl_->bytes_of(found).data();  // the catalogue follows the faces
}

// The faces of a viewpoint follow each other in its record.
void Store::release(ViewpointIndex viewpoint) const {
  std::uint64_t begin = bytes();
  std::uint64_t end = 0;
  for (const FaceEntry& face : impl_->catalogue.faces.at(viewpoint.at())) {
    if (face.coding == Coding::kAbsent) continue;
    begin = std::min(begin, face.offset);
    end = std::max(end, face.offset + face.all_bytes());
  }
  if (begin < end) impl_->file.give_back(begin, end - begin);
}

std::string Store::state() const {
  const Header& header = impl_->catalogue.header;
  return fmt::format("{:016x} {:016x}", header.catalogue_checksum, header.graph_checksum);
}

std::vector<Diagnostic> Store::verify(int threads, const Progress& progress) const {
  std::vector<Diagnostic> faults;
  try {
    connectivity();
  } catch (const InvalidInput& error) {
    faults = error.diagnostics();
  }
  impl_->verify_records(origin(), faults);
  std::mutex mutex;
  // Number of panoramas between two reports of progress.
  constexpr std::size_t kWindow = 64;
  for (std::size_t begin = 0; begin < size(); begin += kWindow) {
    const std::size_t count = std::min(kWindow, size() - begin);
    parallel_for(count, 1, threads, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        impl_->verify_faces(*this, ViewpointIndex(begin + i), mutex, faults);
      }
    });
    if (progress) progress(begin + count, size());
  }
  // The same list at any number of threads.
  std::ranges::stable_sort(faults, {}, &Diagnostic::where);
  return faults;
}

std::uint64_t Store::bytes() const noexcept { return impl_->file.bytes().size(); }
std::uint64_t Store::fingerprint() const noexcept { return impl_->catalogue.header.fingerprint; }

}  // namespace enfilade::scan
