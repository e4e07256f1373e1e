#include "enfilade/capture/import_panoramas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <algorithm>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/scan/store.h"
#include "tests/support/photo_files.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::capture {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

// A folder with two equirectangular pictures of 64 x 32 pixels.
class ImportPanoramas : public ::testing::Test {
 protected:
  ImportPanoramas() {
    for (const char* name : {"hall.jpg", "attic.jpg"}) {
      const auto jpeg = image::encode_jpeg(image::Image8(64, 32, 3), 90);
      write_file_atomically(folder_.path() / name, std::string(jpeg.begin(), jpeg.end()));
    }
  }
  std::string file(const char* name) const { return (folder_.path() / name).string(); }
  ImportReport import(const std::string& scan, const std::vector<PanoramaFiles>& panoramas,
                      const ImportOptions& options = {}) const {
    return import_panoramas(folder_.path(), scan, panoramas, options);
  }

  tests::TemporaryFolder folder_{"import_panoramas"};
};

// As HM3D names its buildings, and with the six digits that its viewpoints get.
TEST_F(ImportPanoramas, GoWithTheirIdsThroughGraphPicturesAndStore) {
  const std::string scan = "00000-kfPV7w3FaU5";
  const ImportReport report =
      import(scan, {{"000000", {file("hall.jpg")}}, {"000001", {file("attic.jpg")}}});
  EXPECT_EQ(report.viewpoints, 2U);
  EXPECT_EQ(report.added, 2U);
  EXPECT_EQ(report.edges, 1U);

  const fs::path connectivity = folder_.path() / "connectivity";
  EXPECT_THAT(scan::load_scan_list(connectivity), ElementsAre(scan));
  EXPECT_EQ(scan::load_connectivity(connectivity, scan).entries[1].id, "000001");

  const fs::path stores = folder_.path() / "store";
  const auto loose = scan::open_panoramas({{folder_.path()}, connectivity}, scan);
  EXPECT_EQ(loose->face_sizes(loose->at("000001"))[index(scan::Layer::kColour)], 16U);
  const scan::PackReport packed = scan::pack(*loose, stores, {});
  EXPECT_EQ(packed.file.filename(), scan + ".enfilade");
  const auto store = scan::open_panoramas({{stores}, {}}, scan);
  EXPECT_EQ(store->at("000001").at(), 1U);
  EXPECT_EQ(store->connectivity().scan, scan);
}

TEST_F(ImportPanoramas, AddToAScanAndKeepItsEdges) {
  import("home", {{"hall", {file("hall.jpg")}}});
  ImportOptions options;
  options.edges = ImportEdges::kNone;
  options.pairs = {{"attic", "hall"}};
  const ImportReport report = import("home", {{"attic", {file("attic.jpg")}}}, options);
  EXPECT_EQ(report.added, 1U);
  EXPECT_EQ(report.edges, 1U);
  EXPECT_DOUBLE_EQ(report.panoramas[0].position.x, kImportSpacing);
  EXPECT_THAT(
      [&] {
        import("home", {{"hall", {file("hall.jpg")}}});
      },
      ThrowsMessage<ArgumentError>(HasSubstr("is in scan home already")));
  options.force = true;
  EXPECT_EQ(import("home", {{"hall", {file("hall.jpg")}}}, options).added, 0U);
}

TEST_F(ImportPanoramas, AddToAScanWhoseGraphIsPacked) {
  import("home", {{"hall", {file("hall.jpg")}}});
  const fs::path graph = scan::connectivity_file(folder_.path() / "connectivity", "home");
  write_file_atomically(fs::path(graph.string() + ".gz"), gzip(read_file(graph), 6));
  fs::remove(graph);
  const ImportReport report = import("home", {{"attic", {file("attic.jpg")}}});
  EXPECT_EQ(report.added, 1U);
  EXPECT_EQ(scan::load_connectivity(folder_.path() / "connectivity", "home").entries.size(), 2U);
}

TEST_F(ImportPanoramas, LeaveTheScanAsItWasIfAPictureIsBroken) {
  write_file_atomically(folder_.path() / "broken.jpg", "GIF89a");
  EXPECT_THROW(import("home", {{"hall", {file("hall.jpg")}}, {"x", {file("broken.jpg")}}}),
               InvalidInput);
  EXPECT_FALSE(fs::exists(folder_.path() / "home"));
  EXPECT_FALSE(fs::exists(folder_.path() / "connectivity"));
}

