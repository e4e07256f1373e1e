#include "apps/enfilade/continuous/scenes.h"

#include <fmt/format.h>

#include "enfilade/core/file.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"

namespace enfilade::apps {
namespace {

std::shared_ptr<const continuous::Scene> scene_of_home(const homes::PlanOptions& plan,
                                                       const std::filesystem::path& kept,
                                                       int threads) {
  const homes::BuiltHome built = homes::build_home(plan);
  if (file_exists(kept)) return continuous::Scene::load(built.tracer, kept);
  const mesh::LitMesh light(built.tracer, built.home.lights,
                            homes::bake_options(homes::HomeLight::kFine, threads));
  return continuous::Scene::lit(built.tracer, light, {.threads = threads});
}

}  // namespace

std::filesystem::path home_light_file(const dataset::Dataset& data, const std::string& scan) {
  return data.folder() / "light" / (scan + ".light");
}

LightsReport make_home_lights(const dataset::Dataset& data, int threads) {
  LightsReport report;
  if (!file_exists(data.folder() / "homes.json")) return report;
  const std::vector<homes::HomeEntry> homes = homes::read_home_list(data.folder());
  const Progress progress = progress_bar("light");
  for (const homes::HomeEntry& home : homes) {
    const std::filesystem::path file = home_light_file(data, home.scan);
    if (file_exists(file)) {
      ++report.kept;
    } else {
      make_folder(file.parent_path());
      scene_of_home(home.plan, file, threads)->save(file);
      ++report.made;
    }
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
        return scene_of_home(home.plan, home_light_file(data, scan), threads);
      }
    }
  }
  const auto found = find_mesh_file(data.folder(), source, scan);
  if (!found) {
    throw UsageError(fmt::format("no mesh of scan {} to draw; give --meshes DIR", scan));
  }
  mesh::ReadOptions options;
  const std::string& up = source.up == "format" ? found->up : source.up;
  options.up = up == "y" ? mesh::UpAxis::kY : up == "z" ? mesh::UpAxis::kZ : mesh::UpAxis::kFormat;
  return continuous::Scene::open(found->file, options);
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
