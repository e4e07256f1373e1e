#include "enfilade/continuous/photographs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "enfilade/continuous/eyes.h"
#include "enfilade/continuous/pixels/painter.h"
#include "enfilade/continuous/pixels/rasteriser.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/mesh/capture.h"
#include "enfilade/scan/panorama_source.h"
#include "tests/support/lit_rooms.h"

namespace enfilade::continuous {
namespace EN_UNIT {

using namespace tests;
using ::testing::HasSubstr;

constexpr Camera kCamera{112, 112, degrees(90)};

// A panorama turned about the vertical, as in files: its y is down.
Mat3d upright(double heading) {
  const double c = std::cos(heading), s = std::sin(heading);
  return {{c, 0, s, -s, 0, c, 0, -1, 0}};
}

scan::Connectivity graph(std::span<const Vec3d> at) {
  scan::Connectivity made;
  made.scan = "room";
  for (std::size_t k = 0; k < at.size(); ++k) {
    scan::ConnectivityEntry entry;
    entry.id = "v" + std::to_string(k);
    entry.pose = pose_matrix(upright(0.3 + static_cast<double>(k)), at[k]);
    entry.height = 1.5;
    made.entries.push_back(std::move(entry));
  }
  return made;
}

// Panoramas of the furnished room, with all its light.
std::shared_ptr<const scan::PanoramaSet> panoramas(std::span<const Vec3d> at, std::uint32_t size) {
  std::vector<scan::Panorama> pictures;
  scan::Connectivity made = graph(at);
  for (const scan::ConnectivityEntry& entry : made.entries) {
    mesh::CaptureOptions options;
    options.depth = options.labels = false;
    scan::Panorama& picture = pictures.emplace_back();
    const Vec3d eye{entry.pose[3], entry.pose[7], entry.pose[11]};
    picture.colour =
        mesh::capture_cube(lit().light, rotation_of(entry.pose), eye, size, options).colour;
  }
  return scan::PanoramaSet::of(
      {std::make_shared<const scan::MemoryPanoramas>(std::move(made), std::move(pictures))});
}

const std::vector<Vec3d>& places() {
  static const std::vector<Vec3d> kPlaces{{-1, 0, 1.5}, {2.6, 1.6, 1.5}, {0, -1, 1.5}};
  return kPlaces;
}
std::shared_ptr<const Photographs> photographs() {
  static const auto kPhotographs =
      std::make_shared<const Photographs>(panoramas(places(), 256), ScanIndex(0), lit().scene);
  return kPhotographs;
}

std::vector<std::uint8_t> drawn(const MeshView& view, const EyesConfig& config) {
  std::vector<std::uint8_t> rgb(3 * kCamera.width * kCamera.height);
  render::Outputs outputs;
  outputs.colour =
      render::ColourOutput{render::ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(rgb))};
  Eyes({lit().scene}, config).render(kCamera, {&view, 1}, outputs);
  return rgb;
}

std::vector<std::uint8_t> truth(const MeshView& view) {
  mesh::Pinhole pinhole;
  pinhole.width = kCamera.width;
  pinhole.height = kCamera.height;
  pinhole.fx = pinhole.fy = kCamera.height / 2.0;
  pinhole.cx = (kCamera.width - 1) / 2.0;
  pinhole.cy = (kCamera.height - 1) / 2.0;
  pinhole.world_from_camera = world_from_camera(view.heading, view.elevation);
  pinhole.position = view.eye;
  mesh::CaptureOptions options;
  options.depth = options.labels = false;
  return mesh::capture_pinhole(lit().light, pinhole, options).colour.pixels;
}

double psnr(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = static_cast<double>(a[i]) - static_cast<double>(b[i]);
    sum += d * d;
  }
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.size()) / std::max(sum, 1e-9));
}

std::vector<MeshView> views() {
  std::vector<MeshView> made;
  for (double heading = 0.1; heading < 6; heading += 1.3) {
    made.push_back({0, {-0.9, 0.1, 1.45}, Radians(heading), Radians(-0.2)});
    made.push_back({0, {2.2, 0.9, 1.2}, Radians(heading), Radians(-0.1)});
    made.push_back({0, {0.3, -0.3, 1.25}, Radians(heading), Radians(0)});
  }
  return made;
}

