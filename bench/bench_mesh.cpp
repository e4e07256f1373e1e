// Light and pictures of a made-up flat: rooms of 4 x 4 m in two rows, each with a window, a lamp,
// and furniture of boxes and balls, as many triangles as asked for. Arguments: triangles, threads.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/mesh/capture.h"
#include "enfilade/mesh/lighting.h"

namespace enfilade {
namespace {

constexpr std::uint32_t kRooms = 6;  // 100 m2
constexpr float kRoom = 4, kHigh = 2.6F, kWall = 0.12F;
constexpr std::uint32_t kFace = 512;

struct Flat {
  mesh::Mesh mesh;
  mesh::Lights lights;
};

void add_quad(mesh::Mesh& mesh, std::uint32_t material, Vec3f corner, Vec3f u, Vec3f v) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3f p : {corner, corner + u, corner + u + v, corner + v})
    mesh.positions.push_back(p);
  const mesh::TexturePoint a{0, 0}, b{length(u), 0}, c{length(u), length(v)}, d{0, length(v)};
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  mesh.texture_points.push_back({a, b, c});
  mesh.texture_points.push_back({a, c, d});
  for (int i = 0; i < 2; ++i) {
    mesh.triangle_material.push_back(material);
    mesh.triangle_object.push_back(static_cast<std::uint32_t>(mesh.objects.size() - 1));
  }
}

void add_box(mesh::Mesh& mesh, std::uint32_t material, Vec3f low, Vec3f high) {
  const Vec3f x{high.x - low.x, 0, 0}, y{0, high.y - low.y, 0}, z{0, 0, high.z - low.z};
  const Vec3f back_x{-x.x, 0, 0}, back_y{0, -y.y, 0}, back_z{0, 0, -z.z};
  add_quad(mesh, material, low, y, x);
  add_quad(mesh, material, low, x, z);
  add_quad(mesh, material, low, z, y);
  add_quad(mesh, material, high, back_x, back_y);
  add_quad(mesh, material, high, back_z, back_x);
  add_quad(mesh, material, high, back_y, back_z);
}

void add_ball(mesh::Mesh& mesh, std::uint32_t material, Vec3f middle, float radius, int sides) {
  const auto at = [&](int i, int j) {
    const float a =
        2 * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(sides);
    const float b = std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(sides);
    return middle + Vec3f{radius * std::sin(b) * std::cos(a), radius * std::sin(b) * std::sin(a),
                          -radius * std::cos(b)};
  };
  for (int i = 0; i < sides; ++i) {
    for (int j = 0; j < sides; ++j) {
      const Vec3f corner = at(i, j);
      add_quad(mesh, material, corner, at(i + 1, j) - corner, at(i, j + 1) - corner);
    }
  }
}

void add_room(Flat& flat, float x, float y, bool lower) {
  mesh::Mesh& mesh = flat.mesh;
  mesh.objects.push_back({"walls", 1, 0});
  const float x1 = x + kRoom, window = lower ? y : y + kRoom - kWall;
  add_box(mesh, 1, {x, y, -0.2F}, {x1, y + kRoom, 0});
  add_box(mesh, 0, {x, y, kHigh}, {x1, y + kRoom, kHigh + 0.2F});
  // A door of 0.9 m at each side, and a window of 1.6 x 1.3 m outwards.
  add_box(mesh, 0, {x, y, 0}, {x + kWall, y + 1.5F, kHigh});
  add_box(mesh, 0, {x, y + 2.4F, 0}, {x + kWall, y + kRoom, kHigh});
  add_box(mesh, 0, {x, y + 1.5F, 2.05F}, {x + kWall, y + 2.4F, kHigh});
  add_box(mesh, 0, {x, window, 0}, {x + 1.2F, window + kWall, kHigh});
  add_box(mesh, 0, {x + 2.8F, window, 0}, {x1, window + kWall, kHigh});
  add_box(mesh, 0, {x + 1.2F, window, 0}, {x + 2.8F, window + kWall, 0.9F});
  add_box(mesh, 0, {x + 1.2F, window, 2.2F}, {x + 2.8F, window + kWall, kHigh});
  flat.lights.portals.push_back({{x + 1.2F, window, 0.9F}, {1.6F, 0, 0}, {0, 0, 1.3F}});
  flat.lights.lamps.push_back({{x + 2, y + 2, 2.3F}, {2, 1.6F, 1.1F}, 0.1F});
}

// Boxes and balls on the floor until there are enough triangles.
void furnish(Flat& flat, std::size_t triangles) {
  Rng rng(1);
  const auto between = [&](double low, double high) {
    return static_cast<float>(low + (high - low) * rng.uniform());
  };
  while (flat.mesh.triangles.size() < triangles) {
    const auto room = static_cast<std::uint32_t>(rng.below(kRooms));
    const float x = kRoom * static_cast<float>(room % 3) + between(0.3, 3.2);
    const float y = kRoom * static_cast<float>(room / 3) + between(0.3, 3.2);
    const auto material = static_cast<std::uint32_t>(rng.below(4));
    flat.mesh.objects.push_back({"thing", 39, static_cast<std::int32_t>(room)});
    const float top = between(0.2, 0.9);
    add_box(flat.mesh, material, {x, y, 0.02F}, {x + 0.4F, y + 0.3F, top});
    for (int i = 0; i < 3; ++i) {
      const float radius = between(0.03, 0.12);
      add_ball(flat.mesh, material, {x + 0.15F * static_cast<float>(i), y + 0.15F, top + radius},
               radius, 12);
    }
  }
}

Flat make_flat(std::size_t triangles) {
  Flat flat;
  for (const Vec3f colour : {Vec3f{0.75F, 0.72F, 0.68F}, Vec3f{0.9F, 0.9F, 0.9F},
                             Vec3f{0.5F, 0.15F, 0.1F}, Vec3f{0.15F, 0.2F, 0.4F}}) {
    mesh::Material material;
    material.colour = colour;
    flat.mesh.materials.push_back(material);
  }
  image::Image8 boards(512, 512, 3);
  for (std::size_t i = 0; i < boards.pixels.size(); ++i) {
    boards.pixels[i] = static_cast<std::uint8_t>(90 + i / 3 % 97 + i / (512 * 3) / 64 * 8);
  }
  flat.mesh.materials[1].texture = std::move(boards);
  for (std::uint32_t room = 0; room < kRooms; ++room) {
    add_room(flat, kRoom * static_cast<float>(room % 3), kRoom * static_cast<float>(room / 3),
             room < 3);
  }
  add_box(flat.mesh, 0, {3 * kRoom, 0, 0}, {3 * kRoom + kWall, 2 * kRoom, kHigh});
  flat.lights.sun = {{0.3F, -0.7F, 0.55F}, {12, 11, 9}};
  furnish(flat, triangles);
  return flat;
}

std::shared_ptr<const mesh::LitMesh> lit_flat(std::int64_t triangles) {
  static std::map<std::int64_t, std::shared_ptr<const mesh::LitMesh>> made;
  auto& lit = made[triangles];
  if (lit == nullptr) {
    Flat flat = make_flat(static_cast<std::size_t>(triangles));
    lit = std::make_shared<const mesh::LitMesh>(
        std::make_shared<const mesh::RayTracer>(
            std::make_shared<const mesh::Mesh>(std::move(flat.mesh))),
        flat.lights);
  }
  return lit;
}

void tree(benchmark::State& state) {
  const auto flat =
      std::make_shared<const mesh::Mesh>(make_flat(static_cast<std::size_t>(state.range(0))).mesh);
  for (auto _ : state) benchmark::DoNotOptimize(mesh::RayTracer(flat));
}

void bake(benchmark::State& state) {
  Flat flat = make_flat(static_cast<std::size_t>(state.range(0)));
  const auto tracer = std::make_shared<const mesh::RayTracer>(
      std::make_shared<const mesh::Mesh>(std::move(flat.mesh)));
  mesh::BakeOptions options;
  options.threads = static_cast<int>(state.range(1));
  for (auto _ : state) {
    const mesh::LitMesh lit(tracer, flat.lights, options);
    benchmark::DoNotOptimize(lit.key());
  }
}

// Pixels a second, from the middle of each room in turn.
void capture(benchmark::State& state, const mesh::CaptureOptions& what) {
  const auto lit = lit_flat(state.range(0));
  mesh::CaptureOptions options = what;
  options.threads = static_cast<int>(state.range(1));
  const Mat3d upright{{1, 0, 0, 0, 0, 1, 0, -1, 0}};
  std::uint32_t room = 0;
  for (auto _ : state) {
    const Vec3d eye{kRoom * (room % 3 + 0.6), kRoom * (room / 3 + 0.45), 1.5};
    benchmark::DoNotOptimize(mesh::capture_cube(*lit, upright, eye, kFace, options));
    room = (room + 1) % kRooms;
  }
  state.SetItemsProcessed(state.iterations() * std::int64_t{6} * kFace * kFace);
}

void colour(benchmark::State& state) {
  mesh::CaptureOptions options;
  options.samples = static_cast<std::uint32_t>(state.range(2));
  options.depth = options.labels = false;
  capture(state, options);
}

void depth_and_labels(benchmark::State& state) {
  mesh::CaptureOptions options;
  options.colour = false;
  capture(state, options);
}

void register_all() {
  const std::vector<std::int64_t> sizes{5'000, 50'000, 500'000};
  for (const std::int64_t triangles : sizes) {
    const auto named = [&](const char* name, void (*run)(benchmark::State&)) {
      return benchmark::RegisterBenchmark(name, run)->UseRealTime();
    };
    named("tree", tree)->ArgName("triangles")->Arg(triangles)->Unit(benchmark::kMillisecond);
    for (const std::int64_t threads : {1, 2}) {
      named("bake", bake)
          ->ArgNames({"triangles", "threads"})
          ->Args({triangles, threads})
          ->Unit(benchmark::kSecond);
      named("depth_and_labels", depth_and_labels)
          ->ArgNames({"triangles", "threads"})
          ->Args({triangles, threads})
          ->Unit(benchmark::kMillisecond);
      for (const std::int64_t samples : {1, 4}) {
        named("colour", colour)
            ->ArgNames({"triangles", "threads", "samples"})
            ->Args({triangles, threads, samples})
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

}  // namespace
}  // namespace enfilade

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  enfilade::register_all();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
