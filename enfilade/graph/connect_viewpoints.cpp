#include <fmt/format.h>

#include <map>
#include <mutex>

#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/graph/build.h"
#include "enfilade/graph/detail/floor_walk.h"

namespace enfilade::graph {
namespace {

// Ids like Matterport3D's. Positions are rounded to millimetres, so that ids do not depend on the
// last bit.
std::string make_id(const std::string& scan, Vec3d p, std::size_t repeat) {
  const std::string text = fmt::format("{} {:.3f} {:.3f} {:.3f} {}", scan, p.x, p.y, p.z, repeat);
  Rng rng(stream_of(text.data(), text.size()));
  const std::uint64_t high = rng.next();
  return fmt::format("{:016x}{:016x}", high, rng.next());
}

scan::Connectivity make_entries(const std::vector<PlacedViewpoint>& viewpoints,
                                const std::string& scan) {
  scan::Connectivity out{scan, scan + "_connectivity.json", {}};
  std::map<std::string, std::size_t> repeats;
  for (const PlacedViewpoint& v : viewpoints) {
    scan::ConnectivityEntry entry;
    const std::size_t repeat = repeats[make_id(scan, v.eye, 0)]++;
    entry.id = make_id(scan, v.eye, repeat);
    // Columns: right = +x, down = -z, look = +y.
    entry.pose = {1, 0, 0, v.eye.x, 0, 0, 1, v.eye.y, 0, -1, 0, v.eye.z, 0, 0, 0, 1};
    entry.height = v.height;
    out.entries.push_back(std::move(entry));
  }
  return out;
}

// What is known of a pair of viewpoints, stored at the lower index.
struct Sight {
  bool visible = false, free = false;
};

}  // namespace

scan::Connectivity connect_viewpoints(const mesh::RayTracer& tracer,
                                      const mesh::WalkableFloor& floor,
                                      const std::vector<PlacedViewpoint>& viewpoints,
                                      const std::string& scan, const EdgeOptions& options,
                                      int threads, const Progress& progress) {
  const detail::Passage passage(tracer, floor, options);
  const std::size_t n = viewpoints.size();
  std::vector<std::vector<Sight>> rows(n);
  std::mutex mutex;
  std::size_t done = 0;
  parallel_for(n, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      rows[i].resize(n);
      for (std::size_t j = i + 1; j < n; ++j) {
        rows[i][j].visible = passage.in_sight(viewpoints[i], viewpoints[j]);
        rows[i][j].free = rows[i][j].visible && passage.is_free(viewpoints[i], viewpoints[j]);
      }
      const std::lock_guard lock(mutex);
      ++done;
      if (progress) progress(done, n);
    }
  });
  scan::Connectivity out = make_entries(viewpoints, scan);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const Sight sight = i < j ? rows[i][j] : rows[j][i];
      if (sight.visible) out.entries[i].visible.emplace_back(j);
      if (sight.free) out.entries[i].unobstructed.emplace_back(j);
    }
  }
  return out;
}

}  // namespace enfilade::graph
