// Panoramas and Renderer: images into the caller's memory, or into memory that is reused.

#include <dlfcn.h>
#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/enum_names.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/render/devices.h"
#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_set.h"
#include "python/src/bindings.h"
#include "python/src/errors.h"

namespace enfilade::python {
namespace {

using scan::PanoramaSet;
using namespace nb::literals;

/// Memory of any library that supports DLPack: NumPy, torch, CuPy. On the CPU, or on a GPU for the
/// back end that draws there: check_device().
using Buffer = nb::ndarray<nb::c_contig>;

Origins<PanoramaSet, scan::PanoramaPlaces>& places() {
  static Origins<PanoramaSet, scan::PanoramaPlaces> known;
  return known;
}

std::shared_ptr<const PanoramaSet> open_of_scans(const std::vector<std::filesystem::path>& images,
                                                 const std::filesystem::path& connectivity,
                                                 const std::vector<std::string>& scans) {
  const scan::PanoramaPlaces where{images, connectivity};
  auto set = PanoramaSet::open(where, scans);
  places().put(set, where);
  return set;
}

std::shared_ptr<const PanoramaSet> open_panoramas(const std::vector<std::filesystem::path>& images,
                                                  const std::filesystem::path& connectivity,
                                                  const graph::GraphSet& graphs) {
  return open_of_scans(images, connectivity, graphs.scans());
}

// Panoramas are opened again, or come from their data set.
nb::tuple reduce_panoramas(nb::handle self) {
  const auto& set = nb::cast<const PanoramaSet&>(self);
  if (nb::hasattr(self, "_folder")) {
    return nb::make_tuple(nb::module_::import_("enfilade._dataset").attr("_panoramas_of"),
                          nb::make_tuple(self.attr("_folder")));
  }
  if (const scan::PanoramaPlaces* where = places().find(set)) {
    return nb::make_tuple(nb::module_::import_("enfilade._renderer").attr("_panoramas_again"),
                          nb::make_tuple(where->images, where->connectivity, set.scans()));
  }
  throw nb::type_error("these panoramas are of no folder: pickle their Dataset");
}

/// The poses of n views: arrays that each rendering reads. Converting arrays from Python costs
/// about as much as the rest of a call, so arrays for every step are converted once.
class ViewArrays {
 public:
  ViewArrays(Row<std::uint32_t> scans, Row<std::uint32_t> viewpoints, Row<double> headings,
             Row<double> elevations)
      : scans_(std::move(scans)),
        viewpoints_(std::move(viewpoints)),
        headings_(std::move(headings)),
        elevations_(std::move(elevations)) {
    const std::size_t n = scans_.size();
    if (viewpoints_.size() != n || headings_.size() != n || elevations_.size() != n) {
      throw ArgumentError(fmt::format("views: {} scans, {} viewpoints, {} headings, {} elevations",
                                      n, viewpoints_.size(), headings_.size(), elevations_.size()));
    }
  }

  std::size_t size() const { return scans_.size(); }
  render::View operator[](std::size_t i) const {
    return {ScanIndex(scans_.data()[i]), ViewpointIndex(viewpoints_.data()[i]),
            Radians(headings_.data()[i]), Radians(elevations_.data()[i])};
  }

 private:
  Row<std::uint32_t> scans_;
  Row<std::uint32_t> viewpoints_;
  Row<double> headings_;
  Row<double> elevations_;
};

constexpr std::align_val_t kAlignment{64};  // a cache line
constexpr std::size_t kKept = 4;            // colour, depth, classes, instances of one step

struct Free {
  void operator()(std::byte* memory) const { ::operator delete(memory, kAlignment); }
};

/// Memory and its size.
struct Piece {
  std::size_t bytes = 0;
  std::unique_ptr<std::byte, Free> memory;
};

struct Type {
  const char* name;
  nb::dlpack::dtype type;
};
const std::array<Type, 4> kTypes{{{"uint8", nb::dtype<std::uint8_t>()},
                                  {"uint16", nb::dtype<std::uint16_t>()},
                                  {"uint32", nb::dtype<std::uint32_t>()},
                                  {"float32", nb::dtype<float>()}}};

/// Memory of NumPy arrays, reused after the last view of them is gone: zeroing new pages would take
/// the system a fifth of the drawing time. Keeps that of the last few arrays. Any thread.
class PictureMemory : public std::enable_shared_from_this<PictureMemory> {
 public:
  PictureMemory() { pieces_.reserve(kKept); }  // so that give_back() cannot fail

