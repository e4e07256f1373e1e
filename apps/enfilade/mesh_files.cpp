#include "apps/enfilade/mesh_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/continuous/buildings.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/threads.h"
#include "enfilade/dataset/mesh_files.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/lit_home.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::apps {

namespace {

namespace fs = std::filesystem;

bool is_plain(unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; }

}  // namespace

void add_mesh_options(CLI::App& verb, MeshOptions& options) {
  add_value(verb, "mesh", options.file, "MESH",
            "glTF 2.0 (.glb, .gltf), .obj with .mtl, .ply, or a scan's folder")
      ->required();
  add_value(verb, "--scan", options.scan, "ID", "Scan id (default: the mesh's file name)");
  add_setting(verb, "--scale", options.scale, "", "Metres per unit of the mesh", finite_number());
  add_setting(verb, "--up", options.up, "AXIS",
              "Up axis; format: y for glTF, z for OBJ, PLY and HM3D",
              CLI::IsMember({"format", "y", "z"}));
}

std::string scan_of(const MeshOptions& options, const std::string& graph) {
  if (!options.scan.empty()) {
    if (scan::is_scan_id(options.scan)) return options.scan;
    throw UsageError(
        fmt::format("--scan {:?}: letters, digits, _, - and . are allowed, not first a - or a .",
                    options.scan));
  }
  if (const auto scan = scan::scan_of_file(graph)) return *scan;
  // HM3D's 00800-NAME/NAME.basis.glb: the folder's name.
  const fs::path file = fs::absolute(dataset::mesh_at(options.file).file);
  std::string folder = file.parent_path().filename().string();
  if (tasks::scan_of_scene(file.string()) == folder && scan::is_scan_id(folder)) return folder;
  std::string name = file.stem().string();
  std::ranges::replace_if(name, std::not_fn(is_plain), '_');
  return name;
}

mesh::UpAxis up_axis(const std::string& name) {
  return name == "y" ? mesh::UpAxis::kY : name == "z" ? mesh::UpAxis::kZ : mesh::UpAxis::kFormat;
}

mesh::Mesh read_mesh_file(const fs::path& file, const mesh::ReadOptions& options) {
  const dataset::MeshFile at = dataset::mesh_at(file);
  const mesh::UpAxis up = options.up == mesh::UpAxis::kFormat ? at.up : options.up;
  mesh::ReadResult result = mesh::read_mesh(at.file, {options.scale, up});
  if (!result.warnings.empty()) print_diagnostics(result.warnings);
  return std::move(result.mesh);
}

mesh::WalkableFloor find_floor(const mesh::Mesh& mesh, const MeshOptions& options,
                               const mesh::WalkableOptions& walk) {
  try {
    return mesh::WalkableFloor(mesh, walk);
  } catch (const InvalidInput& error) {
    std::vector<Diagnostic> faults = error.diagnostics();
    for (Diagnostic& fault : faults) fault.file = options.file;
    throw InvalidInput(std::move(faults));
  }
}

namespace {

// \param kept  its light, perhaps
std::shared_ptr<const continuous::Scene> scene_of_home(const homes::BuiltHome& built,
                                                       const std::filesystem::path& kept,
                                                       int threads) {
  if (file_exists(kept)) return continuous::Scene::load(built.tracer, kept);
  const mesh::LitMesh light(built.tracer, built.home.lights,
                            homes::bake_options(homes::HomeLight::kFine, threads));
  return continuous::Scene::lit(built.tracer, light, {.threads = threads});
}

}  // namespace

std::optional<dataset::MeshFile> find_mesh_file(const std::filesystem::path& data,
                                                const MeshSource& source, const std::string& scan) {
  auto found = source.folder.empty() ? dataset::find_mesh_file(data, scan)
                                     : dataset::find_mesh_in(source.folder, scan);
  if (found && source.up != "format") found->up = up_axis(source.up);
  return found;
}

LightsReport make_home_lights(const dataset::Dataset& data, int threads) {
  LightsReport report;
  if (!file_exists(data.folder() / "homes.json")) return report;
  const std::vector<homes::HomeEntry> homes = homes::read_home_list(data.folder());
  const Progress progress = progress_bar("light");
  for (const homes::HomeEntry& home : homes) {
    const std::filesystem::path light = homes::home_light_file(home.scan);
    const std::filesystem::path shown = homes::lit_home_file(home);
    const bool kept = file_exists(data.folder() / light);
    if (!kept || !file_exists(data.folder() / shown)) {
      const OutputFolder out(data.folder());
      const homes::BuiltHome built = homes::build_home(home.plan);
      const auto scene = scene_of_home(built, data.folder() / light, threads);
      if (!kept) scene->save(out.file(light.generic_string()));
      out.write(shown.generic_string(),
                homes::packed_lit_home(built, scene->surface_light(), threads));
    }
    ++(kept ? report.kept : report.made);
    if (progress) progress(report.made + report.kept, homes.size());
  }
  return report;
}

std::shared_ptr<const continuous::Scene> scene_of_scan(const dataset::Dataset& data,
                                                       const MeshSource& source,
                                                       const std::string& scan, int threads) {
  if (source.folder.empty() && file_exists(data.folder() / "homes.json")) {
    for (const homes::HomeEntry& home : homes::read_home_list(data.folder())) {
      if (home.scan == scan) {
        return scene_of_home(homes::build_home(home.plan),
                             data.folder() / homes::home_light_file(scan), threads);
      }
    }
  }
  const auto found = find_mesh_file(data.folder(), source, scan);
  if (!found) {
    throw UsageError(fmt::format("no mesh of scan {} to draw; give --meshes DIR", scan));
  }
  return continuous::Scene::open(found->file, {.up = found->up});
}

exports::BuildingLook look_of_scan(const dataset::Dataset& data, const MeshSource& source,
                                   const std::string& scan, continuous::Appearance appearance,
                                   int threads) {
  exports::BuildingLook look{scene_of_scan(data, source, scan, threads)};
  if (appearance == continuous::Appearance::kMesh) return look;
  const auto& panoramas = data.panoramas();
  const auto index = panoramas->find(scan);
  if (!index) {
    throw UsageError(fmt::format("--appearance panoramas: {} has no panoramas of scan {}",
                                 data.folder().string(), scan));
  }
  try {
    look.photographs =
        std::make_shared<const continuous::Photographs>(panoramas, *index, look.scene);
  } catch (const LookupError& error) {
    throw UsageError(fmt::format("--appearance panoramas: {}", error.what()));
  }
  return look;
}

void add_appearance_option(CLI::App& verb, std::string& appearance) {
  add_setting(verb, "--appearance", appearance, "NAME",
              "Source of colours: mesh, or panoramas (where they show the surface)",
              CLI::IsMember({"mesh", "panoramas"}));
}

}  // namespace enfilade::apps
