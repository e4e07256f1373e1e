#include "enfilade/capture/scan_files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/mesh/capture.h"
#include "enfilade/scan/depth_skybox.h"
#include "enfilade/scan/matterport_cameras.h"
#include "enfilade/scan/matterport_images.h"
#include "tests/support/furnished_room.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::capture {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using tests::refusal;
using tests::TemporaryFolder;

std::shared_ptr<const mesh::LitMesh> lit(mesh::Mesh mesh) {
  mesh::BakeOptions bake;
  bake.spacing = .6;
  bake.rays = 16;
  mesh::Lights lights;
  lights.lamps.push_back({{2, 2.5F, 2.5F}, {6, 6, 5}, .1F});
  lights.lamps.push_back({{6, 2.5F, 2.5F}, {6, 5, 4}, .1F});
  return std::make_shared<const mesh::LitMesh>(
      std::make_shared<const mesh::RayTracer>(std::make_shared<const mesh::Mesh>(std::move(mesh))),
      lights, bake);
}

/// One for all tests of this file.
const mesh::LitMesh& rooms() {
  static const auto kRooms = lit(tests::furnished_rooms());
  return *kRooms;
}

mesh::CubeCapture truth(const mesh::LitMesh& mesh, const scan::PanoramaPose& pose,
                        std::uint32_t size) {
  mesh::CaptureOptions options;
  options.colour = false;
  return capture_cube(mesh, pose.world_from_panorama, pose.position, size, options);
}

ScanFilesOptions small(const std::function<void(ScanParts&)>& wanted) {
  ScanFilesOptions options;
  wanted(options.parts);
  options.face_size = 48;
  options.image_width = 160;
  options.samples = 1;
  options.rooms = tests::furnished_room_list();
  return options;
}

void all_parts(ScanParts& parts) { parts = {true, true, true, true, true, true, true}; }

std::shared_ptr<const scan::PanoramaSource> open(const fs::path& root) {
  return scan::open_matterport_images(root, root / "connectivity", "rooms");
}

std::size_t files_below(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::ranges::count_if(fs::recursive_directory_iterator(folder),
                            [](const auto& entry) { return entry.is_regular_file(); }));
}

TEST(ScanFiles, AreAScanToOurReaders) {
  const TemporaryFolder root("scan_files");
  const auto graph = tests::furnished_room_graph();
  const ScanFilesReport report = write_scan(rooms(), graph, root.path(), small(all_parts));
  EXPECT_EQ(report.viewpoints, 2U);
  EXPECT_EQ(report.written, 2U * (7 + 1 + 2 + 36));
  EXPECT_EQ(report.kept, 0U);
  EXPECT_THAT(scan::load_scan_list(root.path() / "connectivity"), ::testing::ElementsAre("rooms"));
  const auto source = open(root.path());
  EXPECT_EQ(to_json(source->connectivity()), to_json(graph));
  EXPECT_EQ(source->face_sizes(ViewpointIndex(2)), scan::FaceSizes{}) << "it is excluded";
  for (const std::size_t k : {0U, 1U}) {
    SCOPED_TRACE(k);
    const scan::Panorama read = read_panorama(*source, ViewpointIndex(k));
    const auto exact = truth(rooms(), source->poses()[k], 48);
    EXPECT_EQ(read.depth, exact.depth);
    EXPECT_EQ(read.classes, exact.classes);
    EXPECT_EQ(read.instances, exact.instances);
    EXPECT_EQ(read.colour[3].width, 48U);
  }
}

TEST(ScanFiles, HaveFacesAndStripsOfOnePicture) {
  const TemporaryFolder root("scan_files");
  auto options = small([](ScanParts& p) { p.faces = p.colour_strip = true; });
  options.jpeg_quality = 100;
  const auto report = write_scan(rooms(), tests::furnished_room_graph(), root.path(), options);
  const auto strip = read_panorama(*open(root.path()), ViewpointIndex(0)).colour;
  fs::remove(report.folder / "matterport_skybox_images" / "a_skybox_small.jpg");
  const auto faces = read_panorama(*open(root.path()), ViewpointIndex(0)).colour;
  const scan::PanoramaPose pose = open(root.path())->poses()[0];
  mesh::CaptureOptions capture;
  capture.samples = 1;
  const auto taken =
      capture_cube(rooms(), pose.world_from_panorama, pose.position, 48, capture).colour;
  for (std::size_t f = 0; f < kCubeFaces; ++f) {
    for (std::size_t i = 0; i < taken[f].pixels.size(); ++i) {
      // JPEG at its best errs by a few levels of 255.
      ASSERT_NEAR(strip[f].pixels[i], taken[f].pixels[i], 6);
      ASSERT_NEAR(faces[f].pixels[i], taken[f].pixels[i], 6);
    }
  }
}

TEST(ScanFiles, HaveHouseFilesThatGiveTheLabelsBack) {
  const TemporaryFolder root("scan_files");
  const auto report = write_scan(rooms(), tests::furnished_room_graph(), root.path(),
                                 small([](ScanParts& p) { p.house = p.label_strips = true; }));
  const fs::path folder = report.folder / "house_segmentations";
  EXPECT_EQ(read_file(folder / "panorama_to_region.txt"), "0 a 0 l\n1 b 1 b\n");
  const mesh::House house = mesh::parse_house(read_file(folder / "rooms.house"), "rooms.house");
  EXPECT_EQ(house.images.size(), 36U);
  EXPECT_EQ(house.panoramas[1].name, "b");
  const auto labelled = lit(mesh::read_house_mesh(folder, "rooms"));
  std::size_t pixels = 0, same = 0, seen = 0;
  for (const scan::PanoramaPose& pose : poses_of(tests::furnished_room_graph())) {
    const auto exact = truth(rooms(), pose, 128), found = truth(*labelled, pose, 128);
    for (std::size_t f = 0; f < kCubeFaces; ++f) {
      for (std::size_t i = 0; i < exact.classes[f].pixels.size(); ++i, ++pixels) {
        const auto instance = exact.instances[f].pixels[i];
        same += exact.classes[f].pixels[i] == found.classes[f].pixels[i] &&
                instance == found.instances[f].pixels[i];
        seen += instance != 0;
      }
    }
  }
  EXPECT_GT(seen, pixels * 9 / 10);
  // The files hold the same triangles in the same order, to the last bit.
  EXPECT_EQ(same, pixels);
}

TEST(ScanFiles, ShowLabelsOfAnotherMeshOfTheBuilding) {
  // Labels from house files beside a mesh that has none: what owners of Matterport3D do.
  const TemporaryFolder root("scan_files");
  mesh::Mesh plain = tests::furnished_rooms();
  plain.objects.clear();
  plain.triangle_object.clear();
  auto options = small([](ScanParts& p) { p.label_strips = p.colour_strip = true; });
  options.label_mesh = &rooms();
  write_scan(*lit(plain), tests::furnished_room_graph(), root.path(), options);
  const auto source = open(root.path());
  EXPECT_EQ(read_panorama(*source, ViewpointIndex(0)).instances,
            truth(rooms(), source->poses()[0], 48).instances);
}

/// Shares of errors, metres, of what is known.
struct Errors {
  double median = 0, p95 = 0, largest = 0;
  double known = 0;  ///< share of texels
};

Errors errors_of(const image::CubeMap<std::uint16_t>& found,
                 const image::CubeMap<std::uint16_t>& exact) {
  std::vector<double> errors;
  std::size_t texels = 0;
  for (std::size_t f = 0; f < kCubeFaces; ++f) {
    for (std::size_t i = 0; i < exact[f].pixels.size(); ++i, ++texels) {
      if (found[f].pixels[i] == 0) continue;
      errors.push_back(std::abs(found[f].pixels[i] - exact[f].pixels[i]) /
                       scan::kDepthUnitsPerMetre);
    }
  }
  std::ranges::sort(errors);
  return {errors[errors.size() / 2], errors[errors.size() * 95 / 100], errors.back(),
          static_cast<double>(errors.size()) / static_cast<double>(texels)};
}

/// As open_matterport_images() does it, less the holes' filling.
image::CubeMap<std::uint16_t> rebuilt(const fs::path& folder, const scan::PanoramaPose& eye,
                                      std::uint32_t size) {
  const auto cameras = scan::parse_undistorted_cameras(
      read_file(folder / "undistorted_camera_parameters/rooms.conf"), "rooms.conf");
  std::vector<scan::DepthImage> images;
  for (const scan::UndistortedCamera& camera : cameras) {
    if (camera.viewpoint() != eye.viewpoint) continue;
    const std::string png = read_file(folder / "undistorted_depth_images" / camera.depth_file);
    images.push_back({camera, image::decode_png16(image::bytes_of(png), camera.depth_file)});
  }
  EXPECT_EQ(images.size(), 18U);
  return scan::depth_skybox(images, eye, size);
}

TEST(ScanFiles, HaveImagesOutOfWhichDepthIsBuiltAgain) {
  const TemporaryFolder root("scan_files");
  auto options = small([](ScanParts& p) { p.undistorted = p.faces = true; });
  options.image_width = 640;
  options.face_size = 192;
  const auto report = write_scan(rooms(), tests::furnished_room_graph(), root.path(), options);
  const auto source = open(root.path());
  for (const std::size_t k : {0U, 1U}) {
    SCOPED_TRACE(k);
    const auto exact = truth(rooms(), source->poses()[k], 192).depth;
    const Errors bare = errors_of(rebuilt(report.folder, source->poses()[k], 192), exact);
    // The cameras leave out caps of 23 degrees around zenith and nadir.
    EXPECT_GT(bare.known, .9);
    // On walls 1 / z is linear, so that rounding is left (0.25 mm, twice); the rest are texels at
    // steps in depth. The aims of the issue: 5 mm and 5 cm.
    EXPECT_LT(bare.median, .0005);
    EXPECT_LT(bare.p95, .05);
    const Errors filled = errors_of(read_panorama(*source, ViewpointIndex(k)).depth, exact);
    EXPECT_EQ(filled.known, 1);
    EXPECT_LT(filled.median, .005);
    EXPECT_LT(filled.p95, .05);
    RecordProperty(fmt::format("bare_p95_mm_{}", k), std::to_string(1000 * bare.p95));
    RecordProperty(fmt::format("filled_p95_mm_{}", k), std::to_string(1000 * filled.p95));
  }
}

TEST(ScanFiles, GoOnWhereTheyStopped) {
  const TemporaryFolder root("scan_files");
  const auto graph = tests::furnished_room_graph();
  const auto options = small(all_parts);
  const auto first = write_scan(rooms(), graph, root.path(), options);
  const fs::path gone = first.folder / "undistorted_color_images/b_i1_3.jpg";
  const fs::path kept = first.folder / "matterport_skybox_images/a_skybox_small.jpg";
  const std::string bytes = read_file(gone);
  const auto time = fs::last_write_time(kept);
  const std::size_t files = files_below(root.path());
  fs::remove(gone);
  const auto second = write_scan(rooms(), graph, root.path(), options);
  EXPECT_EQ(second.written, 2U) << "colour and depth are taken together";
  EXPECT_EQ(second.kept, first.written - 2);
  EXPECT_EQ(read_file(gone), bytes);
  EXPECT_EQ(fs::last_write_time(kept), time);
  EXPECT_EQ(files_below(root.path()), files) << "nothing is left behind";
}