TEST_F(ImportPanoramas, WriteNothingIfTheListOfScansIsBroken) {
  make_folder(folder_.path() / "connectivity");
  write_file_atomically(folder_.path() / "connectivity" / "scans.txt", "a a");
  EXPECT_THROW(import("home", {{"hall", {file("hall.jpg")}}}), InvalidInput);
  EXPECT_FALSE(fs::exists(folder_.path() / "home"));
  EXPECT_FALSE(fs::exists(scan::connectivity_file(folder_.path() / "connectivity", "home")));
}

TEST_F(ImportPanoramas, FollowNoLinkThatSomebodyPutIntoTheFolder) {
  const fs::path outside = folder_.path() / "outside";
  fs::create_directory(outside);
  for (const char* link : {"home", "connectivity"}) {
    fs::create_directory_symlink(outside, folder_.path() / link);
    EXPECT_THROW(import("home", {{"hall", {file("hall.jpg")}}}), FileError) << link;
    EXPECT_TRUE(fs::is_empty(outside)) << link;
    fs::remove(folder_.path() / link);
    fs::remove_all(folder_.path() / "home");
  }
}

TEST_F(ImportPanoramas, RefuseIdsAndCountsThatCannotBe) {
  EXPECT_THROW(import("../home", {{"hall", {file("hall.jpg")}}}), LookupError);
  EXPECT_THROW(import("home", {{"my hall", {file("hall.jpg")}}}), ArgumentError);
  EXPECT_THROW(import("home", {{"hall", {}}}), ArgumentError);
  EXPECT_THROW(import("home", {{"a", {file("hall.jpg")}}, {"a", {file("attic.jpg")}}}),
               ArgumentError);
  ImportOptions options;
  options.face_size = kLargestImportedFace + 1;
  EXPECT_THROW(import("home", {{"hall", {file("hall.jpg")}}}, options), ArgumentError);
}

// --- pictures as cameras write them ----------------------------------------------------------

// White sky over black ground, 64 x 32 pixels.
image::Image8 sky() {
  image::Image8 picture(64, 32, 3);
  std::fill_n(picture.pixels.begin(), picture.pixels.size() / 2, std::uint8_t{255});
  return picture;
}

class ImportPhotos : public ImportPanoramas {
 protected:
  void write(const char* name, const std::string& content) const {
    write_file_atomically(folder_.path() / name, content);
  }
  // The mean level of red of a face.
  double level(const std::string& viewpoint, CubeFace face) const {
    const auto source =
        scan::open_panoramas({{folder_.path()}, folder_.path() / "connectivity"}, "home");
    const auto faces =
        scan::read_panorama(*source, source->at(viewpoint), 1 << index(scan::Layer::kColour));
    const image::Image8& picture = faces.colour[index(face)];
    double sum = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 3) sum += picture.pixels[i];
    return 3 * sum / static_cast<double>(picture.pixels.size());
  }
  std::vector<std::string> codes(const ImportReport& report) const {
    std::vector<std::string> found;
    for (const Diagnostic& one : report.findings) found.push_back(one.code);
    return found;
  }
};

TEST_F(ImportPhotos, AreTurnedByExif) {
  write("hall.jpg", tests::with_orientation(tests::jpeg_of(sky()), 3));
  const ImportReport report = import("home", {{"hall", {file("hall.jpg")}}});
  EXPECT_THAT(codes(report), ElementsAre("orientation"));
  EXPECT_GT(level("hall", CubeFace::kDown), 250);
  EXPECT_LT(level("hall", CubeFace::kUp), 5);
}

TEST_F(ImportPhotos, AreTurnedByExifAsFacesToo) {
  const image::Image8 black(16, 16, 3);
  image::Image8 half(16, 16, 3);
  std::fill_n(half.pixels.begin(), half.pixels.size() / 2, std::uint8_t{255});
  PanoramaFiles faces{"hall", {}};
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const std::string name = "face" + std::to_string(k) + ".jpg";
    const bool front = k == index(CubeFace::kFront);
    const std::string jpeg = tests::jpeg_of(front ? half : black);
    write(name.c_str(), front ? tests::with_orientation(jpeg, 3) : jpeg);
    faces.files.push_back(file(name.c_str()));
  }
  EXPECT_THAT(codes(import("home", {faces})), ElementsAre("orientation"));
  const auto source =
      scan::open_panoramas({{folder_.path()}, folder_.path() / "connectivity"}, "home");
  const auto panorama =
      scan::read_panorama(*source, source->at("hall"), 1 << index(scan::Layer::kColour));
  const image::Image8& front = panorama.colour[index(CubeFace::kFront)];
  EXPECT_LT(front.at(8, 2)[0], 5);
  EXPECT_GT(front.at(8, 13)[0], 250);
}

