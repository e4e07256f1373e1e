#include "apps/enfilade/mesh_files.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

bool is_plain(unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; }

}  // namespace

void add_mesh_options(CLI::App& verb, MeshOptions& options) {
  add_value(verb, "mesh", options.file, "MESH", "glTF 2.0 (.glb, .gltf), .obj with .mtl, or .ply")
      ->required();
  add_value(verb, "--scan", options.scan, "ID", "Scan id (default: the mesh's file name)");
  add_setting(verb, "--scale", options.scale, "", "Metres per unit of the mesh", finite_number());
  add_setting(verb, "--up", options.up, "AXIS", "Up axis; format: y for glTF, z for OBJ and PLY",
              CLI::IsMember({"format", "y", "z"}));
}

std::string scan_of(const MeshOptions& options, const std::string& graph) {
  if (!options.scan.empty()) {
    if (scan::is_scan_id(options.scan)) return options.scan;
    throw UsageError(
        fmt::format("--scan {:?}: letters, digits, _, - and . are allowed, not first a - or a .",
                    options.scan));
  }
  constexpr std::string_view kSuffix = "_connectivity.json";
  const std::string graph_name = fs::path(graph).filename().string();
  if (graph_name.ends_with(kSuffix)) {
    return graph_name.substr(0, graph_name.size() - kSuffix.size());
  }
  std::string name = fs::path(options.file).stem().string();
  std::ranges::replace_if(name, std::not_fn(is_plain), '_');
  return name;
}

mesh::Mesh read_mesh_file(const MeshOptions& options) {
  mesh::ReadOptions read;
  read.scale = options.scale;
  read.up = options.up == "y"   ? mesh::UpAxis::kY
            : options.up == "z" ? mesh::UpAxis::kZ
                                : mesh::UpAxis::kFormat;
  mesh::ReadResult result = mesh::read_mesh(options.file, read);
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

}  // namespace enfilade::apps