TEST(Photographs, PicturesAreNearTheTruth) {
  for (const MeshView& view : views()) {
    const auto picture = drawn(view, {Method::kRaster, 2, {photographs()}});
    EXPECT_GT(psnr(picture, truth(view)), 27) << view.eye.x << ' ' << view.heading.value;
  }
}

TEST(Photographs, AtAPanoramaThePictureIsThePanorama) {
  for (const double heading : {0.4, 2.0, 3.9}) {
    const MeshView view{0, places()[0], Radians(heading), Radians(0.1)};
    EXPECT_GT(psnr(drawn(view, {Method::kRaster, 1, {photographs()}}), truth(view)), 30);
  }
}

TEST(Photographs, ColoursAreThoseOfThePanoramaWhereItSees) {
  // A panorama all red: what it sees is red, what is hidden from it behind the box is not.
  const std::vector<Vec3d> one{{-1, 0, 1.5}};
  std::vector<scan::Panorama> pictures(1);
  for (auto& face : pictures[0].colour) {
    face = image::Image8(64, 64, 3);
    for (std::size_t i = 0; i < face.pixels.size(); i += 3) face.pixels[i] = 200;
  }
  const auto red = std::make_shared<const Photographs>(
      scan::PanoramaSet::of(
          {std::make_shared<const scan::MemoryPanoramas>(graph(one), std::move(pictures))}),
      ScanIndex(0), lit().scene);
  const MeshView view{0, {3, 0, 0.4}, Radians(3 * kPi / 2), Radians(0)};  // behind the box
  const auto picture = drawn(view, {Method::kRaster, 1, {red}}), plain = drawn(view, {});
  std::size_t reds = 0, plains = 0;
  for (std::size_t p = 0; p < picture.size(); p += 3) {
    const bool is_red = picture[p] == 200 && picture[p + 1] == 0 && picture[p + 2] == 0;
    const bool is_plain = std::equal(picture.begin() + static_cast<std::ptrdiff_t>(p),
                                     picture.begin() + static_cast<std::ptrdiff_t>(p + 3),
                                     plain.begin() + static_cast<std::ptrdiff_t>(p));
    EXPECT_TRUE(is_red || is_plain);
    reds += is_red ? 1 : 0;
    plains += is_plain ? 1 : 0;
  }
  EXPECT_GT(reds, picture.size() / 3 / 5);
  EXPECT_GT(plains, picture.size() / 3 / 10) << "the box's far side";
}

TEST(Photographs, SameBytesWithAnyThreadsAndFromThePlainTwin) {
  for (const MeshView& view : views()) {
    const auto picture = drawn(view, {Method::kRaster, 1, {photographs()}});
    EXPECT_EQ(picture, drawn(view, {Method::kRaster, 3, {photographs()}}));
    EXPECT_EQ(picture, drawn(view, {Method::kPlain, 1, {photographs()}}));
  }
}

TEST(Photographs, EveryInstructionSetGivesTheSameColours) {
  const pixels::SceneParts& parts = lit().scene->parts();
  const pixels::Lattice lattice(kCamera);
  const pixels::TileRows rows{0, lattice.blocks_down * pixels::kBlock};
  const pixels::Pixels of{&lattice, nullptr, 1 / lattice.focal};
  const std::vector<const pixels::Photo*> photos{
      photographs()->photo(0).get(), photographs()->photo(1).get(), photographs()->photo(2).get()};
  for (const MeshView& view : views()) {
    const pixels::Eye eye(view.eye, view.heading, view.elevation);
    pixels::VisibilityBuffer frame;
    frame.resize(lattice.blocks_across, lattice.blocks_down);
    frame.clear(lattice, rows);
    pixels::best_rasteriser()({parts.tree, parts.surfaces, lattice, eye}, rows, frame);
    std::vector<std::vector<std::byte>> pictures;
    for (const pixels::Reprojector reprojector : pixels::reprojector_variants()) {
      const pixels::PixelPainter painter(parts, of, eye, {nullptr, reprojector}, photos);
      auto& rgb = pictures.emplace_back(std::size_t{3} * kCamera.width * kCamera.height);
      render::Outputs outputs;
      outputs.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, rgb};
      std::vector<std::uint32_t> lines(pixels::kTile *
                                       pixels::PixelPainter::line_pitch(kCamera.width));
      painter.paint(frame, rows, outputs, 0, lines);
      EXPECT_TRUE(rgb == pictures[0]) << pictures.size();
    }
  }
}