TEST_F(ImportPhotos, AreLevelledAndHeadedByGpano) {
  // The camera lay on its back: the picture's middle is the zenith. Then the bright half is that
  // behind the camera's top: -z of the level frame.
  const std::string jpeg = tests::jpeg_of(sky());
  write("hall.jpg", tests::with_xmp(jpeg, tests::gpano({{"PosePitchDegrees", "90"},
                                                        {"PoseHeadingDegrees", "90"}})));
  const ImportReport report = import("home", {{"hall", {file("hall.jpg")}}});
  EXPECT_THAT(codes(report), ElementsAre("levelled", "own-heading"));
  EXPECT_GT(level("hall", CubeFace::kBack), 250);
  EXPECT_LT(level("hall", CubeFace::kFront), 5);
  // Heading 90 is east: the panorama's forward axis, the third column of the pose, is world +x.
  const auto graph = scan::load_connectivity(folder_.path() / "connectivity", "home");
  EXPECT_NEAR(graph.entries[0].pose[2], 1, 1e-6);

  ImportOptions given;
  given.heading = 0;
  given.force = true;
  EXPECT_THAT(codes(import("home", {{"hall", {file("hall.jpg")}}}, given)),
              ElementsAre("levelled"));
}

TEST_F(ImportPhotos, KeepThePictureWithoutItsPose) {
  write("hall.jpg",
        tests::with_xmp(tests::jpeg_of(sky()),
                        tests::gpano({{"PosePitchDegrees", "90"}, {"PoseHeadingDegrees", "90"}})));
  ImportOptions options;
  options.use_pose = false;
  EXPECT_THAT(codes(import("home", {{"hall", {file("hall.jpg")}}}, options)), IsEmpty());
  EXPECT_GT(level("hall", CubeFace::kUp), 250);
  const auto graph = scan::load_connectivity(folder_.path() / "connectivity", "home");
  EXPECT_NEAR(graph.entries[0].pose[2], 0, 1e-6);
}

TEST_F(ImportPhotos, SayWhatPartOfASphereTheyAre) {
  // The middle half of the heights: 64 x 16 of 64 x 32.
  const image::Image8 band(64, 16, 3);
  image::Image8 white = band;
  std::ranges::fill(white.pixels, std::uint8_t{255});
  const auto fields = [](const char* full_height) {
    return tests::gpano({{"FullPanoWidthPixels", "64"},
                         {"FullPanoHeightPixels", full_height},
                         {"CroppedAreaImageWidthPixels", "64"},
                         {"CroppedAreaImageHeightPixels", "16"},
                         {"CroppedAreaLeftPixels", "0"},
                         {"CroppedAreaTopPixels", "8"}});
  };
  write("hall.jpg", tests::with_xmp(tests::jpeg_of(white), fields("32")));
  const ImportReport report = import("home", {{"hall", {file("hall.jpg")}}});
  ASSERT_EQ(report.findings.size(), 1U);
  EXPECT_EQ(report.findings[0].severity, Severity::kWarning);
  EXPECT_EQ(report.findings[0].message,
            "GPano: 64 x 16 of 64 x 32 pixels, 360 x 90 degrees; other directions are black");
  // Its corners are below 45 degrees: 1 - pi / 4 of it.
  EXPECT_LT(level("hall", CubeFace::kUp), 90);
  EXPECT_GT(level("hall", CubeFace::kFront), 200);

  write("attic.jpg", tests::with_xmp(tests::jpeg_of(white), fields("40")));
  EXPECT_THAT(
      [&] {
        import("home", {{"attic", {file("attic.jpg")}}});
      },
      ThrowsMessage<InvalidInput>(
          HasSubstr("64 x 16 pixels, not twice as wide as high: no panorama of all "
                    "directions; a crop of 64 x 16 of 64 x 40 pixels (GPano) does not "
                    "fit")));
}

