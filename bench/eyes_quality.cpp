// How near pictures of the eyes come to the truth, in a model home (SYNTHETIC), by the distance to
// the nearest panorama: PSNR and SSIM of the mesh's own colours and of colours from panoramas.
// Truth is mesh/capture.h with all its light and 4 rays a pixel.
//
// The last two columns are of the same home with one colour for each texture: what a scan gives
// whose own textures are poor.
//
//   eyes_quality [SEED] [AREA] [VIEWS] [FACE] [FOLDER FOR PICTURES]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/capture/mesh_panoramas.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/tone.h"

namespace enfilade {
namespace {

using continuous::Eyes;
using continuous::MeshView;
using continuous::Photographs;
using continuous::Scene;

constexpr Camera kCamera{224, 224, degrees(90)};
constexpr std::uint32_t kPanoramaFace = 512;

struct Arguments {
  std::uint64_t seed = 5;
  double area = 100;
  std::size_t views = 60;
  std::uint32_t face = 256;
  std::filesystem::path pictures;
};

double luma(const image::Image8& picture, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* p = picture.at(x, y);
  return 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
}

double psnr(const image::Image8& a, const image::Image8& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double d = static_cast<double>(a.pixels[i]) - b.pixels[i];
    sum += d * d;
  }
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.pixels.size()) / (sum + 1e-9));
}

// Of luma, mean over windows of 8 x 8, every fourth pixel (Wang et al. 2004, without weights).
double ssim(const image::Image8& a, const image::Image8& b) {
  constexpr std::uint32_t kWindow = 8, kStep = 4;
  constexpr double kN = kWindow * kWindow, kC1 = 6.5025, kC2 = 58.5225;
  double total = 0;
  std::size_t count = 0;
  for (std::uint32_t y0 = 0; y0 + kWindow <= a.height; y0 += kStep) {
    for (std::uint32_t x0 = 0; x0 + kWindow <= a.width; x0 += kStep) {
      double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
      for (std::uint32_t y = y0; y < y0 + kWindow; ++y) {
        for (std::uint32_t x = x0; x < x0 + kWindow; ++x) {
          const double p = luma(a, x, y), q = luma(b, x, y);
          sa += p;
          sb += q;
          saa += p * p;
          sbb += q * q;
          sab += p * q;
        }
      }
      const double ma = sa / kN, mb = sb / kN;
      const double va = saa / kN - ma * ma, vb = sbb / kN - mb * mb, cov = sab / kN - ma * mb;
      total +=
          (2 * ma * mb + kC1) * (2 * cov + kC2) / ((ma * ma + mb * mb + kC1) * (va + vb + kC2));
      ++count;
    }
  }
  return total / static_cast<double>(count);
}

// Places over free floor, at the height of VLN-CE's camera.
std::vector<MeshView> places(const homes::BuiltHome& built, std::size_t count) {
  std::vector<MeshView> views;
  Rng rng(11);
  const auto within = [&](double low, double high) { return low + rng.uniform() * (high - low); };
  while (views.size() < count) {
    const auto& plan = built.home.plan;
    const auto& room = plan.rooms[rng.below(plan.rooms.size())];
    const Vec3d eye{within(room.floor.x0, room.floor.x1), within(room.floor.y0, room.floor.y1),
                    plan.storeys[room.storey].floor + 1.25};
    bool free = true;
    for (int k = 0; k < 16 && free; ++k) {
      const double a = k * kPi / 8;
      free = !built.tracer->blocked(
          {to_float(eye), to_float({std::cos(a), std::sin(a), -0.3}), 0, 0.25F});
    }
    if (free) views.push_back({0, eye, Radians(within(0, 2 * kPi)), Radians(0)});
  }
  return views;
}

image::Image8 truth(const mesh::LitMesh& light, const MeshView& view) {
  mesh::Pinhole pinhole;
  pinhole.width = kCamera.width;
  pinhole.height = kCamera.height;
  pinhole.fx = pinhole.fy = kCamera.height / 2.0;
  pinhole.cx = (kCamera.width - 1) / 2.0;
  pinhole.cy = (kCamera.height - 1) / 2.0;
  pinhole.world_from_camera = world_from_camera(view.heading, view.elevation);
  pinhole.position = view.eye;
  mesh::CaptureOptions options;
  options.depth = options.labels = false;
  return mesh::capture_pinhole(light, pinhole, options).colour;
}

image::Image8 drawn(Eyes& eyes, const MeshView& view) {
  image::Image8 picture(kCamera.width, kCamera.height, 3);
  render::Outputs outputs;
  outputs.colour = render::ColourOutput{
      render::ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(picture.pixels))};
  eyes.render(kCamera, {&view, 1}, outputs);
  return picture;
}

void write_strip(const std::filesystem::path& file, std::span<const image::Image8> pictures) {
  const std::uint32_t width = pictures[0].width, height = pictures[0].height;
  const auto n = static_cast<std::uint32_t>(pictures.size());
  image::Image8 strip(n * width, height, 3);
  for (std::uint32_t k = 0; k < n; ++k) {
    for (std::uint32_t y = 0; y < height; ++y) {
      std::copy_n(pictures[k].at(0, y), std::size_t{3} * width, strip.at(k * width, y));
    }
  }
  const std::vector<std::uint8_t> png = image::encode_png(strip);
  write_file_atomically(file, std::string(png.begin(), png.end()));
}

