#include "enfilade/continuous/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <xxhash.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/continuous/eyes.h"
#include "enfilade/continuous/pixels/painter.h"
#include "enfilade/continuous/pixels/rasteriser.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/mesh/capture.h"
#include "tests/support/lit_rooms.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::continuous {
namespace EN_UNIT {

using namespace tests;
using ::testing::HasSubstr;

constexpr Camera kCamera{120, 120, degrees(90)};

std::vector<std::uint8_t> picture(const std::shared_ptr<const Scene>& scene, const MeshView& view) {
  std::vector<std::uint8_t> rgb(3 * kCamera.width * kCamera.height);
  render::Outputs outputs;
  outputs.colour =
      render::ColourOutput{render::ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(rgb))};
  Eyes({scene}).render(kCamera, {&view, 1}, outputs);
  return rgb;
}

// What mesh/capture.h draws there, with all its rays.
std::vector<std::uint8_t> truth(const mesh::LitMesh& light, const MeshView& view) {
  mesh::Pinhole pinhole;
  pinhole.width = kCamera.width;
  pinhole.height = kCamera.height;
  pinhole.fx = pinhole.fy = kCamera.height / 2.0;
  pinhole.cx = (kCamera.width - 1) / 2.0;
  pinhole.cy = (kCamera.height - 1) / 2.0;
  pinhole.world_from_camera = world_from_camera(view.heading, view.elevation);
  pinhole.position = view.eye;
  mesh::CaptureOptions options;
  options.samples = 1;
  options.depth = options.labels = false;
  return mesh::capture_pinhole(light, pinhole, options).colour.pixels;
}

double psnr(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = double{static_cast<double>(a[i])} - b[i];
    sum += d * d;
  }
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.size()) / std::max(sum, 1e-9));
}

const std::vector<MeshView>& views() {
  static const std::vector<MeshView> kViews{
      {0, {-1, 0, 1.5}, Radians(kPi / 2), Radians(-0.2)},  // the box, the mirror, the sun's patch
      {0, {2, 1.5, 1.5}, Radians(3 * kPi / 2), Radians(-0.3)},  // the window and the floor
      {0, {0, -1, 0.6}, Radians(0.4), Radians(0.6)},            // the lamp and the ceiling
      {0, {-6, 0.5, 1.6}, Radians(kPi / 2), Radians(0)},        // from outside
      {0, {0.5, 0.5, 1.2}, Radians(2.2), Radians(-1.1)}};
  return kViews;
}

TEST(Scene, PicturesAreThoseOfTheSlowRenderer) {
  for (const MeshView& view : views()) {
    // Edges of sunlight are softened over half the spacing of 5 cm; the rest differs by a step.
    EXPECT_GT(psnr(picture(lit().scene, view), truth(lit().light, view)), 32) << view.heading.value;
  }
}

TEST(Scene, WithoutSunPicturesDifferByAStep) {
  mesh::Lights lights = Lit::lights();
  lights.sun.irradiance = {};
  const mesh::LitMesh light(lit().tracer, lights, Lit::options());
  const auto scene = Scene::lit(lit().tracer, light);
  for (const MeshView& view : views()) {
    EXPECT_GT(psnr(picture(scene, view), truth(light, view)), 38) << view.heading.value;
  }
}

std::vector<std::uint8_t> drawn(const std::shared_ptr<const Scene>& scene, const MeshView& view,
                                const EyesConfig& config) {
  std::vector<std::uint8_t> rgb(3 * kCamera.width * kCamera.height);
  render::Outputs outputs;
  outputs.colour =
      render::ColourOutput{render::ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(rgb))};
  Eyes({scene}, config).render(kCamera, {&view, 1}, outputs);
  return rgb;
}

TEST(Scene, PlainTwinGivesTheSameColours) {
  const auto photographed = Scene::photographed(lit().tracer);
  for (const MeshView& view : views()) {
    for (const auto& scene : {lit().scene, photographed}) {
      EXPECT_EQ(drawn(scene, view, {Method::kRaster, 2}), drawn(scene, view, {Method::kPlain, 1}));
    }
  }
}

