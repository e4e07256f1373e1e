#include "enfilade/image/codecs.h"
#include "tests/bad_input/harness.h"
#include "tests/support/photo_files.h"

namespace enfilade::bad_input {
namespace {

std::string text(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

std::string jpeg(std::uint32_t width, std::uint32_t height) {
  return text(image::encode_jpeg(image::Image8(width, height, 3), 90));
}

// Two panoramas, six faces and their places, all good; then what is wrong with them.
Case import(std::string input, const std::string& arguments, int exit_code, std::string says,
            const std::function<void(Files&)>& damage = {}) {
  return {"Pictures to import",
          std::move(input),
          "import " + arguments,
          exit_code,
          std::move(says),
          [damage](Files& files) {
            files.write("hall.jpg", jpeg(64, 32));
            files.write("attic.jpg", jpeg(64, 32));
            for (const char* face : {"f", "r", "b", "l", "u", "d"}) {
              files.write(std::string(face) + ".jpg", jpeg(16, 16));
            }
            files.write("places.csv", "name,x,y,z\nhall,0,0,1.5\nattic,1,2,4.5\n");
            if (damage) damage(files);
          }};
}

constexpr const char* kTwo = "--scan home -o new hall.jpg attic.jpg";
constexpr const char* kFaces =
    "--scan home -o new --name a --faces frblud f.jpg r.jpg b.jpg l.jpg u.jpg d.jpg";

}  // namespace

std::vector<Case> import_cases() {
  const std::string two = kTwo, placed = two + " --positions places.csv", faces = kFaces;
  const auto place = [](const char* line) {
    return [=](Files& f) { f.edit("places.csv", "attic,1,2,4.5", line); };
  };
  return {
      import("an HDR whose name says JPEG: its first bytes count", two, 0,
             "scan home: 2 imported; viewpoints now: 2; edges: 1",
             [](Files& f) {
               std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n";
               for (int i = 0; i < 8 * 16; ++i) hdr += "\x40\x40\x40\x80";
               f.write("hall.jpg", hdr);
             }),
      import("a PNG of 16 bits a colour", two, 0,
             "scan home: 2 imported; viewpoints now: 2; edges: 1",
             [](Files& f) { f.write("hall.jpg", tests::colour_of_sixteen_bits()); }),
      import("ids as HM3D has them, which are good",
             "--scan 00000-kfPV7w3FaU5 --name 000001 -o new hall.jpg", 0,
             "scan 00000-kfPV7w3FaU5: 1 imported"),
      import("a picture that is not there", "--scan home -o new none.jpg", 3,
             "none.jpg: cannot open"),
      import("a pipe in a picture's place", two, 3,
             "hall.jpg: cannot read: a pipe that no program writes to",
             [](Files& f) { f.write("hall.jpg", kPipe); }),
      import("an empty picture", two, 3, "hall.jpg: the file is empty",
             [](Files& f) { f.write("hall.jpg", ""); }),
      import("a file that is no picture", two, 3, "neither JPEG, nor PNG, nor Radiance HDR",
             [](Files& f) { f.write("hall.jpg", "GIF89a"); }),
      import("a picture cut off in the middle", two, 3, "attic.jpg: the JPEG is damaged",
             [](Files& f) {
               f.write("attic.jpg", jpeg(512, 256).substr(0, jpeg(512, 256).size() - 100));
             }),
      import("a picture that is no panorama", two, 3,
             "attic.jpg: 64 x 48 pixels, not twice as wide as high",
             [](Files& f) { f.write("attic.jpg", jpeg(64, 48)); }),
      import("a panorama that EXIF turns", two, 0, "hall.jpg: EXIF orientation 3: turned by half",
             [](Files& f) { f.write("hall.jpg", tests::with_orientation(jpeg(64, 32), 3)); }),
      import("a panorama that EXIF turns by a quarter", two, 3,
             "32 x 64 pixels, not twice as wide as high: no panorama of all directions; it was "
             "turned by EXIF orientation 6",
             [](Files& f) { f.write("hall.jpg", tests::with_orientation(jpeg(64, 32), 6)); }),
      import("a tilted panorama", two, 0,
             "hall.jpg: GPano: pitch 3, roll -2 degrees: undone [levelled]",
             [](Files& f) {
               f.write("hall.jpg",
                       tests::with_xmp(jpeg(64, 32), tests::gpano({{"PosePitchDegrees", "3"},
                                                                   {"PoseRollDegrees", "-2"}})));
             }),
      import("a part of a sphere", two, 0, "64 x 16 of 64 x 32 pixels, 360 x 90 degrees; other",
             [](Files& f) {
               f.write("hall.jpg",
                       tests::with_xmp(jpeg(64, 16),
                                       tests::gpano({{"FullPanoWidthPixels", "64"},
                                                     {"FullPanoHeightPixels", "32"},
                                                     {"CroppedAreaImageWidthPixels", "64"},
                                                     {"CroppedAreaImageHeightPixels", "16"},
                                                     {"CroppedAreaLeftPixels", "0"},
                                                     {"CroppedAreaTopPixels", "8"}})));
             }),
      import("a pose that is no number", two, 0,
             "GPano:PosePitchDegrees: \"up\", not a number from -90 to 90; the field is ignored",
             [](Files& f) {
               f.write("hall.jpg",
                       tests::with_xmp(jpeg(64, 32), tests::gpano({{"PosePitchDegrees", "up"}})));
             }),
      import("zeros before the end marker", two, 0,
             "hall.jpg: harmless oddities: 1; the first: Corrupt JPEG data",
             [](Files& f) {
               std::string padded = jpeg(64, 32);
               padded.insert(padded.size() - 2, 20, '\0');
               f.write("hall.jpg", padded);
             }),
      import("two pictures of one name", "--scan home -o new hall.jpg ./hall.jpg", 2,
             "viewpoint \"hall\": two of the pictures have that name"),
      import("a name that cannot be an id", "--scan home -o new 'my hall.jpg'", 2,
             "viewpoint \"my hall\": letters, digits, _ and - are allowed"),
      import("a scan that cannot be a file name", "--scan ../home -o new hall.jpg", 2,
             "scan: \"../home\" is not an id: 1 to 100 of the characters"),
      import("a viewpoint that is there already", "--scan one --name v0 -o {} hall.jpg", 2,
             "viewpoint \"v0\" is in scan one already"),
      import("five faces",
             "--scan home -o new --name a --faces frblud f.jpg r.jpg b.jpg l.jpg u.jpg", 2,
             "--faces: 5 pictures; it takes the six of one panorama"),
      import("an order of faces with one twice",
             "--scan home -o new --name a --faces frbluu f.jpg r.jpg b.jpg l.jpg u.jpg d.jpg", 2,
             "--faces \"frbluu\": each of f r b l u d"),
      import("faces of two sizes", faces, 3, "8 x 8 pixels; a face has to be square",
             [](Files& f) { f.write("l.jpg", jpeg(8, 8)); }),
      import("an id with _, which is good here", "--scan home -o new --name IMG_1_01 hall.jpg", 0,
             "ids with \"_\": 1, the first \"IMG_1_01\": programs of others may cut names there; "
             "\"IMG-1-01\" is safe"),
      import("a viewpoint without a position", placed, 2,
             "places.csv: has no position of viewpoint \"attic\"", place("cellar,1,2,3")),
      import("a position of three numbers missing", placed, 3,
             "places.csv: line 3: 2 values, not 4 or 5: name x y z [heading]", place("attic 1")),
      import("a position in words", placed, 3, "\"up\" is not a number of metres or degrees",
             place("attic,1,2,up")),
      import("positions as a spreadsheet saves them", placed, 0,
             "attic: faces of 16 pixels, at (1.50, "
             "2.00, 4.50) m",
             [](Files& f) {
               f.write("places.csv",
                       "\xef\xbb\xbfName;X;Y;Z\r\nhall.jpg;0;0;1,5\r\nattic.jpg;1,5;2;4,5\r\n");
             }),
      import("decimal commas between commas", placed, 3,
             "7 values, not 4 or 5: name x y z [heading]; decimal commas need semicolons",
             place("attic,1,5,2,0,4,5")),
      import("positions in UTF-16", placed, 0, "attic: faces of 16 pixels, at (1.50, 2.00, 4.50) m",
             [](Files& f) { f.write("places.csv", utf16("hall 0 0 1.5\nattic 1.5 2 4.5\n")); }),
      import("columns in another order", placed, 3,
             "columns \"name y x z\"; the order is: name x y z [heading]",
             [](Files& f) { f.edit("places.csv", "name,x,y,z", "name,y,x,z"); }),
      import("a viewpoint with two positions", placed, 3, "\"hall\" has a position already",
             place("hall,1,2,3")),
      import("an edge to nowhere", two + " --edge hall garden", 2,
             "edge hall garden: names no two viewpoints of scan home"),
      import("faces of no pixels", two + " --size 0", 2, "--size"),
      import("faces larger than any", two + " --size 9000", 2,
             "\"9000\" is not a whole number from 1 to 8192"),
      import("an output that is a file", "--scan home -o hall.jpg hall.jpg", 3,
             "cannot make the folder: Not a directory"),
  };
}

}  // namespace enfilade::bad_input