// Pictures, and spheres around their parts, have no more pixels than faces need.
TEST_F(ImportPhotos, AreReducedWhileTheyAreRead) {
  image::Image8 wide(16'384, 8'192, 1);
  std::fill_n(wide.pixels.begin(), wide.pixels.size() / 2, std::uint8_t{255});
  const auto png = image::encode_png(wide);
  write("hall.png", {png.begin(), png.end()});
  const ImportReport report = import("home", {{"hall", {file("hall.png")}}});
  EXPECT_THAT(codes(report), ElementsAre("reduced-picture"));
  EXPECT_EQ(report.panoramas[0].face_size, 1024U);
  EXPECT_GT(level("hall", CubeFace::kUp), 250);
  EXPECT_LT(level("hall", CubeFace::kDown), 5);

  image::Image8 part(200, 100, 3);
  std::ranges::fill(part.pixels, std::uint8_t{255});
  write("attic.jpg",
        tests::with_xmp(tests::jpeg_of(part), tests::gpano({{"FullPanoWidthPixels", "20000"},
                                                            {"FullPanoHeightPixels", "10000"},
                                                            {"CroppedAreaImageWidthPixels", "200"},
                                                            {"CroppedAreaImageHeightPixels", "100"},
                                                            {"CroppedAreaLeftPixels", "9900"},
                                                            {"CroppedAreaTopPixels", "4950"}})));
  EXPECT_THAT(codes(import("home", {{"attic", {file("attic.jpg")}}})),
              ElementsAre("cropped-sphere"));
  EXPECT_GT(level("attic", CubeFace::kFront), 0);
  EXPECT_LT(level("attic", CubeFace::kBack), 1);
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  EXPECT_LT(used.ru_maxrss, 900'000) << "kilobytes; it was 1.2 GB";
}

// No copy of such a part is smaller: making it so had no end.
TEST_F(ImportPhotos, OfOnePixelOfALargeSphereAreRefused) {
  write("hall.jpg", tests::with_xmp(tests::jpeg_of(image::Image8(1, 1, 3)),
                                    tests::gpano({{"FullPanoWidthPixels", "20000"},
                                                  {"FullPanoHeightPixels", "10000"},
                                                  {"CroppedAreaImageWidthPixels", "1"},
                                                  {"CroppedAreaImageHeightPixels", "1"},
                                                  {"CroppedAreaLeftPixels", "0"},
                                                  {"CroppedAreaTopPixels", "0"}})));
  EXPECT_THAT(
      [&] {
        import("home", {{"hall", {file("hall.jpg")}}});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("of 20000 x 10000 pixels (GPano) does not fit")));
}

TEST_F(ImportPhotos, NameAProjectionThatIsAnother) {
  write("hall.jpg",
        tests::with_xmp(tests::jpeg_of(sky()), tests::gpano({{"ProjectionType", "cylindrical"}})));
  EXPECT_THAT(codes(import("home", {{"hall", {file("hall.jpg")}}})),
              ElementsAre("unknown-projection"));
}

TEST_F(ImportPhotos, MayHaveZerosBeforeTheirEnd) {
  const auto bytes = image::encode_jpeg(image::Image8(64, 32, 3), 90);
  std::string jpeg(bytes.begin(), bytes.end());
  // More than the eight bytes that libjpeg may have read ahead, which it does not count.
  jpeg.insert(jpeg.size() - 2, 20, '\0');
  write("hall.jpg", jpeg);
  EXPECT_THAT(codes(import("home", {{"hall", {file("hall.jpg")}}})), ElementsAre("odd-jpeg"));
}

// --- lists of positions ----------------------------------------------------------------------

std::string utf16(std::string_view ascii) {
  std::string text = "\xff\xfe";
  for (const char c : ascii) (text += c) += '\0';
  return text;
}

struct List {
  const char* name;
  std::string text;
};

TEST_F(ImportPanoramas, ReadPositionsAsSpreadsheetsSaveThem) {
  const std::vector<List> lists{
      {"blanks", "hall 1.5 -2 1.4 90\nattic 0 0 4\n"},
      {"commas", "name,x,y,z,heading\nhall,1.5,-2,1.4,90\nattic,0,0,4\n"},
      {"commas and blanks", "hall, 1.5, -2, 1.4, 90\nattic, 0, 0, 4\n"},
      {"a byte-order mark before a header",
       "\xef\xbb\xbfname,x,y,z\r\nhall,1.5,-2,1.4,90\r\nattic,0,0,4\r\n"},
      {"a byte-order mark before a name", "\xef\xbb\xbfhall 1.5 -2 1.4 90\r\nattic 0 0 4\r\n"},
      {"semicolons and decimal commas",
       "Name;X;Y;Z;Heading\r\nhall;1,5;-2;1,4;90\r\nattic;0;0;4;\r\n"},
      {"semicolons and points", "filename;x;y;z\nhall.jpg;1.5;-2;1.4;90\nattic.JPG;0;0;4\n"},
      {"a header of two words", "File name,x,y,z\nhall,1.5,-2,1.4,90\nattic,0,0,4\n"},
      {"semicolons, no header", "hall; 1,5; -2,0; 1,4; 90,0\nattic; 0; 0; 4\n"},
      {"tabs and decimal commas",
       "Image\tX [m]\tY [m]\tZ [m]\nhall\t1,5\t-2\t1,4\t90\n"
       "attic\t0\t0\t4\n"},
      {"quotes and folders",
       "\"File\",\"x\",\"y\",\"z\"\n\"photos/hall.jpg\",\"1.5\","
       "\"-2\",\"1.4\",\"90\"\nphotos\\attic.png,0,0,4\n"},
      {"UTF-16", utf16("hall 1.5 -2 1.4 90\nattic 0 0 4\n")},
      {"comments", "# tripod\n\nhall 1.5 -2 1.4 90 # by the door\nattic 0 0 4\n"}};
  for (const List& list : lists) {
    SCOPED_TRACE(list.name);
    write_file_atomically(folder_.path() / "p.csv", list.text);
    ImportOptions options;
    options.positions = folder_.path() / "p.csv";
    options.force = true;
    const ImportReport report =
        import("home", {{"hall", {file("hall.jpg")}}, {"attic", {file("attic.jpg")}}}, options);
    EXPECT_EQ(report.panoramas[0].position, (Vec3d{1.5, -2, 1.4}));
    EXPECT_EQ(report.panoramas[1].position, (Vec3d{0, 0, 4}));
    const auto graph = scan::load_connectivity(folder_.path() / "connectivity", "home");
    EXPECT_NEAR(graph.entries[0].pose[2], 1, 1e-6) << "heading 90";
  }
}

TEST_F(ImportPanoramas, RefusePositionsThatAreAmbiguous) {
  const std::vector<std::pair<std::string, const char*>> lists{
      {"hall,1,5,-2,0,1,4\n",
       "line 1: 7 values, not 4 or 5: name x y z [heading]; decimal commas "
       "need semicolons between values"},
      {"name,y,x,z\nhall,1,2,3\n", "columns \"name y x z\"; the order is: name x y z [heading]"},
      {"Name;Heading;X;Y;Z\nhall;90;1;2;3\n", "columns \"Name Heading X Y Z\"; the order is"},
      {";1;2;3;90\n", "line 1: no name before x y z"},
      {"hall;1;;2;90\n", "line 1: \"\" is not a number of metres or degrees"},
      {"hall,1, ,2,90\n", "line 1: \"\" is not a number of metres or degrees"},
      {"hall 1 2 3\nhall.jpg 1 2 3\n", "line 2: \"hall\" has a position already"}};
  for (const auto& [text, says] : lists) {
    write_file_atomically(folder_.path() / "p.csv", text);
    ImportOptions options;
    options.positions = folder_.path() / "p.csv";
    EXPECT_THAT(
        [&] {
          import("home", {{"hall", {file("hall.jpg")}}}, options);
        },
        ThrowsMessage<InvalidInput>(HasSubstr(says)));
  }
}

// As cameras name their pictures. Enfilade's files hold such ids; others cut them.
TEST_F(ImportPanoramas, NoteIdsWithBars) {
  const ImportReport report =
      import("home", {{"IMG_1_01", {file("hall.jpg")}}, {"hall", {file("hall.jpg")}}});
  ASSERT_EQ(report.findings.size(), 1U);
  EXPECT_EQ(report.findings[0].severity, Severity::kNote);
  EXPECT_EQ(report.findings[0].message,
            "ids with \"_\": 1, the first \"IMG_1_01\": programs of others may cut names there; "
            "\"IMG-1-01\" is safe");
  const auto source =
      scan::open_panoramas({{folder_.path()}, folder_.path() / "connectivity"}, "home");
  EXPECT_EQ(source->at("IMG_1_01").at(), 0U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::capture
