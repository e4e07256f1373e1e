// Ten million triangles, as a large building scanned finely has: read from a file, walked on, seen.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/continuous/eyes.h"
#include "enfilade/continuous/geodesics.h"
#include "enfilade/continuous/simulator.h"
#include "enfilade/mesh/floor_polygons.h"
#include "tests/support/made_meshes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

using namespace continuous;
namespace fs = std::filesystem;

constexpr float kLong = 30, kWide = 16;  // metres

/// A hall with a wall across it that has a door, all of quads.
mesh::Mesh hall() {
  return mesh::testing::Maker().room(0, 0, kLong, kWide).wall_with_hole(12, 0, kWide, 2, 3).mesh;
}

/// The same surfaces with the floor in 2 * n * n triangles instead of 2.
mesh::Mesh finely(mesh::Mesh mesh, std::uint32_t n) {
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2);  // the room's floor
  mesh.triangle_material.resize(mesh.triangles.size());
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      const auto part = [n](std::uint32_t k) {
        return static_cast<float>(k) / static_cast<float>(n);
      };
      mesh.positions.push_back({kLong * part(x), kWide * part(y), 0});
    }
  }
  mesh.triangles.reserve(mesh.triangles.size() + std::size_t{2} * n * n);
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = first + y * (n + 1) + x, b = a + n + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  }
  mesh.triangle_material.resize(mesh.triangles.size());
  return mesh;
}

/// Metres to what each pixel shows, from a place that sees the floor, the wall and the door.
std::vector<float> depth_of(const std::shared_ptr<const Scene>& scene) {
  Camera camera;
  camera.width = camera.height = 256;
  std::vector<float> depth(std::size_t{256} * 256);
  render::Outputs outputs;
  outputs.depth = render::DepthOutput{.pixels = std::as_writable_bytes(std::span(depth))};
  Eyes eyes({scene});
  eyes.render(camera, std::vector<MeshView>{{0, {9, 4, 1.25}, degrees(110), degrees(-20)}},
              outputs);
  return depth;
}

TEST(LargeMesh, TenMillionTrianglesAreTheSameHall) {
  constexpr double kNeeded = 6e9;  // bytes; it takes 4.3
  const double memory =
      static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (memory < kNeeded) GTEST_SKIP() << "takes 6 GB of free memory; there are " << memory / 1e9;

  const TemporaryFolder folder("large_mesh");
  const fs::path file = folder.path() / "hall.glb";
  mesh::write_glb(finely(hall(), 2240), file);
  mesh::ReadResult read = mesh::read_mesh(file);
  ASSERT_GT(read.mesh.triangles.size(), 10'000'000U);
  const auto large = std::make_shared<const mesh::RayTracer>(
      std::make_shared<const mesh::Mesh>(std::move(read.mesh)));
  const auto plain =
      std::make_shared<const mesh::RayTracer>(std::make_shared<const mesh::Mesh>(hall()));

  const auto floor = std::make_shared<const NavigationMesh>(mesh::make_floor_polygons(*large));
  const auto expected = std::make_shared<const NavigationMesh>(mesh::make_floor_polygons(*plain));
  ASSERT_EQ(floor->areas(), expected->areas());
  EXPECT_NEAR(floor->area_m2(0), expected->area_m2(0), 0.01 * expected->area_m2(0));
  const auto way = [](const std::shared_ptr<const NavigationMesh>& mesh) {
    const Geodesics ways(mesh);
    return ways.distance(mesh->nearest({1, 15, 0}).value(), mesh->nearest({29, 15, 0}).value());
  };
  // Both rims may be a cell (2 cm in a hall of this size) off, at either side of the door.
  EXPECT_NEAR(way(floor), way(expected), 0.05);
  EXPECT_GT(way(expected), 34);  // through the door, not across the wall

  const std::vector<float> seen = depth_of(Scene::photographed(large));
  const std::vector<float> truth = depth_of(Scene::photographed(plain));
  std::size_t far_off = 0;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (std::abs(seen[k] - truth[k]) > 0.001F) ++far_off;
  }
  // A ray along an edge may pass on either side of it.
  EXPECT_LE(far_off, 10U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