TEST(Scene, EveryInstructionSetGivesTheSameColours) {
  const pixels::SceneParts& parts = lit().scene->parts();
  const pixels::Lattice lattice(kCamera);
  const pixels::TileRows rows{0, lattice.blocks_down * pixels::kBlock};
  ASSERT_EQ(pixels::shader_variants().size(), pixels::rasteriser_variants().size());
  for (const MeshView& view : views()) {
    const pixels::Eye eye(view.eye, view.heading, view.elevation);
    const pixels::Pixels of{&lattice, nullptr, 1 / lattice.focal};
    std::vector<pixels::VisibilityBuffer> frames;
    std::vector<std::vector<std::byte>> pictures;
    for (std::size_t k = 0; k < pixels::shader_variants().size(); ++k) {
      pixels::VisibilityBuffer& frame = frames.emplace_back();
      frame.resize(lattice.blocks_across, lattice.blocks_down);
      frame.clear(lattice, rows);
      pixels::rasteriser_variants()[k].draw({parts.tree, parts.surfaces, lattice, eye}, rows,
                                            frame);
      const pixels::PixelPainter painter(parts, of, eye, {pixels::shader_variants()[k], nullptr});
      auto& rgb = pictures.emplace_back(std::size_t{3} * kCamera.width * kCamera.height);
      render::Outputs outputs;
      outputs.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, rgb};
      std::vector<std::uint32_t> lines(pixels::kTile *
                                       pixels::PixelPainter::line_pitch(kCamera.width));
      painter.paint(frame, rows, outputs, 0, lines);
      const std::string& name = pixels::rasteriser_variants()[k].name;
      EXPECT_TRUE(frame.nearness == frames[0].nearness && frame.triangle == frames[0].triangle)
          << name;
      EXPECT_TRUE(rgb == pictures[0]) << name;
    }
  }
}

TEST(Scene, ThreadsDoNotChangeTheLight) {
  SceneOptions options;
  options.light_spacing = 0.2;
  options.threads = 1;
  const auto one = Scene::lit(lit().tracer, lit().light, options);
  options.threads = 3;
  const auto three = Scene::lit(lit().tracer, lit().light, options);
  for (const MeshView& view : views()) EXPECT_EQ(picture(one, view), picture(three, view));
}

TEST(Scene, ExposureBrightens) {
  SceneOptions options;
  options.light_spacing = 0.2;
  options.exposure = 1;
  const auto brighter = Scene::lit(lit().tracer, lit().light, options);
  const auto a = picture(lit().scene, views()[1]), b = picture(brighter, views()[1]);
  double more = 0;
  for (std::size_t i = 0; i < a.size(); ++i) more += static_cast<double>(b[i]) - a[i];
  EXPECT_GT(more / static_cast<double>(a.size()), 10);
}

class SceneFile : public ::testing::Test {
 protected:
  const TemporaryFolder folder_{"scene"};
  const std::filesystem::path path_ = folder_.path() / "room.light";
  void SetUp() override { lit().scene->save(path_); }
  std::string code(const std::shared_ptr<const mesh::RayTracer>& tracer) const {
    try {
      Scene::load(tracer, path_);
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr(path_.string()));
      return error.diagnostics().front().code;
    }
    return "";
  }
  void change(const std::function<void(std::string&)>& how) const {
    std::string content = read_file(path_);
    how(content);
    write_file_atomically(path_, content);
  }
};

TEST_F(SceneFile, LoadedSceneGivesTheSamePictures) {
  const auto loaded = Scene::load(lit().tracer, path_);
  EXPECT_TRUE(loaded->parts().lit);
  for (const MeshView& view : views()) {
    EXPECT_EQ(picture(loaded, view), picture(lit().scene, view));
  }
}

// For viewers: at any point as the renderer that computed it has it, but for the sun's edges.
TEST_F(SceneFile, LoadedLightIsThatOfEachPoint) {
  const auto loaded = Scene::load(lit().tracer, path_);
  const mesh::SurfaceLight kept = loaded->surface_light();
  std::vector<mesh::SurfacePoint> points;
  for (std::uint32_t t = 0; t < lit().tracer->mesh().triangles.size(); ++t) {
    for (const auto& [u, v] : {std::pair{0.3F, 0.3F}, std::pair{0.7F, 0.1F}, std::pair{0.1F, 0.7F},
                               std::pair{0.12F, 0.1F}}) {
      for (const bool back : {false, true}) points.push_back({t, u, v, back});
    }
  }
  std::vector<Vec3f> found(points.size()), computed(points.size());
  kept.at(points, found);
  lit().light.light(points, computed);
  std::size_t far_off = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const float should = kept.exposure * computed[k].y;
    if (std::abs(found[k].y - should) > 0.05F * should + 0.01F) ++far_off;
  }
  EXPECT_LT(far_off, points.size() / 20) << "of " << points.size();
  EXPECT_THROW(Scene::photographed(lit().tracer)->surface_light(), ArgumentError);
}

