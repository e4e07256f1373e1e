// The card's kernels as plain C++, against the scalar kernels of the CPU: the same bytes.
#include "enfilade/render/cuda/kernels.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>

#include "enfilade/image/face_cells.h"
#include "enfilade/render/cpu/pack.h"
#include "enfilade/render/cuda/job.h"
#include "enfilade/render/detail/layers.h"
#include "tests/support/drawn_formats.h"
#include "tests/support/made_panoramas.h"

namespace enfilade::render::cuda {
namespace EN_UNIT {

using scan::Layer;
using testing::cache_of;
using testing::made_panorama;
using testing::outputs_of;
using testing::random_view;

template <class V>
void draw_twin(const Job& job, u32 views) {
  const auto band = std::make_unique<Band>();
  for (u32 block = 0; block < views * job.bands; ++block) draw_band<V>(job, block, *band);
}

using Twin = void (*)(const Job&, u32 views);
template <u32 Colour, u32 Depth, u32 Classes, bool Instances, bool Clamped = false>
std::pair<const Kinds, Twin> twin() {
  return {{static_cast<ColourKind>(Colour), static_cast<DepthKind>(Depth),
           static_cast<ClassKind>(Classes), Instances, Clamped},
          draw_twin<Variant<Colour, Depth, Classes, Instances, Clamped>>};
}

// Every kind of every layer once, and some together.
const std::map<Kinds, Twin>& twins() {
  static const std::map<Kinds, Twin> kAll{
      twin<kRgb, kNoDepth, kNoClasses, false>(),
      twin<kRgb, kNoDepth, kNoClasses, false, true>(),
      twin<kBgr, kMetres, kNoClasses, false>(),
      twin<kRgba, kUnits, kClass8, false>(),
      twin<kPlanar16, kNoDepth, kNoClasses, false>(),
      twin<kPlanar16, kLegacyMetres, kNoClasses, true, true>(),
      twin<kPlanar32, kLegacyUnits, kClass16, true>(),
      twin<kNoColour, kMetres, kNoClasses, false>(),
      twin<kNoColour, kUnits, kNoClasses, false>(),
      twin<kNoColour, kNoDepth, kClass8, false>(),
      twin<kNoColour, kNoDepth, kClass16, false>(),
      twin<kNoColour, kNoDepth, kNoClasses, true>(),
  };
  return kAll;
}

// Layers of panoramas as they lie on a card.
class Card {
 public:
  explicit Card(FaceCache& faces) : faces_(faces) {}

  void bring_in(const View& view, Layer layer, DeviceView& out) {
    std::array<FaceKey, kCubeFaces> keys{};
    std::array<Face, kCubeFaces> found;
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      keys[k] = {view.scan, view.viewpoint, layer, cube_face(k)};
    }
    faces_.acquire(keys, found);
    const u32 size = found[0].size;
    std::vector<u8> cells;
    for (const Face& face : found) {
      cells.insert(cells.end(), face.cells, face.cells + scan::cells_bytes(layer, size));
    }
    faces_.release(keys);
    if (layer == Layer::kColour) {
      std::vector<u8> strips(kCubeFaces * std::size_t{colour_bytes(size)});
      const u32 texels = static_cast<u32>(kCubeFaces) * (size + 2) * (size + 2);
      for (u32 texel = 0; texel < texels; ++texel) {
        unpack_texel(cells.data(), strips.data(), size, texel);
      }
      cells = std::move(strips);
    }
    memory_.push_back(std::move(cells));
    out.faces[index(layer)] = reinterpret_cast<u64>(memory_.back().data());
    out.sizes[index(layer)] = size;
  }

 private:
  FaceCache& faces_;
  std::deque<std::vector<u8>> memory_;
};

template <class T>
void expect_equal(const std::vector<T>& drawn, const std::vector<T>& wanted, const char* layer) {
  ASSERT_EQ(drawn.size(), wanted.size()) << layer;
  const auto [a, b] = std::ranges::mismatch(drawn, wanted);
  if (a == drawn.end()) return;
  FAIL() << layer << ": value " << a - drawn.begin() << " is " << static_cast<unsigned>(*a)
         << ", not " << static_cast<unsigned>(*b);
}

testing::Formats formats_of(const Kinds& kinds) {
  constexpr std::array kColours{ColourFormat::kRgb8, ColourFormat::kBgr8, ColourFormat::kRgba8,
                                ColourFormat::kPlanarFloat16, ColourFormat::kPlanarFloat32};
  testing::Formats formats{.colour = {}, .depth = {}, .classes = {}, .instances = kinds.instances};
  if (kinds.colour != kNoColour) formats.colour = kColours[kinds.colour - kRgb];
  if (kinds.depth != kNoDepth) {
    const bool metres = kinds.depth == kMetres || kinds.depth == kLegacyMetres;
    formats.depth = metres ? DepthFormat::kMetresFloat32 : DepthFormat::kQuarterMillimetresUint16;
  }
  if (kinds.classes != kNoClasses) {
    formats.classes = kinds.classes == kClass8 ? ClassFormat::kUint8 : ClassFormat::kUint16;
  }
  return formats;
}

TEST(CudaKernels, DrawAsTheScalarTwinOfTheCpu) {
  // Two sizes of faces; the first ends strips and cells in the middle.
  const auto faces = cache_of({made_panorama(45), made_panorama(64)});
  Rng rng(17, 0);
  for (const auto& [kinds, draw] : twins()) {
    const Legacy legacy{kinds.clamped, kinds.depth == kLegacyMetres || kinds.depth == kLegacyUnits};
    const auto renderer =
        make_renderer(faces, {.backend = Backend::kCpuScalar, .threads = 1, .legacy = legacy});
    for (int round = 0; round < 40; ++round) {
      const std::uint32_t most = round % 20 == 0 ? 700 : 150;
      const Camera camera{1 + static_cast<std::uint32_t>(rng.below(most)),
                          1 + static_cast<std::uint32_t>(rng.below(90)),
                          degrees(5 + 165 * rng.uniform())};
      std::vector<View> views;
      for (std::size_t k = 0; k < 1 + rng.below(3); ++k) views.push_back(random_view(rng, 2));
      const std::size_t pixels = views.size() * camera.width * camera.height;
      testing::Drawn wanted, drawn;
      renderer->render(camera, views, outputs_of(formats_of(kinds), pixels, wanted));

      const Outputs outputs = outputs_of(formats_of(kinds), pixels, drawn);
      ASSERT_EQ(kinds_of(outputs, legacy), kinds);
      Card card(*faces);
      std::vector<DeviceView> prepared(views.size());
      for (std::size_t k = 0; k < views.size(); ++k) {
        prepared[k].rays = rays_of(camera, views[k], faces->panoramas());
        for (const Layer layer : detail::kEachLayer) {
          if (detail::has(layers_of(kinds), layer)) card.bring_in(views[k], layer, prepared[k]);
        }
      }
      const std::vector<float> factors = cpu::depth_factors(camera, DepthMeasure::kZ);
      Job job = make_job(camera, kinds, outputs);
      job.views = prepared.data();
      job.depth_factors = factors.data();
      draw(job, static_cast<u32>(views.size()));
      SCOPED_TRACE(fmt::format("{}: {} views of {} x {}", fmt::join(kinds.definitions(), " "),
                               views.size(), camera.width, camera.height));
      expect_equal(drawn.colour, wanted.colour, "colour");
      expect_equal(drawn.depth, wanted.depth, "depth");
      expect_equal(drawn.classes, wanted.classes, "classes");
      expect_equal(drawn.instances, wanted.instances, "instances");
      if (HasFailure()) return;
    }
  }
}

TEST(CudaKernels, LayersAreDrawnAloneAsTogether) {
  const Kinds all{kPlanar32, kLegacyUnits, kClass16, true, true};
  EXPECT_EQ(layers_of(all), 15);
  EXPECT_EQ(only(all, Layer::kColour), (Kinds{.colour = kPlanar32, .clamped = true}));
  EXPECT_EQ(only(all, Layer::kDepth), (Kinds{.depth = kLegacyUnits}));
  EXPECT_EQ(only(all, Layer::kClass), (Kinds{.classes = kClass16}));
  EXPECT_EQ(only(all, Layer::kInstance), (Kinds{.instances = true}));
}

TEST(CudaKernels, StripsHaveNeighboursWhereTheKernelsLookForThem) {
  for (const u32 size : {1U, 6U, 7U, 8U, 45U, 512U}) {
    const u32 step = strip_step(size);
    std::vector<bool> used(colour_bytes(size) / 4);
    for (u32 y = 0; y < size + 2; ++y) {
      for (u32 x = 0; x < size + 2; ++x) {
        const u32 number = texel_number(step, x, y);
        ASSERT_LT(number, used.size());
        ASSERT_FALSE(used[number]);
        used[number] = true;
        ASSERT_EQ(texel_number(step, x, y + 1), number + (1U << kStripBits));
      }
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::render::cuda