  /// Its content is undefined. \param type "uint8", "uint16", "uint32" or "float32"
  /// \throws ArgumentError for another type; std::bad_alloc
  nb::object array(std::span<const std::size_t> shape, const std::string& type) {
    const auto* known = std::ranges::find(kTypes, type, &Type::name);
    if (known == kTypes.end()) throw ArgumentError("type '" + type + "' is none of a picture's");
    const std::size_t values =
        std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies());
    auto block =
        std::make_unique<Block>(Block{shared_from_this(), take(values * known->type.bits / 8)});
    std::byte* memory = block->piece.memory.get();
    const nb::capsule owner(block.release(), [](void* p) noexcept {
      const std::unique_ptr<Block> gone(static_cast<Block*>(p));
      gone->store->give_back(std::move(gone->piece));
    });
    return nb::cast(
        nb::ndarray<nb::numpy>(memory, shape.size(), shape.data(), owner, nullptr, known->type));
  }

 private:
  /// The owner of an array's memory.
  struct Block {
    std::shared_ptr<PictureMemory> store;
    Piece piece;
  };

  Piece take(std::size_t bytes) {
    {
      const std::scoped_lock lock(mutex_);
      const auto found = std::ranges::find(pieces_, bytes, &Piece::bytes);
      if (found != pieces_.end()) {
        Piece piece = std::move(*found);
        pieces_.erase(found);
        return piece;
      }
    }
    return {bytes, std::unique_ptr<std::byte, Free>(
                       static_cast<std::byte*>(::operator new(bytes, kAlignment)))};
  }
  void give_back(Piece piece) {
    const std::scoped_lock lock(mutex_);
    if (pieces_.size() == kKept) pieces_.erase(pieces_.begin());
    pieces_.push_back(std::move(piece));
  }

  std::mutex mutex_;
  std::vector<Piece> pieces_;  // released, the latest last
};

void check_device(const std::optional<Buffer>& buffer, const char* name, render::Backend backend) {
  namespace device = nb::device;
  if (!buffer || buffer->device_type() == device::cpu::value) return;
  const bool cuda = backend == render::Backend::kCuda;
  if (cuda && buffer->device_type() == device::cuda::value) return;
  throw ArgumentError(
      fmt::format("out['{}']: memory of a device, but the back end {} draws into the "
                  "CPU's{}",
                  name, enum_name(backend), cuda ? " or a card of CUDA's" : ""));
}

template <class T>
std::span<T> memory_of(const Buffer& buffer) {
  return {static_cast<T*>(buffer.data()), buffer.nbytes() / sizeof(T)};
}

template <class T>
bool holds(const Buffer& buffer) {
  return buffer.dtype() == nb::dtype<T>();
}

render::ColourOutput colour_output(const Buffer& buffer, const std::string& format) {
  using enum render::ColourFormat;
  const std::span<std::byte> memory = memory_of<std::byte>(buffer);
  const bool bytes = holds<std::uint8_t>(buffer);
  if (bytes && format == "rgb8") return {kRgb8, {}, memory};
  if (bytes && format == "bgr8") return {kBgr8, {}, memory};
  if (bytes && format == "rgba8") return {kRgba8, {}, memory};
  const bool imagenet = format == "imagenet", planar = imagenet || format == "planar";
  const auto normalisation = imagenet ? render::kImageNet : render::Normalisation{};
  if (planar && holds<float>(buffer)) return {kPlanarFloat32, normalisation, memory};
  // Not bfloat16, not int16.
  if (planar && buffer.dtype() == kHalf) return {kPlanarFloat16, normalisation, memory};
  throw ArgumentError(
      fmt::format("colour '{}' with {} bits a value: 'rgb8', 'bgr8' and 'rgba8' are "
                  "uint8; 'planar' and 'imagenet' float32 or float16",
                  format, buffer.dtype().bits));
}

render::DepthOutput depth_output(const Buffer& buffer, bool ray) {
  const auto measure = ray ? render::DepthMeasure::kRay : render::DepthMeasure::kZ;
  if (holds<float>(buffer)) {
    return {render::DepthFormat::kMetresFloat32, measure, memory_of<std::byte>(buffer)};
  }
  if (holds<std::uint16_t>(buffer)) {
    return {render::DepthFormat::kQuarterMillimetresUint16, measure, memory_of<std::byte>(buffer)};
  }
  throw ArgumentError("depth: float32 (metres) or uint16 (quarter millimetres) is wanted");
}

render::ClassOutput class_output(const Buffer& buffer) {
  if (holds<std::uint8_t>(buffer)) {
    return {render::ClassFormat::kUint8, memory_of<std::byte>(buffer)};
  }
  if (holds<std::uint16_t>(buffer)) {
    return {render::ClassFormat::kUint16, memory_of<std::byte>(buffer)};
  }
  throw ArgumentError("classes: uint8 or uint16 is wanted");
}

render::InstanceOutput instance_output(const Buffer& buffer) {
  if (!holds<std::uint32_t>(buffer)) throw ArgumentError("instances: uint32 is wanted");
  return {memory_of<std::uint32_t>(buffer)};
}

/// 0: not shared.
std::optional<render::SharedCacheConfig> shared_cache(std::size_t bytes) {
  if (bytes == 0) return {};
  return render::SharedCacheConfig{{}, bytes};
}

/// A renderer with its cache.
class ViewRenderer {
 public:
  ViewRenderer(const std::shared_ptr<const PanoramaSet>& panoramas, const std::string& backend,
               int threads, std::size_t cache_bytes, std::size_t shared_bytes, bool clamped_edges,
               bool eight_bit_depth, const std::string& device, std::size_t card_bytes) {
    const auto parsed = find_enum<render::Backend>(backend);
    if (!parsed) {
      throw ArgumentError(
          fmt::format("backend '{}': 'cpu', 'cpu-scalar', 'gl' and 'cuda' are allowed", backend));
    }
    backend_ = *parsed;
    // Without the prefetch thread, which would not survive a fork.
    const auto faces = std::make_shared<render::FaceCache>(
        panoramas,
        render::FaceCacheConfig{
            .bytes = cache_bytes, .prefetch_thread = false, .shared = shared_cache(shared_bytes)});
    render::RendererConfig config;
    config.backend = backend_;
    config.threads = threads;
    config.legacy = {clamped_edges, eight_bit_depth};
    (backend_ == render::Backend::kCuda ? config.cuda_device : config.gl_device) = device;
    config.cuda_bytes = card_bytes;
    const nb::gil_scoped_release unlocked;  // trying a driver of OpenGL or CUDA takes a while
    renderer_ = render::make_renderer(faces, config);
  }

  void render(const ViewArrays& views, std::uint32_t width, std::uint32_t height, double vfov,
              const std::optional<Buffer>& colour, const std::string& colour_format,
              const std::optional<Buffer>& depth, bool ray_depth,
              const std::optional<Buffer>& classes, const std::optional<Buffer>& instances,
              std::optional<std::uintptr_t> stream) {
    const Busy busy(busy_);
    check_device(colour, "colour", backend_);
    check_device(depth, "depth", backend_);
    check_device(classes, "classes", backend_);
    check_device(instances, "instances", backend_);
    render::Outputs outputs;
    if (colour) outputs.colour = colour_output(*colour, colour_format);
    if (depth) outputs.depth = depth_output(*depth, ray_depth);
    if (classes) outputs.classes = class_output(*classes);
    if (instances) outputs.instances = instance_output(*instances);
    if (stream) outputs.stream = render::CudaStream{reinterpret_cast<void*>(*stream)};
    const nb::gil_scoped_release unlocked;
    views_.clear();
    for (std::size_t i = 0; i < views.size(); ++i) views_.push_back(views[i]);
    renderer_->render({width, height, Radians(vfov)}, views_, outputs);
  }
  std::string description() const { return renderer_->description(); }
  nb::object memory(const std::vector<std::size_t>& shape, const std::string& type) {
    return memory_->array(shape, type);
  }

 private:
  render::Backend backend_ = render::Backend::kCpu;
  std::unique_ptr<render::Renderer> renderer_;
  std::vector<render::View> views_;
  std::shared_ptr<PictureMemory> memory_ = std::make_shared<PictureMemory>();
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

// Its arguments: this package's folder, then those of try_gl().
constexpr const char* kScript =
    "import sys\n"
    "sys.path.insert(0, sys.argv[1])\n"
    "from enfilade import _core\n"
    "sys.exit(_core._try_gl(sys.argv[2:]))\n";

// The folder of this module's package.
std::filesystem::path own_folder() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&own_folder), &info) == 0) return {};
  return std::filesystem::absolute(info.dli_fname).parent_path().parent_path();
}

// Another Python process tries OpenGL's drivers before this one loads them.
void bind_gl_trial(nb::module_& m) {
  m.def("_try_gl",
        [](const std::vector<std::string>& arguments) { return render::try_gl(arguments); });
  // If Python is embedded, sys.executable is the other program or empty.
  const nb::object executable = nb::module_::import_("sys").attr("executable");
  std::string program;
  if (!nb::try_cast(executable, program)) return;
  const std::string name = std::filesystem::path(program).filename().string();
  if (!name.starts_with("python") && !name.starts_with("pypy")) return;
  render::set_gl_trial({program, "-c", kScript, own_folder().string()});
}

}  // namespace

void bind_renderer(nb::module_& m) {
  bind_gl_trial(m);
  nb::class_<PanoramaSet>(m, "Panoramas",
                          "The panoramas of a Graphs' scans: stores, or Matterport3D's files in "
                          "any layout. A scan is opened at first use.",
                          nb::dynamic_attr())
      .def(nb::new_(&open_panoramas), "images"_a, "connectivity"_a, "graphs"_a,
           "images: folders to search, in this order. connectivity: folder of the graphs' files.")
      .def_static("of_scans", &open_of_scans, "images"_a, "connectivity"_a, "scans"_a,
                  "The same, with names of scans.")
      .def(
          "__contains__",
          [](const PanoramaSet& set, const std::string& scan) {
            const nb::gil_scoped_release unlocked;
            const auto index = set.find(scan);
            return index && set.find_source(*index) != nullptr;
          },
          "scan"_a, "Whether a scan has images. Raises FileError, InvalidInput for broken ones.")
      .def("__reduce__", reduce_panoramas,
           nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
      .def_prop_ro("scans", &PanoramaSet::scans, "Names by index, as Graphs.scans.");
  nb::class_<ViewArrays>(m, "ViewArrays", "The poses of n views: arrays that each rendering reads.")
      .def(nb::init<Row<std::uint32_t>, Row<std::uint32_t>, Row<double>, Row<double>>(), "scans"_a,
           "viewpoints"_a, "headings"_a, "elevations"_a)
      .def("__len__", &ViewArrays::size);
  nb::class_<ViewRenderer>(m, "ViewRenderer", "The core of enfilade.Renderer.")
      .def(nb::init<const std::shared_ptr<const PanoramaSet>&, const std::string&, int, std::size_t,
                    std::size_t, bool, bool, const std::string&, std::size_t>(),
           "panoramas"_a, "backend"_a, "threads"_a, "cache_bytes"_a, "shared_bytes"_a,
           "clamped_edges"_a, "eight_bit_depth"_a, "device"_a, "card_bytes"_a)
      .def_prop_ro("description", &ViewRenderer::description)
      .def("memory", &ViewRenderer::memory, "shape"_a, "type"_a,
           "A new array to draw into; its content is undefined.",
           nb::sig("def memory(self, shape: tuple[int, ...], type: str) -> "
                   "numpy.typing.NDArray[typing.Any]"))
      .def("render", &ViewRenderer::render, "views"_a, "width"_a, "height"_a, "vfov"_a,
           "colour"_a.none().noconvert(), "colour_format"_a, "depth"_a.none().noconvert(),
           "ray_depth"_a, "classes"_a.none().noconvert(), "instances"_a.none().noconvert(),
           "stream"_a.none());
  m.def(
      "backends",
      [] {
        std::vector<std::string> names;
        for (const render::Backend b : render::backends()) names.emplace_back(enum_name(b));
        return names;
      },
      "The Renderer's back ends in this build, such as \"cpu\" and \"gl\".");
}

}  // namespace enfilade::python
