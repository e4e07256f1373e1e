// enfilade panorama: all directions of a viewpoint in one picture.
#include <fmt/format.h>
#include <memory>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/picture_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/image/codecs.h"

namespace enfilade::apps {
namespace panorama_verb {
namespace {

struct PanoramaArguments {
  SceneOptions scene;
  OutputOptions output;
  std::string scan, viewpoint, cube;
  std::uint32_t width = 2048;
  double heading = 0;
};

template <class T>
image::Image<T> unfold(const image::CubeMap<T>& faces, bool cross) {
  if (faces[0].pixels.empty()) return {};
  return cross ? image::join_cross(faces) : image::join_strip(faces);
}

Drawn unfold_cube(const scan::PanoramaSource& source, ViewpointIndex viewpoint, bool cross) {
  const scan::Panorama panorama = scan::read_panorama(source, viewpoint);
  return {unfold(panorama.colour, cross), unfold(panorama.depth, cross),
          unfold(panorama.classes, cross), unfold(panorama.instances, cross)};
}

void draw_panorama(const PanoramaArguments& a) {
  if (!a.cube.empty() && a.cube != "cross" && a.cube != "strip") {
    throw UsageError(fmt::format("--cube={}: cross or strip is allowed", a.cube));
  }
  if (a.width % 2 != 0 || a.width > image::kLongestEdge) {
    throw UsageError(fmt::format("--width {}: an even number of pixels up to {} is allowed",
                                 a.width, image::kLongestEdge));
  }
  const std::vector<PictureFile> files = picture_files(a.output);
  const dataset::Dataset scene = open_scene(a.scene, a.scan);
  const ViewpointIndex viewpoint = find_viewpoint(source_of(scene), a.viewpoint);
  require_layers(source_of(scene), viewpoint, files);
  Drawn drawn;
  if (!a.cube.empty()) {
    drawn = unfold_cube(source_of(scene), viewpoint, a.cube == "cross");
  } else {
    const Size size{a.width, a.width / 2};
    render::Outputs outputs = outputs_into(drawn, files, size);
    // A panorama has no optical axis to measure along.
    if (outputs.depth) outputs.depth->measure = render::DepthMeasure::kRay;
    const render::View view{ScanIndex(), viewpoint, degrees(a.heading), {}};
    render::render_equirectangular(scene.faces(), view, size.width, size.height, outputs);
  }
  write_pictures(drawn, files, a.output, a.scene);
}

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "panorama", "Draw a viewpoint's panorama, equirectangular or as an unfolded cube");
  const auto a = std::make_shared<PanoramaArguments>();
  add_viewpoint_arguments(verb, a->scan, a->viewpoint);
  add_whole_number(verb, "--width", a->width, "Width in pixels; the height is half of it", 2)
      ->type_name("N");
  add_angle_option(verb, "--heading", a->heading,
                   "Heading of the middle column, clockwise from north, degrees");
  verb.add_flag("--cube{cross}", a->cube,
                "Draw the six faces: cross, or --cube=strip in Matterport3D's order")
      ->excludes("--width", "--heading");
  add_output_options(verb, a->output, "panorama.png");
  add_place_options(verb, a->scene);
  set_examples(verb, {"enfilade panorama 17DRP5sb8fy 5 -o panorama.jpg",
                      "enfilade panorama 17DRP5sb8fy 5b9b --width 4096 --heading 90",
                      "enfilade panorama 17DRP5sb8fy 5b9b --outputs rgb,depth --cube -o cube.png",
                      "enfilade panorama 17DRP5sb8fy 5b9b --outputs depth --raw --cube=strip -o "
                      "5b9b_skybox_depth_small.png"});
  verb.callback([a] { draw_panorama(*a); });
}

}  // namespace
}  // namespace panorama_verb

void add_panorama(CLI::App& app, int& status) { panorama_verb::add_verb(app, status); }

}  // namespace enfilade::apps