// The mesh with one colour for each texture, as of a scan whose pictures were lost.
std::shared_ptr<const mesh::RayTracer> without_textures(const mesh::Mesh& mesh) {
  mesh::Mesh bare = mesh;
  for (mesh::Material& material : bare.materials) {
    const image::Image8& texture = material.texture;
    if (texture.pixels.empty() || material.cutout > 0) continue;
    std::array<double, 3> sum{};
    const std::size_t texels = std::size_t{texture.width} * texture.height;
    for (std::size_t i = 0; i < texels; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum[c] += image::linear_from_srgb(texture.pixels[i * texture.channels + c] / 255.0);
      }
    }
    const auto mean = [&](std::size_t c) {
      return static_cast<float>(sum[c] / static_cast<double>(texels));
    };
    material.colour = {material.colour.x * mean(0), material.colour.y * mean(1),
                       material.colour.z * mean(2)};
    material.texture = {};
  }
  return std::make_shared<const mesh::RayTracer>(
      std::make_shared<const mesh::Mesh>(std::move(bare)));
}

struct Row {
  double from = 0, to = 0;
  std::size_t count = 0;
  std::array<double, 8> sums{};  // PSNR and SSIM of each
};

void run(const Arguments& arguments) {
  homes::PlanOptions options;
  options.seed = arguments.seed;
  options.area = arguments.area;
  const homes::BuiltHome built = homes::build_home(options);
  const auto light = std::make_shared<const mesh::LitMesh>(built.tracer, built.home.lights);
  const auto scene = Scene::lit(built.tracer, *light);
  const auto source = std::make_shared<const capture::MeshPanoramas>(
      light, homes::build_graph(built, "home", 0), kPanoramaFace, mesh::CaptureOptions{}, "");
  continuous::PhotographsOptions kept;
  kept.face_size = arguments.face;
  const auto photographs = std::make_shared<const Photographs>(scan::PanoramaSet::of({source}),
                                                               ScanIndex(0), scene, kept);
  const auto bare = without_textures(built.tracer->mesh());
  const mesh::LitMesh bare_light(bare, built.home.lights);
  const auto bare_scene = Scene::lit(bare, bare_light);
  const auto on_bare = std::make_shared<const Photographs>(scan::PanoramaSet::of({source}),
                                                           ScanIndex(0), bare_scene, kept);
  std::printf("SYNTHETIC home, seed %llu: %zu triangles, %zu panoramas of %u texels, kept at %u\n",
              static_cast<unsigned long long>(arguments.seed),
              built.tracer->mesh().triangles.size(), photographs->size(), kPanoramaFace,
              arguments.face);
  photographs->load_all();
  on_bare->load_all();
  Eyes of_bare({bare_scene}),
      of_bare_panoramas({bare_scene}, {continuous::Method::kRaster, 0, {on_bare}});
  Eyes of_mesh({scene}), of_panoramas({scene}, {continuous::Method::kRaster, 0, {photographs}});
  std::vector<Row> rows;
  const std::array<double, 6> edges{0, 0.4, 0.8, 1.2, 1.6, 100};
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) rows.push_back({edges[k], edges[k + 1]});
  std::size_t number = 0;
  for (const MeshView& view : places(built, arguments.views)) {
    double nearest = 1e9;
    for (const Vec3d at : photographs->positions())
      nearest = std::min(nearest, length(at - view.eye));
    const std::array<image::Image8, 5> pictures{truth(*light, view), drawn(of_mesh, view),
                                                drawn(of_panoramas, view), drawn(of_bare, view),
                                                drawn(of_bare_panoramas, view)};
    const auto row = std::ranges::find_if(rows, [&](const Row& r) { return nearest < r.to; });
    ++row->count;
    for (std::size_t k = 0; k < 4; ++k) {
      row->sums[2 * k] += psnr(pictures[0], pictures[k + 1]);
      row->sums[2 * k + 1] += ssim(pictures[0], pictures[k + 1]);
    }
    if (!arguments.pictures.empty()) {
      char name[64];
      std::snprintf(name, sizeof name, "%03zu_%.2fm_%.1f_%.1f.png", number, nearest,
                    psnr(pictures[0], pictures[1]), psnr(pictures[0], pictures[2]));
      write_strip(arguments.pictures / name, pictures);
    }
    ++number;
  }
  std::printf(
      "| metres to the nearest panorama | views | mesh | panoramas | mesh without textures | "
      "panoramas on it |\n|---|---|---|---|---|---|\n");
  for (const Row& row : rows) {
    if (row.count == 0) continue;
    std::printf("| %.1f - %.1f | %zu |", row.from, row.to, row.count);
    for (std::size_t k = 0; k < 4; ++k) {
      const auto n = static_cast<double>(row.count);
      std::printf(" %.1f, %.3f |", row.sums[2 * k] / n, row.sums[2 * k + 1] / n);
    }
    std::printf("\n");
  }
}

}  // namespace
}  // namespace enfilade

int main(int argc, char** argv) {
  enfilade::Arguments arguments;
  if (argc > 1) arguments.seed = std::stoull(argv[1]);
  if (argc > 2) arguments.area = std::stod(argv[2]);
  if (argc > 3) arguments.views = std::stoul(argv[3]);
  if (argc > 4) arguments.face = static_cast<std::uint32_t>(std::stoul(argv[4]));
  if (argc > 5) arguments.pictures = argv[5];
  enfilade::run(arguments);
  return 0;
}
