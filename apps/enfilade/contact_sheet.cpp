// enfilade contact-sheet: every viewpoint of a scan, or a trajectory, as small pictures.
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/drawn_path.h"
#include "apps/enfilade/picture_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/draw/contact_sheet.h"

namespace enfilade::apps::contact_sheet_verb {
namespace {

struct SheetArguments {
  SceneOptions scene;
  std::string scan, output = "sheet.png", thumb = "200x150";
  PathOptions path;
  std::size_t columns = 0, headings = 1;
  double heading = 0, vfov = 60;
};

// What goes on the sheet.
struct Plan {
  std::string scan, title;
  std::vector<draw::Shot> shots;
  std::size_t columns = 0;
};

void validate(const SheetArguments& a) {
  validate(a.path, a.scan);
  constexpr std::uint32_t kLargest = 2048;  // three times as large is what is drawn
  const Size thumb = parse_size("--thumb", a.thumb);
  if (std::max(thumb.width, thumb.height) > kLargest) {
    throw UsageError(
        fmt::format("--thumb {}: at most {} pixels along an edge; enfilade render "
                    "draws large pictures",
                    a.thumb, kLargest));
  }
  validate_field_of_view(a.vfov);
}

Plan plan_of_scan(const SheetArguments& a, const scan::PanoramaSource& source) {
  Plan plan{a.scan, a.scan, draw::shots_of_scan(source, a.headings, degrees(a.heading)), a.columns};
  if (plan.columns == 0 && a.headings > 1) {
    // A viewpoint's headings beside each other, and as many viewpoints a row as give about 4 : 3.
    const Size thumb = parse_size("--thumb", a.thumb);
    const double across =
        std::sqrt(static_cast<double>(plan.shots.size()) * 4 / 3 * thumb.height / thumb.width);
    plan.columns = a.headings * static_cast<std::size_t>(std::max(
                                    1L, std::lround(across / static_cast<double>(a.headings))));
  }
  return plan;
}

// What the sheet's font has letters for; of other scripts it is said that they are left out. A few
// letters that it lacks are drawn as "?".
std::string title_lines(const std::vector<std::string>& lines) {
  std::string title;
  for (const std::string& line : lines) {
    std::string text = line;
    for (const char* quote : {"\u201c", "\u201d"}) {
      text = CLI::detail::find_and_replace(text, quote, "");
    }
    const auto others = std::ranges::count_if(text, [](char c) { return (c & 0x80) != 0; });
    const bool readable = static_cast<std::size_t>(others) * 4 <= text.size();
    title += (title.empty() ? ": " : " / ") + (readable ? text : "(text in another script)");
  }
  return title;
}

Plan plan_of_path(const SheetArguments& a) {
  const DrawnPath drawn = find_path(a.path, a.scan, open_data(a.scene.data));
  const graph::NavGraph& graph = drawn.graph();
  Plan plan{graph.scan(), drawn.title(), {}, a.columns};
  plan.title += title_lines(drawn.lines());
  plan.shots = drawn.walk ? draw::shots_of_trajectory(graph, *drawn.walk, drawn.path().heading)
                          : draw::shots_of_path(graph, drawn.path());
  draw::outline_goal(plan.shots, graph, drawn.path().goal, drawn.objects());
  if (auto goal = draw::shot_of_goal(graph, drawn.path(), drawn.objects())) {
    plan.shots.push_back(std::move(*goal));
  }
  // One row for a path (R2R's have 5 to 7 viewpoints), rows of ten for an agent's long walk.
  constexpr std::size_t kLongestRow = 10;
  if (plan.columns == 0) plan.columns = std::min(plan.shots.size(), kLongestRow);
  return plan;
}

void draw_sheet(const SheetArguments& a) {
  validate(a);
  (void)picture_files({.file = a.output});  // throws if the file name is not that of a picture
  const bool trajectory = !a.path.split.empty();
  Plan plan = trajectory ? plan_of_path(a) : Plan{};
  const dataset::Dataset scene = open_scene(a.scene, trajectory ? plan.scan : a.scan);
  if (!trajectory) plan = plan_of_scan(a, source_of(scene));
  if (plan.shots.empty()) {
    throw LookupError(fmt::format("scan {} includes no viewpoint", plan.scan));
  }
  const Size thumb = parse_size("--thumb", a.thumb);
  const auto renderer = make_renderer(scene, a.scene);
  const auto pictures =
      draw::draw_shots(*renderer, ScanIndex(), source_of(scene), plan.shots,
                       {thumb.width, thumb.height, degrees(a.vfov)}, progress_bar("drawing"));
  const image::Image8 sheet =
      draw::contact_sheet(pictures, {.columns = plan.columns, .title = plan.title});
  write_picture(a.output, encode(sheet, a.output));
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "contact-sheet", "Draw a scan's viewpoints, or a trajectory, as small pictures");
  const auto a = std::make_shared<SheetArguments>();
  add_scan_argument(verb, a->scan);
  add_setting(verb, "-o,--output", a->output, "FILE", "PNG or JPEG file; - for standard output");
  add_setting(verb, "--thumb", a->thumb, "WxH", "Size of a picture, pixels");
  add_value(verb, "--columns", a->columns, "N", "Pictures per row (default: chosen to fit)")
      ->check(whole_number(1));
  add_whole_number(verb, "--headings", a->headings,
                   "Pictures per viewpoint, at evenly spaced headings")
      ->type_name("N");
  add_angle_option(verb, "--heading", a->heading,
                   "Heading of the first picture, clockwise from north, degrees");
  add_field_of_view_option(verb, a->vfov);
  add_path_options(verb, a->path, "draw the agent's trajectory for --instr instead");
  add_place_options(verb, a->scene);
  add_renderer_options(verb, a->scene);
  set_examples(verb, {"enfilade contact-sheet 17DRP5sb8fy -o sheet.jpg",
                      "enfilade contact-sheet 17DRP5sb8fy --headings 4 --thumb 320x240",
                      "enfilade contact-sheet --split val_seen --path 1683 -o strip.png",
                      "enfilade contact-sheet --task reverie --split val_seen --instr 1683_57_0",
                      "enfilade contact-sheet --split val_seen --instr 1683_0 --results "
                      "results.json -o strip.png"});
  verb.callback([a] { draw_sheet(*a); });
}

}  // namespace enfilade::apps::contact_sheet_verb
