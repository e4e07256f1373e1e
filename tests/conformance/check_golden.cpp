// check_golden: renders the poses of golden pictures and says how ours differ.
#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/data_root.h"
#include "tests/conformance/data_beside.h"
#include "tests/conformance/golden.h"

namespace enfilade::tests {
namespace {

using namespace apps;

namespace fs = std::filesystem;

struct Options {
  std::string folder, backend = "cpu", gl_device, connectivity, diff;
};

// Where the poses' rotations are: what was given, else the data set's, else beside the pictures.
fs::path find_connectivity(const Options& options) {
  if (!options.connectivity.empty()) return options.connectivity;
  if (const auto data = scan::DataRoot::from_environment()) return data->connectivity();
  fs::path own = fs::path(options.folder) / "connectivity";
  if (fs::is_directory(own)) return own;
  try {
    return open_data_beside("", fs::canonical(options.folder)).connectivity_folder();
  } catch (const UsageError&) {
    throw FileError(fmt::format(
        "{}: no folder with the poses of its viewpoints (SCAN_connectivity.json); tried "
        "ENFILADE_DATA (unset), {} and ../data beside the folder; give --connectivity DIR",
        options.folder, own.string()));
  }
}

std::unique_ptr<render::Renderer> legacy_renderer(
    const std::shared_ptr<const scan::PanoramaSet>& panoramas, const Options& options) {
  const auto backend = find_enum<render::Backend>(options.backend);
  if (!backend) throw UsageError(fmt::format("--backend {}: there is none", options.backend));
  render::RendererConfig config;
  config.backend = *backend;
  config.legacy = {true, true};
  config.gl_device = options.gl_device;
  return render::make_renderer(std::make_shared<render::FaceCache>(panoramas), config);
}

std::string as_text(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

void write_differences(const std::string& folder, const GoldenPose& pose, const GoldenPicture& ours,
                       const GoldenPicture& golden) {
  fs::create_directories(folder);
  write_file_atomically(fs::path(folder) / ("diff_" + pose.rgb),
                        as_text(image::encode_png(side_by_side(ours.colour, golden.colour))));
  write_file_atomically(fs::path(folder) / ("diff_" + pose.depth),
                        as_text(image::encode_png(side_by_side(ours.depth, golden.depth))));
}

void print_row(const std::string& name, const ColourDifference& colour,
               const DepthDifference& depth) {
  const auto percent = [](double share) { return fmt::format("{:.4f} %", 100 * share); };
  fmt::print("{:<14}{:>9}{:>8.4f}{:>5}{:>12}{:>12}{:>12}{:>13}{:>7}\n", name, colour.pixels,
             colour.mean(), colour.largest, percent(colour.share(colour.above_1)),
             percent(colour.share(colour.above_2)), percent(colour.share(colour.above_8)),
             percent(depth.share()), depth.largest);
}

ExitCode check(const Options& options) {
  if (!fs::is_directory(options.folder)) {
    throw FileError(fmt::format("{}: not a folder", options.folder));
  }
  const std::vector<GoldenPose> poses = load_golden(options.folder);
  std::vector<std::string> scans;
  for (const GoldenPose& pose : poses) {
    if (std::ranges::find(scans, pose.scan) == scans.end()) scans.push_back(pose.scan);
  }
  const auto panoramas =
      scan::PanoramaSet::open({{options.folder}, find_connectivity(options)}, scans);
  const auto renderer = legacy_renderer(panoramas, options);
  fmt::print("{}\nRGB in levels of 255, depth in quarter millimetres\n", renderer->description());
  fmt::print("{:<14}{:>9}{:>8}{:>5}{:>12}{:>12}{:>12}{:>13}{:>7}\n", "picture", "pixels", "mean",
             "max", "> 1", "> 2", "> 8", "depth same", "max");
  ColourDifference colour;
  DepthDifference depth;
  for (const GoldenPose& pose : poses) {
    const GoldenPicture golden = load_pictures(options.folder, pose);
    const GoldenPicture ours = render_golden(*renderer, *panoramas, pose);
    const ColourDifference c = compare(ours.colour, golden.colour);
    const DepthDifference d = compare(ours.depth, golden.depth);
    print_row(pose.rgb, c, d);
    colour += c;
    depth += d;
    if (!options.diff.empty()) write_differences(options.diff, pose, ours, golden);
  }
  print_row("all", colour, depth);
  const GoldenTolerances t;
  const bool good = within(t, colour, depth);
  fmt::print(
      "{}: RGB mean at most {}, at most {} on {} % of pixels and {} anywhere; depth the "
      "same on {} %\n",
      good ? "within tolerance" : "PAST THE TOLERANCE", t.mean, t.usual, 100 * t.usual_share,
      t.most, 100 * t.identical_share);
  return good ? kSuccess : kFaultsFound;
}

// Names of the golden pictures' folder that are not there are a missing file, not a mistake in the
// command line.
ExitCode check_or_say_what_is_missing(const Options& options) {
  try {
    return check(options);
  } catch (const LookupError& error) {
    throw FileError(error.what());
  }
}

}  // namespace
}  // namespace enfilade::tests

int main(int argc, char** argv) {
  using namespace enfilade::tests;
  CLI::App app("Renders the poses of golden pictures as the old simulator did and compares.",
               "check_golden");
  Options options;
  int status = kSuccess;
  app.add_option("folder", options.folder,
                 "Folder of golden.json, its pictures and scans/SCAN/matterport_skybox_images")
      ->required()
      ->type_name("DIR");
  app.add_option("--backend", options.backend, "What draws")
      ->check(CLI::IsMember({"cpu", "cpu-scalar", "gl", "cuda"}))
      ->capture_default_str();
  app.add_option("--gl-device", options.gl_device, "Index or UUID of an EGL device");
  app.add_option("--connectivity", options.connectivity,
                 "Folder of SCAN_connectivity.json (default: ENFILADE_DATA's, else "
                 "DIR/connectivity, else ../data/connectivity beside DIR)")
      ->type_name("DIR");
  app.add_option("--write-diff", options.diff,
                 "Folder for pictures of ours, theirs and the difference")
      ->type_name("DIR");
  app.footer(
      "Exit codes: 0 within tolerance, 1 past it, 2 command line, 3 a file that is missing or "
      "broken.");
  app.callback([&] { status = check_or_say_what_is_missing(options); });
  return run_program(app, argc, argv, status);
}
