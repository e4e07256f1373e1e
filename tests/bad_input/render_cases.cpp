#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/gzip.h"
#include "enfilade/image/codecs.h"
#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

constexpr const char* kStrip = "scans/one/matterport_skybox_images/v0_skybox_small.jpg";
constexpr const char* kDepth = "scans/one/matterport_skybox_images/v0_skybox_depth_small.png";

std::string text_of(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

std::string strip(std::uint32_t width) {
  image::Image8 picture(width, 16, 3);
  return text_of(image::encode_jpeg(picture, 90));
}

// One viewpoint's colour and depth, six faces of 16 texels.
void add_pictures(Files& files) {
  files.write(kStrip, strip(96));
  files.write(kDepth, text_of(image::encode_png(image::Image16(96, 16, 1))));
}

Case on_pictures(std::string input, std::string command, int exit_code, std::string says) {
  return {"Pictures", std::move(input), std::move(command),
          exit_code,  std::move(says),  add_pictures};
}

Case damaged(std::string input, std::string command, std::string says,
             std::function<void(Files&)> damage) {
  return {"Pictures",
          std::move(input),
          std::move(command),
          3,
          std::move(says),
          [damage = std::move(damage)](Files& files) {
            add_pictures(files);
            damage(files);
          }};
}

constexpr const char* kNoTable = "index\tname\nchair\t3\n";

// A panorama with classes, and a file of their names.
Case labelled(std::string input, std::string says, std::string file, std::string labels) {
  return damaged(std::move(input), "render one v0 --data {} --outputs class -o {}/a.png",
                 std::move(says),
                 [file = std::move(file), labels = std::move(labels)](Files& files) {
                   image::Image16 classes(96, 16, 1);
                   std::ranges::fill(classes.pixels, std::uint16_t{3});
                   files.write("scans/one/matterport_skybox_images/v0_skybox_class_small.png",
                               text_of(image::encode_png(classes)));
                   files.write(file, labels);
                 });
}

std::vector<Case> cases_of_names() {
  return {
      {"Pictures",
       "no folder with panoramas",
       "render one v0",
       2,
       "no panoramas: give --images DIR",
       {}},
      {"Pictures",
       "a folder without panoramas",
       "render one v0 --data {} --images {}/r2r",
       2,
       "scan \"one\": no panoramas found; tried:",
       {}},
      on_pictures("a scan that is none", "render three v0 --data {}", 2, "scan \"three\""),
      on_pictures("a scan id that is a path", "render ../one v0 --data {}", 2,
                  "scan: \"../one\" is not an id"),
      on_pictures("a viewpoint that is none", "render one v9 --data {}", 2,
                  "viewpoint \"v9\": scan one has none whose id begins so"),
      on_pictures("an index past the last", "render one 6 --data {}", 2, "an index below 6"),
      on_pictures("the beginning of several ids", "render one v --data {}", 2,
                  "viewpoint \"v\": 6 of scan one begin so: v0, v1, ..."),
      on_pictures("a viewpoint without pictures", "render one v1 --data {}", 2,
                  "{}/scans/one/matterport_skybox_images/v1_skybox_small.jpg"),
      on_pictures("a layer that the panorama lacks",
                  "render one v0 --data {} --outputs rgb,class -o {}/a.png", 2,
                  "this panorama has rgb, depth"),
  };
}

std::vector<Case> cases_of_options() {
  return {
      on_pictures("an output that is none", "render one v0 --data {} --outputs rgb,smell", 2,
                  "--outputs rgb,smell: \"smell\" is none of rgb, depth, class, instance"),
      on_pictures("an output twice", "render one v0 --data {} --outputs rgb,rgb", 2,
                  "\"rgb\" stands there twice"),
      on_pictures("two outputs to standard output",
                  "render one v0 --data {} --outputs rgb,depth -o -", 2,
                  "standard output takes one"),
      on_pictures("a file that is no picture's", "render one v0 --data {} -o {}/a.bmp", 2,
                  "a name that ends in .png, .jpg or .jpeg is expected"),
      on_pictures("raw depth as JPEG", "render one v0 --data {} --outputs depth --raw -o {}/a.jpg",
                  2, "JPEG cannot keep values"),
      on_pictures("a size of one number", "render one v0 --data {} --size 640", 2,
                  "--size \"640\": WIDTHxHEIGHT in pixels is expected"),
      on_pictures("a size of nothing", "render one v0 --data {} --size 0x480", 2,
                  "--size \"0x480\": WIDTHxHEIGHT"),
      on_pictures("a heading that is no number", "render one v0 --data {} --heading nan", 2,
                  "\"nan\" is not a finite number"),
      on_pictures("an elevation past the zenith", "render one v0 --data {} --elevation 91", 2,
                  "--elevation 91: -90 to 90 degrees are allowed"),
      on_pictures("an opening of half a turn", "render one v0 --data {} --vfov 180", 2,
                  "--vfov 180: more than 0 and less than 180"),
      on_pictures("a back end that is none", "render one v0 --data {} --backend vulkan", 2,
                  "--backend"),
      on_pictures("36 views and a heading", "render one v0 --data {} --discrete --heading 30", 2,
                  "--discrete has headings and elevations of its own"),
      on_pictures("an odd width", "panorama one v0 --data {} --width 33", 2,
                  "--width 33: an even number"),
      on_pictures("a cube and a width", "panorama one v0 --data {} --cube --width 32", 2, "--cube"),
      on_pictures("a cube of another shape", "panorama one v0 --data {} --cube=globe", 2,
                  "--cube=globe: cross or strip"),
      on_pictures("a sheet of nothing", "contact-sheet --data {}", 2, "name a SCAN"),
      on_pictures("thumbnails as large as a wall", "contact-sheet one --data {} --thumb 4000x3000",
                  2, "--thumb 4000x3000: at most 2048 pixels"),
      on_pictures("a path without its split", "contact-sheet --data {} --path 1", 2,
                  "need --split"),
      on_pictures("a path that is none", "contact-sheet --data {} --split made --path 7", 2,
                  "--path 7: not one of the 2 paths of made"),
      on_pictures("another scan than the path's",
                  "contact-sheet two --data {} --split made --path 1", 2,
                  "SCAN two: that path is in one"),
      on_pictures("an output folder that is not there", "render one v0 --data {} -o {}/no/a.png", 3,
                  "{}/no/a.png: cannot write"),
  };
}

std::vector<Case> cases_of_files() {
  return {
      damaged("a strip cut off in the middle", "render one v0 --data {}", "v0_skybox_small.jpg",
              [](Files& files) {
                const std::string whole = files.content(kStrip);
                files.write(kStrip, whole.substr(0, whole.size() / 2));
              }),
      damaged("a pipe in a store's place", "pack --check {}/one.enfilade",
              "{}/one.enfilade: cannot be read: not a plain file",
              [](Files& files) { files.write("one.enfilade", kPipe); }),
      damaged("text in a strip's place", "render one v0 --data {}", "v0_skybox_small.jpg",
              [](Files& files) { files.write(kStrip, "a picture"); }),
      damaged("a strip that is not six squares", "render one v0 --data {}", "v0_skybox_small.jpg",
              [](Files& files) { files.write(kStrip, strip(80)); }),
      damaged("depth of 8-bit colour", "render one v0 --data {} --outputs depth",
              "v0_skybox_depth_small.png",
              [](Files& files) {
                files.write(kDepth, text_of(image::encode_png(image::Image8(96, 16, 3))));
              }),
      damaged("text in a store's place", "render one v0 --data {}", "one.enfilade",
              [](Files& files) { files.write("store/one.enfilade", "a store"); }),
      damaged("loose files without poses", "render one v0 --images {}",
              "loose files need --connectivity DIR", [](Files&) {}),
      damaged("a scan whose graph is broken", "render one v0 --data {}", "one_connectivity.json",
              [](Files& files) { files.write(kGraph, "[{"); }),
      labelled("labels that are no table", "mpcat40.tsv: line 2", "labels/mpcat40.tsv", kNoTable),
      labelled("labels that are no table, packed", "mpcat40.tsv.gz: line 2",
               "labels/mpcat40.tsv.gz", gzip(kNoTable, 6)),
  };
}

}  // namespace

std::vector<Case> render_cases() {
  std::vector<Case> all;
  for (const auto& group : {cases_of_names(), cases_of_options(), cases_of_files()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace enfilade::bad_input