TEST(Photographs, ChoosesTheNearestThatSee) {
  std::array<std::size_t, 2> chosen{};
  EXPECT_EQ(photographs()->choose({-0.9, 0.1, 1.5}, chosen), 2U);
  EXPECT_EQ(chosen[0], 0U);
  EXPECT_EQ(photographs()->choose({2.5, 1.5, 1.2}, std::span(chosen).first(1)), 1U);
  EXPECT_EQ(chosen[0], 1U);
}

TEST(Photographs, EquirectangularPicturesTakeThemToo) {
  constexpr std::uint32_t kWidth = 160, kHeight = 80;
  const auto sphere = [&](const EyesConfig& config) {
    const MeshView view{0, {-0.9, 0.1, 1.45}, Radians(1), Radians(0)};
    std::vector<std::uint8_t> rgb(3 * kWidth * kHeight);
    render::Outputs outputs;
    outputs.colour = render::ColourOutput{
        render::ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(rgb))};
    Eyes({lit().scene}, config).render_equirectangular(kWidth, kHeight, {&view, 1}, outputs);
    return rgb;
  };
  const auto of_mesh = sphere({}), of_panoramas = sphere({Method::kRaster, 1, {photographs()}});
  EXPECT_NE(of_mesh, of_panoramas);
  EXPECT_GT(psnr(of_mesh, of_panoramas), 24);
}

TEST(Photographs, LittleMemoryGivesTheSamePictures) {
  PhotographsOptions options;
  options.bytes = 1;  // each panorama is dropped when the next one is read
  const auto forgetful = std::make_shared<const Photographs>(panoramas(places(), 256), ScanIndex(0),
                                                             lit().scene, options);
  Eyes eyes({lit().scene}, {Method::kRaster, 2, {forgetful}});
  std::vector<MeshView> all = views();
  const std::size_t bytes = 3 * kCamera.width * kCamera.height;
  std::vector<std::uint8_t> rgb(all.size() * bytes);
  render::Outputs outputs;
  outputs.colour =
      render::ColourOutput{render::ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(rgb))};
  eyes.render(kCamera, all, outputs);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_TRUE(std::ranges::equal(std::span(rgb).subspan(k * bytes, bytes),
                                   drawn(all[k], {Method::kRaster, 1, {photographs()}})));
  }
}

TEST(Photographs, MistakesAreNamed) {
  const auto set = panoramas(places(), 16);
  const auto fails = [&](auto make) -> std::string {
    try {
      make();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  PhotographsOptions options;
  options.face_size = 8;
  EXPECT_THAT(fails([&] { Photographs(set, ScanIndex(0), lit().scene, options); }),
              HasSubstr("face_size: 8"));
  options = {};
  options.nearest = 9;
  EXPECT_THAT(fails([&] { Photographs(set, ScanIndex(0), lit().scene, options); }),
              HasSubstr("nearest: 9"));
  EXPECT_THAT(fails([&] { Photographs(set, ScanIndex(1), lit().scene); }), HasSubstr("scan: 1"));
  EXPECT_THAT(fails([&] { Photographs(nullptr, ScanIndex(0), lit().scene); }), HasSubstr("none"));
  EXPECT_THAT(fails([&] { Photographs(set, ScanIndex(0), nullptr); }), HasSubstr("scene: none"));
  const auto empty = scan::PanoramaSet::of({std::make_shared<const scan::MemoryPanoramas>(
      graph(places()), std::vector<scan::Panorama>(3))});
  EXPECT_THAT(fails([&] { Photographs(empty, ScanIndex(0), lit().scene); }),
              HasSubstr("no viewpoint has pictures"));
  const auto other = Scene::photographed(lit().tracer);
  EXPECT_THAT(fails([&] {
                Eyes({other}, {Method::kRaster, 1, {photographs()}});
              }),
              HasSubstr("of another scene"));
  EXPECT_THAT(fails([&] {
                Eyes({other}, {Method::kRaster, 1, {nullptr, nullptr}});
              }),
              HasSubstr("config.photographs"));
}

TEST(Photographs, AppearancesHaveNames) {
  for (const Appearance appearance : {Appearance::kMesh, Appearance::kPanoramas}) {
    EXPECT_EQ(find_enum<Appearance>(enum_name(appearance)), appearance);
  }
  EXPECT_FALSE(find_enum<Appearance>("photos"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous
