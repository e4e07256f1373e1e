/// \file  Renderer: pictures of what agents see, drawn in batches.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/image/image.h"
#include "enfilade/render/face_cache.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::render {

/// Viewpoint and direction of view. Any heading; elevation in [-pi/2, pi/2], up positive.
struct View {
  ScanIndex scan;  ///< of the PanoramaSet
  ViewpointIndex viewpoint;
  Radians heading;
  Radians elevation;
};

/// Layouts of colour for n views of h x w pixels; rows from the top, no padding.
enum class ColourFormat : std::uint8_t {
  kRgb8,           ///< (n, h, w, 3) uint8
  kBgr8,           ///< (n, h, w, 3) uint8, as in OpenCV
  kRgba8,          ///< (n, h, w, 4) uint8, A = 255
  kPlanarFloat16,  ///< (n, 3, h, w) IEEE half, R G B: (value / 255 - mean) / deviation
  kPlanarFloat32,  ///< (n, 3, h, w) float, likewise
};

/// Mean and deviation that planar formats apply, R G B, for values in [0, 1]. Default: none.
struct Normalisation {
  std::array<float, 3> mean{0, 0, 0};
  std::array<float, 3> deviation{1, 1, 1};  ///< > 0
};
/// Normalisation of ImageNet, as in torchvision's models.
inline constexpr Normalisation kImageNet{{0.485F, 0.456F, 0.406F}, {0.229F, 0.224F, 0.225F}};

/// Memory for colour, and its format.
struct ColourOutput {
  ColourFormat format = ColourFormat::kRgb8;
  Normalisation normalisation;  ///< of planar formats
  std::span<std::byte> pixels;  ///< exactly n views; aligned for the format's values
};

/// How depth is stored; 0 means no reading.
enum class DepthFormat : std::uint8_t {
  kMetresFloat32,             ///< (n, h, w) float
  kQuarterMillimetresUint16,  ///< (n, h, w) uint16, 4000 a metre, rounded to nearest
};
/// Along what depth is measured.
enum class DepthMeasure : std::uint8_t {
  kZ,    ///< along the optical axis, as of depth cameras and the old simulator
  kRay,  ///< along the pixel's ray
};
/// Depth; 0: no reading.
struct DepthOutput {
  DepthFormat format = DepthFormat::kMetresFloat32;
  DepthMeasure measure = DepthMeasure::kZ;
  std::span<std::byte> pixels;
};

/// How classes are stored.
enum class ClassFormat : std::uint8_t {
  kUint8,   ///< (n, h, w); classes above 255 become 255
  kUint16,  ///< (n, h, w)
};
/// Memory for classes (mpcat40).
struct ClassOutput {
  ClassFormat format = ClassFormat::kUint16;
  std::span<std::byte> pixels;
};
/// Memory for instance ids; 0: no object.
struct InstanceOutput {
  std::span<std::uint32_t> pixels;  ///< (n, h, w)
};

/// A stream of CUDA: a CUstream or cudaStream_t of the card that draws, or null for the legacy
/// default stream.
struct CudaStream {
  void* handle = nullptr;
};

/// The outputs to draw, into the caller's memory. Colour is filtered linearly; depth, class and
/// instance are of the nearest texel. With Backend::kCuda each may be memory of the card instead.
struct Outputs {
  std::optional<ColourOutput> colour;
  std::optional<DepthOutput> depth;
  std::optional<ClassOutput> classes;
  std::optional<InstanceOutput> instances;
  /// Backend::kCuda only: pictures in the card's memory are made in the order of this stream, and
  /// render() returns before they are there. It may be captured into a graph, if all panoramas were
  /// rendered before with this camera. The graph renders the same views each time, as long as the
  /// renderer lives and renders nothing that needs the panoramas' memory. No value: waits for the
  /// legacy default stream first, and render() returns when the pictures are there.
  std::optional<CudaStream> stream = {};
};

/// Bytes of a pixel, all channels.
std::size_t pixel_bytes(ColourFormat format) noexcept;
std::size_t pixel_bytes(DepthFormat format) noexcept;
std::size_t pixel_bytes(ClassFormat format) noexcept;

/// Inaccuracies of the old simulator, to reproduce features made with it. See docs/mattersim.md.
struct Legacy {
  bool clamped_edges = false;    ///< colour is not filtered across the edges of faces
  bool eight_bit_depth = false;  ///< z-depth in steps of 257 quarter millimetres (64 mm)
};

