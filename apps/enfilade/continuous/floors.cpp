#include "apps/enfilade/continuous/floors.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "apps/enfilade/mesh_files.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/dataset/mesh_files.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/home_floor.h"
#include "enfilade/homes/home_set.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

// Around the viewpoints: what lies farther cannot be part of an episode.
mesh::Box around(const graph::NavGraph& graph) {
  constexpr float kAside = 6, kBelow = 3, kAbove = 3;  // metres
  mesh::Box box{graph.positions().front(), graph.positions().front()};
  for (const Vec3f p : graph.positions()) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return {box.low - Vec3f{kAside, kAside, kBelow}, box.high + Vec3f{kAside, kAside, kAbove}};
}

mesh::FloorPolygons floor_of_file(const MeshFile& found, const std::string& up,
                                  const graph::NavGraph& graph, const mesh::Body& body) {
  MeshOptions options;
  options.file = found.file.string();
  options.up = up == "format" ? found.up : up;
  const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(read_mesh_file(options)));
  mesh::PolygonOptions polygons;
  polygons.floor.body = body;
  polygons.floor.within = around(graph);
  return mesh::make_floor_polygons(tracer, polygons);
}

class Maker {
 public:
  Maker(const dataset::Dataset& data, const agents::ContinuousSetup& setup,
        const MeshSource& source)
      : data_(data),
        setup_(setup),
        source_(source),
        folder_(data.folder() / setup.navigation_folder()) {
    if (!source.folder.empty() && !fs::is_directory(source.folder)) {
      throw FileError(fmt::format("{}: not a folder (looked for meshes there)", source.folder));
    }
    if (file_exists(data.folder() / "homes.json")) {
      for (homes::HomeEntry& home : homes::read_home_list(data.folder())) {
        homes_.emplace(home.scan, std::move(home));
      }
    }
    make_folder(folder_);
    remove_unfinished(folder_);
  }

  FloorsReport run(int threads, const Progress& progress) {
    const graph::GraphSet& graphs = *data_.graphs();
    std::size_t done = 0;
    parallel_for(graphs.size(), 1, threads, [&](std::size_t first, std::size_t last) {
      for (std::size_t s = first; s < last; ++s) {
        make(graphs.scans()[s], s);
        const std::lock_guard lock(mutex_);
        ++done;
        if (progress) progress(done, graphs.size());
      }
    });
    std::ranges::sort(report_.without_mesh);
    std::ranges::sort(report_.faults, {}, &Diagnostic::file);
    return std::move(report_);
  }

 private:
  void make(const std::string& scan, std::size_t index) {
    const fs::path file = folder_ / continuous::navigation_mesh_name(scan);
    if (is_there(file)) return count(report_.kept);
    const auto home = homes_.find(scan);
    const auto found = home == homes_.end() ? find_mesh_file(data_.folder(), source_, scan)
                                            : std::optional<MeshFile>();
    if (home == homes_.end() && !found) {
      const std::lock_guard lock(mutex_);
      report_.without_mesh.push_back(scan);
      return;
    }
    try {
      const graph::NavGraph& graph =
          data_.graphs()->graph(ScanIndex(static_cast<std::uint32_t>(index)));
      continuous::save_navigation_mesh(
          home == homes_.end()
              ? floor_of_file(*found, source_.up, graph, setup_.body)
              : homes::make_home_floor(
                    homes::build_home(home->second.plan, homes::Surfaces::kPlain), setup_.body),
          file);
      count(report_.made);
    } catch (const InvalidInput& error) {  // the other buildings are made all the same
      const std::lock_guard lock(mutex_);
      Diagnostic fault = error.diagnostics().front();
      fault.file = home == homes_.end() ? found->file.string() : scan;
      report_.faults.push_back(std::move(fault));
    }
  }

  bool is_there(const fs::path& file) const {
    if (!file_exists(file)) return false;
    const mesh::Body have = continuous::load_navigation_mesh(file).body;
    const mesh::Body& want = setup_.body;
    return have.radius == want.radius && have.height == want.height && have.step == want.step &&
           have.slope == want.slope;
  }

  void count(std::size_t& number) {
    const std::lock_guard lock(mutex_);
    ++number;
  }

  const dataset::Dataset& data_;
  const agents::ContinuousSetup& setup_;
  const MeshSource& source_;
  fs::path folder_;
  std::map<std::string, homes::HomeEntry> homes_;
  std::mutex mutex_;
  FloorsReport report_;
};

}  // namespace

std::optional<MeshFile> find_mesh_file(const fs::path& data, const MeshSource& source,
                                       const std::string& scan) {
  const auto found = source.folder.empty() ? dataset::find_mesh_file(data, scan)
                                           : dataset::find_mesh_in(source.folder, scan);
  if (!found) return std::nullopt;
  return MeshFile{found->file, found->up == mesh::UpAxis::kZ ? "z" : "format"};
}

FloorsReport make_floors(const dataset::Dataset& data, const agents::ContinuousSetup& setup,
                         const MeshSource& source, int threads) {
  return Maker(data, setup, source).run(threads, progress_bar("floors"));
}

}  // namespace enfilade::apps
