// enfilade import: a scan from the user's own panoramas.
#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string_view>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/capture/import_panoramas.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::apps::import_verb {
namespace {

struct Arguments {
  std::string scan, output, positions, faces, name, edges;
  std::vector<std::string> pictures;
  capture::ImportOptions options;
  bool no_pose = false;
};

// --faces: six pictures in an order such as "frblud", by index(CubeFace).
std::vector<std::string> sort_faces(const Arguments& a) {
  constexpr std::string_view kLetters = "ublfrd";  // by index(CubeFace)
  if (!std::ranges::is_permutation(a.faces, kLetters)) {
    throw UsageError(fmt::format(
        "--faces {:?}: each of f r b l u d (front right back left up down) is wanted once",
        a.faces));
  }
  if (a.pictures.size() != kCubeFaces || a.name.empty()) {
    throw UsageError(
        fmt::format("--faces: {} pictures{}; it takes the six of one panorama and its --name",
                    a.pictures.size(), a.name.empty() ? " and no --name" : ""));
  }
  std::vector<std::string> files;
  for (const char letter : kLetters) files.push_back(a.pictures[a.faces.find(letter)]);
  return files;
}

std::vector<capture::PanoramaFiles> list_panoramas(const Arguments& a) {
  if (!a.faces.empty()) return {{a.name, sort_faces(a)}};
  if (!a.name.empty() && a.pictures.size() != 1) {
    throw UsageError(fmt::format("--name: for one panorama, not {}", a.pictures.size()));
  }
  std::vector<capture::PanoramaFiles> panoramas;
  for (const std::string& file : a.pictures) {
    const std::string id = a.name.empty() ? std::filesystem::path(file).stem().string() : a.name;
    if (!scan::is_scan_id(id)) {
      throw UsageError(
          fmt::format("viewpoint {:?}: letters, digits, _ and - are allowed; it is "
                      "the picture's name without its suffix: rename that, or give --name",
                      id));
    }
    panoramas.push_back({id, {file}});
  }
  return panoramas;
}

void import_scan(const Arguments& a) {
  capture::ImportOptions options = a.options;
  options.positions = a.positions;
  options.use_pose = !a.no_pose;
  using capture::ImportEdges;
  const std::string usual = !options.pairs.empty() ? "none" : a.positions.empty() ? "line" : "near";
  const std::string& edges = a.edges.empty() ? usual : a.edges;
  options.edges = edges == "near"   ? ImportEdges::kNear
                  : edges == "line" ? ImportEdges::kLine
                                    : ImportEdges::kNone;
  const capture::ImportReport report = capture::import_panoramas(
      a.output, a.scan, list_panoramas(a), options, progress_bar("importing"));
  for (const capture::ImportedPanorama& one : report.panoramas) {
    say("{}: faces of {} pixels, at ({:.2f}, {:.2f}, {:.2f}) m\n", one.viewpoint, one.face_size,
        one.position.x, one.position.y, one.position.z);
  }
  if (!report.findings.empty()) print_diagnostics(report.findings);
  say("{}: scan {}: {} imported; viewpoints now: {}; edges: {}\n", a.output, a.scan,
      report.panoramas.size(), report.viewpoints, report.edges);
  if (a.positions.empty() && report.added > 0) {
    say("Where they were taken is not known (--positions): they stand in a line, {} m apart.\n",
        capture::kImportSpacing);
  }
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("import", "Import your own panoramas as a scan");
  const auto arguments = std::make_shared<Arguments>();
  add_value(verb, "pictures", arguments->pictures, "PICTURE",
            "Equirectangular panoramas, JPEG, PNG or Radiance HDR; file names become ids")
      ->required();
  add_value(verb, "--scan", arguments->scan, "NAME", "Name of a new scan, or of one to extend")
      ->required();
  add_value(verb, "-o,--output", arguments->output, "DIR", "Folder that the scan is written to")
      ->required();
  add_value(verb, "--name", arguments->name, "ID", "Id of the viewpoint, for a single panorama");
  add_value(verb, "--faces", arguments->faces, "ORDER",
            "Order of six faces of one panorama, such as frblud (docs/capture.md)");
  add_value(verb, "--size", arguments->options.face_size, "N",
            "Edge of a face, pixels (default: the picture's resolution, at most 1024)")
      ->check(whole_number(1, capture::kLargestImportedFace));
  add_value(verb, "--exposure", arguments->options.exposure, "EV",
            "Exposure of HDR pictures in stops: a factor of 2^EV (default: each picture's median "
            "becomes mid-grey)")
      ->check(finite_number(-64));
  verb.add_flag("--force", arguments->options.force, "Replace viewpoints that exist");
  add_value(verb, "--heading", arguments->options.heading, "DEG",
            "Heading of the pictures' middles (front faces), degrees clockwise from north "
            "(default: 0)")
      ->check(finite_number(-360));
  verb.add_flag("--no-pose", arguments->no_pose,
                "Ignore pitch, roll and heading in the pictures' metadata");
  add_value(verb, "--positions", arguments->positions, "FILE",
            "File of lines \"name x y z [heading]\", metres and degrees (default: a line of "
            "viewpoints 2.25 m apart)");
  add_metres_option(verb, "--eye-height", arguments->options.eye_height,
                    "Height of the eye above the floor, metres");
  verb.add_option("--edges", arguments->edges,
                  "Edges: near (within --reach), line (each to the next) or none (default: near "
                  "with --positions, none with --edge, else line)")
      ->check(CLI::IsMember({"near", "line", "none"}));
  add_metres_option(verb, "--reach", arguments->options.reach,
                    "Longest edge of --edges near, metres");
  add_value(verb, "--edge", arguments->options.pairs, "A B",
            "Add an edge between these two viewpoints; may be repeated")
      ->allow_extra_args(false);
  set_examples(verb,
               {"enfilade import --scan myhouse -o my-data kitchen.jpg hall.hdr",
                "enfilade import --scan myhouse -o my-data *.jpg --positions tripod.csv",
                "enfilade import --scan myhouse -o my-data *.jpg --edge kitchen hall --edge hall "
                "porch",
                "enfilade import --scan myhouse -o my-data --name attic --faces frblud "
                "attic_0.png attic_1.png attic_2.png attic_3.png attic_4.png attic_5.png"});
  verb.callback([arguments] { import_scan(*arguments); });
}

}  // namespace enfilade::apps::import_verb