TEST_F(SceneFile, MeshFilesAreOpenedWithTheirLight) {
  const std::filesystem::path file = folder_.path() / "room.glb";
  EXPECT_EQ(light_file(file), path_);
  std::filesystem::remove(path_);
  mesh::write_glb(lit().tracer->mesh(), file);
  const auto bare = Scene::open(file);
  EXPECT_FALSE(bare->parts().lit);
  // Its textures are its colours.
  const auto photographed = Scene::photographed(lit().tracer);
  EXPECT_GT(psnr(picture(bare, views()[1]), picture(photographed, views()[1])), 30);
  // The light of the mesh as it is in the file.
  const auto tracer = std::make_shared<const mesh::RayTracer>(
      std::make_shared<const mesh::Mesh>(bare->tracer().mesh()));
  const mesh::LitMesh light(tracer, Lit::lights(), Lit::options());
  Scene::lit(tracer, light)->save(light_file(file));
  const auto opened = Scene::open(file);
  EXPECT_TRUE(opened->parts().lit);
  EXPECT_GT(psnr(picture(opened, views()[2]), picture(lit().scene, views()[2])), 30);
}

TEST_F(SceneFile, BadFilesAreRefused) {
  EXPECT_EQ(code(lit().tracer), "");
  EXPECT_EQ(code(tracer_of(empty_room())), "other-mesh");
  mesh::Mesh moved = furnished_room();
  moved.positions[3].x += 0.01F;
  EXPECT_EQ(code(tracer_of(moved)), "other-mesh");
  change([](std::string& s) { s[s.size() / 2] = static_cast<char>(s[s.size() / 2] ^ 1); });
  EXPECT_EQ(code(lit().tracer), "checksum");
  change([](std::string& s) { s.resize(s.size() - 5); });
  EXPECT_EQ(code(lit().tracer), "truncated");
  change([](std::string& s) { s[8] = 9; });
  EXPECT_EQ(code(lit().tracer), "version");
  change([](std::string& s) { s[0] = 'X'; });
  EXPECT_EQ(code(lit().tracer), "not-light");
  change([](std::string& s) { s.resize(20); });
  EXPECT_EQ(code(lit().tracer), "truncated");
  std::filesystem::remove(path_);
  EXPECT_THROW(Scene::load(lit().tracer, path_), FileError);
}

// Puts a number into the file, and the right checksum under it.
template <class T>
void put(std::string& content, std::size_t at, T value) {
  std::memcpy(content.data() + at, &value, sizeof value);
  const std::size_t rest = content.size() - sizeof(std::uint64_t);
  const std::uint64_t sum = XXH3_64bits(content.data(), rest);
  std::memcpy(content.data() + rest, &sum, sizeof sum);
}

TEST_F(SceneFile, PlacesOutsideTheFileAreRefused) {
  constexpr std::size_t kHead = 80, kValues = 16;
  const std::string good = read_file(path_);
  change([](std::string& s) { put(s, kHead, std::uint32_t{0x7FFFFFFFU}); });
  EXPECT_EQ(code(lit().tracer), "bad-grid");
  write_file_atomically(path_, good);
  change([](std::string& s) { put(s, kHead + 8, std::uint16_t{65535}); });
  EXPECT_EQ(code(lit().tracer), "bad-grid");
  for (const std::uint64_t values : {std::uint64_t{0}, std::uint64_t{1}, ~std::uint64_t{0}}) {
    write_file_atomically(path_, good);
    change([&](std::string& s) { put(s, kValues, values); });
    EXPECT_EQ(code(lit().tracer), "bad-grid");
  }
}

TEST_F(SceneFile, MistakesAreNamed) {
  EXPECT_THROW(Scene::photographed(lit().tracer)->save(path_), ArgumentError);
  EXPECT_THROW(Scene::lit(tracer_of(empty_room()), lit().light), ArgumentError);
  EXPECT_THROW(Scene::lit(nullptr, lit().light), ArgumentError);
  SceneOptions options;
  options.light_spacing = 0;
  EXPECT_THROW(Scene::lit(lit().tracer, lit().light, options), ArgumentError);
  options = {};
  options.least_mirror = 2;
  EXPECT_THROW(Scene::lit(lit().tracer, lit().light, options), ArgumentError);
  options = {};
  options.exposure = std::numeric_limits<float>::infinity();
  EXPECT_THROW(Scene::lit(lit().tracer, lit().light, options), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous
