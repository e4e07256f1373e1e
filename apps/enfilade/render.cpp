// enfilade render: what an agent sees at a viewpoint; enfilade panorama: all directions of it.
#include <fmt/format.h>
#include <memory>
#include <span>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/picture_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/draw/contact_sheet.h"
#include "enfilade/image/codecs.h"

namespace enfilade::apps {

namespace render_verb {
namespace {

struct RenderArguments {
  SceneOptions scene;
  OutputOptions output;
  std::string scan, viewpoint, size = "640x480";
  double heading = 0, elevation = 0, vfov = 60;
  bool discrete = false;
};

void validate(const RenderArguments& a) {
  if (a.elevation < -90 || a.elevation > 90) {
    throw UsageError(fmt::format("--elevation {}: -90 to 90 degrees are allowed", a.elevation));
  }
  validate_field_of_view(a.vfov);
  if (a.discrete && (a.heading != 0 || a.elevation != 0)) {
    throw UsageError(
        "--discrete has headings and elevations of its own: leave out --heading and --elevation");
  }
  if (a.discrete && a.output.raw) throw UsageError("--discrete and --raw exclude each other");
}

// The 36 views in the order of a sheet: upward views on top, heading 0 on the left.
std::vector<draw::SheetPicture> discrete_pictures(const image::Image8& views,
                                                  std::uint32_t height) {
  constexpr std::size_t kHeadings = 12;
  std::vector<draw::SheetPicture> pictures;
  for (std::size_t row = 3; row-- > 0;) {
    for (std::size_t step = 0; step < kHeadings; ++step) {
      const std::size_t view = row * kHeadings + step;
      pictures.push_back(
          {image::rows(views, view * height, height),
           fmt::format("{}: {}, {}", view, step * 30, static_cast<int>(row) * 30 - 30)});
    }
  }
  return pictures;
}

void write_discrete(const Drawn& drawn, const std::vector<PictureFile>& files,
                    const RenderArguments& a, std::uint32_t height, const std::string& title) {
  const draw::LayerColours palette = colours_of(drawn, a.scene);
  for (const PictureFile& file : files) {
    const image::Image8 sheet =
        draw::contact_sheet(discrete_pictures(palette.coloured(drawn, file.layer), height),
                            {.columns = 12, .title = title});
    write_picture(file.path, encode(palette.with_legend(sheet, file.layer), file.path));
  }
}

void render(const RenderArguments& a) {
  validate(a);
  const std::vector<PictureFile> files = picture_files(a.output);
  const Size size = parse_size("--size", a.size);
  const Camera camera{size.width, size.height, degrees(a.vfov)};
  const dataset::Dataset scene = open_scene(a.scene, a.scan);
  const ViewpointIndex viewpoint = find_viewpoint(source_of(scene), a.viewpoint);
  require_layers(source_of(scene), viewpoint, files);
  const auto renderer = make_renderer(scene, a.scene);
  Drawn drawn;
  if (a.discrete) {
    const auto views = render::discrete_views(ScanIndex(), viewpoint);
    renderer->render(camera, views, outputs_into(drawn, files, size, views.size()));
    write_discrete(drawn, files, a, size.height,
                   fmt::format("{} {}: view: heading, elevation in degrees", a.scan,
                               source_of(scene).poses()[viewpoint.at()].viewpoint));
    return;
  }
  const render::View view{ScanIndex(), viewpoint, degrees(a.heading), degrees(a.elevation)};
  renderer->render(camera, std::span(&view, 1), outputs_into(drawn, files, size));
  write_pictures(drawn, files, a.output, a.scene);
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "render", "Draw a view at a viewpoint: colour, depth, classes, instances");
  const auto a = std::make_shared<RenderArguments>();
  add_viewpoint_arguments(verb, a->scan, a->viewpoint);
  add_angle_option(verb, "--heading", a->heading, "Heading, clockwise from north (+y), degrees");
  add_angle_option(verb, "--elevation", a->elevation,
                   "Elevation above the horizon, degrees, -90 to 90");
  add_setting(verb, "--size", a->size, "WxH", "Size of the picture, pixels");
  add_field_of_view_option(verb, a->vfov);
  verb.add_flag("--discrete", a->discrete,
                "All 36 views of the discretized viewpoint on one sheet, each of --size");
  add_output_options(verb, a->output, "out.png");
  add_place_options(verb, a->scene);
  add_renderer_options(verb, a->scene);
  set_examples(verb, {"enfilade render 17DRP5sb8fy 5 --heading 90 -o view.png",
                      "enfilade render 17DRP5sb8fy 5b9b --outputs rgb,depth -o view.png",
                      "enfilade render 17DRP5sb8fy 5b9b --outputs depth --raw -o depth.png",
                      "enfilade render 17DRP5sb8fy 5b9b --discrete --size 160x120 -o sheet.png",
                      "enfilade render 17DRP5sb8fy 5 --images stores -o - | display"});
  verb.callback([a] { render(*a); });
}

}  // namespace render_verb

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

}  // namespace

void add(CLI::App& app, int& /*status*/) {
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

}  // namespace panorama_verb

}  // namespace enfilade::apps