/// Draws batches of views. A renderer may be used by one thread at a time; several renderers may be
/// used at once, also with the same FaceCache.
class Renderer {
 public:
  virtual ~Renderer() = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Fills the outputs. The same view gives the same bytes in any batch, with any number of
  /// threads. Allocates nothing after the first call with the camera, the batch size and the
  /// panoramas. With several threads, oneTBB still allocates its tasks. Arguments are checked
  /// before anything is drawn.
  /// \throws ArgumentError for an invalid camera, outputs of another size, or a deviation that is
  /// not positive
  /// \throws ArgumentError naming the position of a view with an unknown scan or viewpoint, or an
  /// angle that is not finite or out of range
  /// \throws LookupError, FileError, InvalidInput for panoramas that lack a layer or are broken;
  /// the outputs are then unspecified
  virtual void render(const Camera& camera, std::span<const View> views,
                      const Outputs& outputs) = 0;

  /// Back end and device: "cpu (AVX3, 2 threads)", "gl (llvmpipe, OpenGL 4.5)".
  virtual std::string description() const = 0;

 protected:
  Renderer() = default;
};

/// Implementation of a renderer.
enum class Backend : std::uint8_t {
  kCpu,        ///< SIMD, with the processor's best instruction set
  kCpuScalar,  ///< plain C++: slow; the reference for the others
  kGl,         ///< OpenGL through EGL, without a display
  kCuda,       ///< a card of NVIDIA; the pictures are those of the CPU to the bit
};
constexpr std::array<std::string_view, 4> names_of(Backend /*enum*/) {
  return {"cpu", "cpu-scalar", "gl", "cuda"};
}
/// The back ends of this build. kCuda is always among them; without a card it throws.
std::vector<Backend> backends();

/// Which back end draws, with how many threads, and the old simulator's habits.
struct RendererConfig {
  Backend backend = Backend::kCpu;
  int threads = 0;  ///< of the cpu back ends; 0: all cores
  Legacy legacy = {};
  std::string gl_device =
      {};  ///< index or UUID of an EGL device ("0"); empty: the first that works
  /// Backend::kCpu: one of cpu_targets() (devices.h); empty: the fastest here. The pictures are
  /// the same to the bit.
  std::string cpu_target = {};
  std::string cuda_device = {};  ///< number of a card, counted from 0; empty: "0"
  std::size_t cuda_bytes = 0;    ///< of its memory, for panoramas; 0: half of the free memory
};

/// \throws ArgumentError for a backend that this build lacks, or a null cache
/// \throws Error with OpenGL's or EGL's message if no device, context or shader works; with CUDA's
/// message, or naming its missing part
std::unique_ptr<Renderer> make_renderer(std::shared_ptr<FaceCache> faces,
                                        const RendererConfig& config = {});

/// Checks the arguments of Renderer::render(), except the stream; for implementations and bindings.
/// \throws as Renderer::render()
void validate(const Camera& camera, std::span<const View> views, const Outputs& outputs,
              const scan::PanoramaSet& panoramas);

/// Checks sizes, alignment and normalisation of outputs for `pixels` pixels, all views together.
/// Does not check the stream.
/// \throws ArgumentError naming the output
void validate(const Outputs& outputs, std::size_t pixels);

/// The 36 discretized views of a viewpoint in the order of MatterSim's viewIndex: 12 headings from
/// 0 in steps of 30 degrees, at elevation -30, then 0, then 30 degrees.
inline constexpr std::size_t kDiscreteViews = 36;
std::array<View, kDiscreteViews> discrete_views(ScanIndex scan, ViewpointIndex viewpoint);

/// Draws an equirectangular panorama, (height, width): the middle column is at view.heading, the
/// middle row at the horizon, the top row up; view.elevation is ignored. One view in each output;
/// depth is along the ray, whatever its measure. \throws as Renderer::render(); ArgumentError for a
/// size of 0
void render_equirectangular(const std::shared_ptr<FaceCache>& faces, const View& view,
                            std::uint32_t width, std::uint32_t height, const Outputs& outputs,
                            int threads = 0);

/// A run of pixels of one view: `first` is the place of its first pixel in the view, row-major.
struct PixelRun {
  std::size_t view = 0;         ///< its place in the batch
  std::size_t first = 0;        ///< pixels
  std::size_t view_pixels = 0;  ///< width times height
};

/// Writes colours in the output's format, with the CPU back end's kernels. Allocates nothing.
/// \param rgba R in the lowest byte  \pre validate(outputs); the run lies in its view
void pack_colours(const ColourOutput& output, const PixelRun& run,
                  std::span<const std::uint32_t> rgba);

/// n views, one above the other: shape (n height, width). Layers that are not drawn are empty.
struct Pictures {
  image::Image8 colour;      ///< RGB
  image::Image16 depth;      ///< quarter millimetres along the optical axis; 0: no reading
  image::Image16 classes;    ///< 0: none
  image::Image32 instances;  ///< 0: none
};

/// Makes room in `pictures` for `views` views of the layers in `layers`. Other layers do not
/// change.
/// \returns outputs for Renderer::render(), valid as long as `pictures` is not changed
Outputs outputs_into(Pictures& pictures, scan::LayerMask layers, std::uint32_t width,
                     std::uint32_t height, std::size_t views = 1);

}  // namespace enfilade::render