TEST(ScanFiles, TakePartsAndViewpointsLater) {
  const TemporaryFolder root("scan_files");
  auto graph = tests::furnished_room_graph();
  write_scan(rooms(), graph, root.path(), small([](ScanParts& p) { p.depth_strip = true; }));
  graph.entries[2].included = true;
  const auto report =
      write_scan(rooms(), graph, root.path(),
                 small([](ScanParts& p) { p.depth_strip = p.label_strips = true; }));
  EXPECT_EQ(report.kept, 2U);
  EXPECT_EQ(report.written, 1U + 3 * 2);
  EXPECT_EQ(open(root.path())->face_sizes(ViewpointIndex(2))[scan::index(scan::Layer::kClass)],
            48U);
}

TEST(ScanFiles, AreTheSameForAnyNumberOfThreads) {
  const TemporaryFolder one("scan_files_1"), two("scan_files_2");
  auto options = small(all_parts);
  options.threads = 1;
  const auto a = write_scan(rooms(), tests::furnished_room_graph(), one.path(), options);
  options.threads = 2;
  const auto b = write_scan(rooms(), tests::furnished_room_graph(), two.path(), options);
  for (const auto& entry : fs::recursive_directory_iterator(a.folder)) {
    if (!entry.is_regular_file()) continue;
    const fs::path twin = b.folder / fs::relative(entry.path(), a.folder);
    EXPECT_TRUE(read_file(entry.path()) == read_file(twin)) << twin;
  }
}

TEST(ScanFiles, LeaveAloneWhatTheyDidNotMake) {
  const TemporaryFolder root("scan_files");
  const auto graph = tests::furnished_room_graph();
  const fs::path folder = root.path() / "v1/scans/rooms/matterport_skybox_images";
  fs::create_directories(folder);
  write_file_atomically(folder / "b_skybox2_sami.jpg", "a download");
  const auto options = small([](ScanParts& p) { p.faces = true; });
  EXPECT_THAT(refusal([&] { write_scan(rooms(), graph, root.path(), options); }),
              HasSubstr("b_skybox2_sami.jpg: is in the way: not made by Enfilade"));
  EXPECT_EQ(read_file(folder / "b_skybox2_sami.jpg"), "a download");
  EXPECT_EQ(files_below(root.path()), 1U);
  // But what a download lacks may be put beside it.
  const auto labels = small([](ScanParts& p) { p.label_strips = true; });
  EXPECT_EQ(write_scan(rooms(), graph, root.path(), labels).written, 4U);
  EXPECT_THAT(refusal([&] { write_scan(rooms(), graph, root.path(), options); }),
              HasSubstr("b_skybox2_sami.jpg: is in the way: not made by Enfilade"));
}

TEST(ScanFiles, DoNotMixScansOfOtherOptions) {
  const TemporaryFolder root("scan_files");
  auto graph = tests::furnished_room_graph();
  auto options = small([](ScanParts& p) { p.depth_strip = true; });
  write_scan(rooms(), graph, root.path(), options);
  options.samples = 4;
  EXPECT_THAT(refusal([&] { write_scan(rooms(), graph, root.path(), options); }),
              HasSubstr("rooms: is in the way: a scan made of another mesh or with other options"));
  options.samples = 1;
  mesh::Mesh other = tests::furnished_rooms();
  other.positions[0].x += .01F;
  EXPECT_THAT(refusal([&] { write_scan(*lit(other), graph, root.path(), options); }),
              HasSubstr("a scan made of another mesh"));
  graph.entries[1].pose[3] += .01;
  EXPECT_THAT(refusal([&] { write_scan(rooms(), graph, root.path(), options); }),
              HasSubstr("its viewpoint b stands elsewhere"));
}

TEST(ScanFiles, RefuseViewpointsWhoseIdsLeadOutOfTheFolder) {
  const TemporaryFolder root("scan_files");
  for (const char* id : {"../../../../../x", "/x", "a/b", "", ".x"}) {
    auto graph = tests::furnished_room_graph();
    graph.entries[1].id = id;
    EXPECT_THAT([&] { write_scan(rooms(), graph, root.path() / "p" / "out", small(all_parts)); },
                ::testing::ThrowsMessage<ArgumentError>(HasSubstr("scan rooms: viewpoint")))
        << id;
  }
  EXPECT_TRUE(fs::is_empty(root.path()));
}

TEST(ScanFiles, FollowNoLinkThatSomebodyPutIntoTheFolder) {
  const auto options = small([](ScanParts& p) { p.faces = p.mesh = p.connectivity = true; });
  for (const char* link : {"v1", "v1/scans/rooms", "v1/scans/rooms/matterport_skybox_images",
                           "v1/scans/rooms/matterport_mesh", "connectivity"}) {
    SCOPED_TRACE(link);
    const TemporaryFolder root("scan_files");
    const fs::path out = root.path() / "out", outside = root.path() / "outside";
    fs::create_directory(outside);
    fs::create_directories((out / link).parent_path());
    fs::create_directory_symlink(outside, out / link);
    EXPECT_THROW(write_scan(rooms(), tests::furnished_room_graph(), out, options), FileError);
    EXPECT_TRUE(fs::is_empty(outside));
  }
  // A link in place of a file is replaced.
  const TemporaryFolder root("scan_files");
  const fs::path file = "v1/scans/rooms/matterport_skybox_images/a_skybox0_sami.jpg";
  const fs::path outside = root.path() / "outside", out = root.path() / "out";
  fs::create_directories((out / file).parent_path());
  fs::create_symlink(outside, out / file);
  write_scan(rooms(), tests::furnished_room_graph(), out, options);
  EXPECT_FALSE(fs::exists(outside));
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(out / file)));
}

TEST(ScanFiles, RemoveWhatAKilledRunLeft) {
  const TemporaryFolder root("scan_files");
  const auto options = small([](ScanParts& p) { p.faces = p.connectivity = true; });
  const fs::path folder =
      write_scan(rooms(), tests::furnished_room_graph(), root.path(), options).folder;
  const fs::path users = folder / "matterport_skybox_images" / "backup.tar.part900900900";
  write_file_atomically(users, "a user's");
  const std::size_t files = files_below(root.path());
  for (const fs::path& left :
       {folder / "matterport_skybox_images" / "a_skybox0_sami.jpg", folder / "enfilade_scan.json",
        root.path() / "connectivity" / "rooms_connectivity.json",
        root.path() / "connectivity" / "scans.txt"}) {
    write_file_atomically(left.string() + ".part999999999", "half");
  }
  write_scan(rooms(), tests::furnished_room_graph(), root.path(), options);
  EXPECT_EQ(files_below(root.path()), files);
  EXPECT_TRUE(fs::exists(users));
}

TEST(ScanFiles, RefuseArgumentsOutOfRange) {
  const TemporaryFolder root("scan_files");
  const auto with = [&](const std::function<void(ScanFilesOptions&)>& change,
                        const std::string& scan = "rooms") {
    auto options = small([](ScanParts& p) { p.depth_strip = true; });
    change(options);
    return refusal(
        [&] { write_scan(rooms(), tests::furnished_room_graph(scan), root.path(), options); });
  };
  EXPECT_THAT(with([](auto& o) { o.face_size = 0; }), HasSubstr("face_size: 0, not from 1"));
  EXPECT_THAT(with([](auto& o) { o.samples = 3; }), HasSubstr("samples: 3, not 1, 4, 9 or 16"));
  EXPECT_THAT(with([](auto& o) { o.jpeg_quality = 101; }), HasSubstr("jpeg_quality: 101"));
  EXPECT_THAT(with([](auto& o) { o.image_width = 9; }), HasSubstr("image_width: 9"));
  EXPECT_THAT(with([](auto&) {}, "../x"), HasSubstr("scan \"../x\" is not an id"));
  EXPECT_EQ(files_below(root.path()), 0U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::capture
