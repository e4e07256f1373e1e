#include "enfilade/continuous/eyes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <utility>

#include "enfilade/continuous/pixels/painter.h"
#include "enfilade/continuous/pixels/photo.h"
#include "enfilade/continuous/pixels/rasteriser.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"

namespace enfilade::continuous {

using pixels::Eye;
using pixels::kBlock;
using pixels::kTile;
using pixels::Lattice;
using pixels::PixelPainter;
using pixels::Pixels;
using pixels::Sphere;
using pixels::TileRows;
using pixels::VisibilityBuffer;

namespace {

constexpr std::uint32_t kLargest = 8192;  // pixels along an edge
constexpr double kFarthest = 1e7;         // metres: floats resolve one there

// What one thread draws with.
struct Workspace {
  VisibilityBuffer frame;
  std::vector<std::uint32_t> lines;
};

// The panoramas that a view takes colours from.
struct Chosen {
  std::array<std::shared_ptr<const pixels::Photo>, 8> held{};
  std::array<const pixels::Photo*, 8> photos{};  // the same
  std::size_t count = 0;
  std::span<const pixels::Photo* const> all() const { return std::span(photos).first(count); }
};

void check_size(const char* name, std::uint32_t pixels) {
  if (pixels > 0 && pixels <= kLargest) return;
  throw ArgumentError(fmt::format("{}: {} pixels, not 1 .. {}", name, pixels, kLargest));
}

void check(const MeshView& view, std::size_t place, std::size_t buildings) {
  const auto fail = [place](const std::string& what) {
    throw ArgumentError(fmt::format("views[{}].{}", place, what));
  };
  if (view.building >= buildings) {
    fail(fmt::format("building: {}, but there are {}", view.building, buildings));
  }
  const auto fits = [](double x) { return std::abs(x) <= kFarthest; };  // not NaN either
  if (!fits(view.eye.x) || !fits(view.eye.y) || !fits(view.eye.z)) {
    fail(fmt::format("eye: ({}, {}, {}), not finite and within {:g} m of the origin", view.eye.x,
                     view.eye.y, view.eye.z, kFarthest));
  }
  if (!std::isfinite(view.heading.value)) {
    fail(fmt::format("heading: {}, not finite", view.heading.value));
  }
  if (!(std::abs(view.elevation.value) <= kPi / 2)) {
    fail(fmt::format("elevation: {}, not in [-pi/2, pi/2]", view.elevation.value));
  }
  if (!std::isfinite(view.roll.value)) fail(fmt::format("roll: {}, not finite", view.roll.value));
}

}  // namespace

struct Eyes::Impl {
  std::vector<std::shared_ptr<const Scene>> buildings;
  EyesConfig config;
  int threads = 1;
  pixels::Rasteriser rasteriser = nullptr;
  pixels::Colouring colouring;

  // Cameras and spheres seen so far, with their tables.
  std::vector<std::pair<Camera, std::unique_ptr<Lattice>>> lattices;
  std::vector<std::unique_ptr<Sphere>> spheres;
  std::vector<Eye> eyes;
  std::vector<Chosen> chosen;  // by view
  std::mutex mutex;
  std::vector<std::unique_ptr<Workspace>> workspaces;  // free ones

  const Lattice& lattice_of(const Camera& camera) {
    const auto found =
        std::ranges::find(lattices, camera, [](const auto& pair) { return pair.first; });
    if (found != lattices.end()) return *found->second;
    if (lattices.size() >= kMostKept) lattices.erase(lattices.begin());
    return *lattices.emplace_back(camera, std::make_unique<Lattice>(camera)).second;
  }
  const Sphere& sphere_of(std::uint32_t width, std::uint32_t height) {
    const auto found = std::ranges::find_if(spheres, [&](const auto& sphere) {
      return sphere->width == width && sphere->height == height;
    });
    if (found != spheres.end()) return **found;
    if (spheres.size() >= kMostKept) spheres.erase(spheres.begin());
    return *spheres.emplace_back(std::make_unique<Sphere>(width, height));
  }

  std::unique_ptr<Workspace> take() {
    const std::lock_guard lock(mutex);
    std::unique_ptr<Workspace> taken = std::move(workspaces.back());
    workspaces.pop_back();
    return taken;
  }
  void give_back(std::unique_ptr<Workspace> workspace) {
    const std::lock_guard lock(mutex);
    workspaces.push_back(std::move(workspace));
  }

  void check_all(std::span<const MeshView> views, const render::Outputs& outputs,
                 std::size_t pixels) const {
    render::validate(outputs, views.size() * pixels);
    if (outputs.stream) throw ArgumentError("outputs.stream: only the back end cuda has streams");
    for (std::size_t k = 0; k < views.size(); ++k) check(views[k], k, buildings.size());
  }

  void draw(const Pixels& pixels, std::span<const MeshView> views, const render::Outputs& outputs,
            const DepthRange& range = {}) {
    choose(views, outputs);
    const std::uint32_t block_rows = parts(parts(pixels.height(), kTile), kBlock);
    const std::uint32_t blocks_across = parts(parts(pixels.width(), kTile), kBlock);
    // Whole views, where there are enough for all threads: each band goes through the tree anew.
    const auto wanted = static_cast<std::size_t>(threads == 1 ? 1 : 2 * threads);
    const std::size_t bands =
        views.size() >= wanted
            ? 1
            : std::clamp<std::size_t>(wanted / std::max<std::size_t>(views.size(), 1), 1,
                                      block_rows);
    // Before the threads start, so that none allocates.
    for (auto& workspace : workspaces) {
      workspace->frame.resize(blocks_across, block_rows);
      const std::size_t lines = std::size_t{kTile} * PixelPainter::line_pitch(pixels.width());
      if (workspace->lines.size() < lines) workspace->lines.resize(lines);
    }
    parallel_for(views.size() * bands, 1, threads, [&](std::size_t begin, std::size_t end) {
      std::unique_ptr<Workspace> workspace = take();
      for (std::size_t job = begin; job < end; ++job) {
        const std::size_t view = job / bands, band = job % bands;
        const auto row = [&](std::size_t k) {
          return static_cast<std::uint32_t>(k * block_rows / bands) * kBlock;
        };
        draw(pixels, views[view], view, {row(band), row(band + 1)}, range, outputs, *workspace);
      }
      give_back(std::move(workspace));
    });
  }

  void draw(const Pixels& pixels, const MeshView& at, std::size_t view, TileRows rows,
            const DepthRange& range, const render::Outputs& outputs, Workspace& workspace) const {
    const pixels::SceneParts& scene = buildings[at.building]->parts();
    const Eye& eye = eyes[view];
    const PixelPainter painter(scene, pixels, eye, colouring, chosen[view].all());
    if (pixels.sphere != nullptr || config.method == Method::kRays) {
      painter.trace(rows, range, workspace.frame);
    } else {
      workspace.frame.clear(*pixels.lattice, rows, range.far);
      rasteriser({scene.tree, scene.surfaces, *pixels.lattice, eye, scene.habitat, range.near},
                 rows, workspace.frame);
    }
    painter.paint(workspace.frame, rows, outputs, view, workspace.lines);
  }

  // Reads panoramas that are needed for the first time.
  void choose(std::span<const MeshView> views, const render::Outputs& outputs) {
    chosen.resize(views.size());
    for (Chosen& one : chosen) one = {};
    if (!outputs.colour || config.photographs.empty()) return;
    parallel_for(views.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const Photographs* const photographs = config.photographs[views[k].building].get();
        if (photographs == nullptr) continue;
        std::array<std::size_t, 8> places{};
        chosen[k].count = photographs->choose(views[k].eye, places);
        for (std::size_t i = 0; i < chosen[k].count; ++i) {
          chosen[k].held[i] = photographs->photo(places[i]);
          chosen[k].photos[i] = chosen[k].held[i].get();
        }
      }
    });
  }

  static std::uint32_t parts(std::uint32_t of, std::uint32_t size) {
    return (of + size - 1) / size;
  }
  static constexpr std::size_t kMostKept = 8;
};

Eyes::Eyes(std::vector<std::shared_ptr<const Scene>> buildings, const EyesConfig& config)
    : impl_(std::make_unique<Impl>()) {
  if (buildings.empty()) throw ArgumentError("buildings: none");
  for (std::size_t k = 0; k < buildings.size(); ++k) {
    if (buildings[k] == nullptr) throw ArgumentError(fmt::format("buildings[{}]: null", k));
  }
  const auto& photographs = config.photographs;
  if (!photographs.empty() && photographs.size() != buildings.size()) {
    throw ArgumentError(fmt::format("config.photographs: of {} buildings, but there are {}",
                                    photographs.size(), buildings.size()));
  }
  for (std::size_t k = 0; k < photographs.size(); ++k) {
    if (photographs[k] != nullptr && &photographs[k]->scene() != buildings[k].get()) {
      throw ArgumentError(fmt::format("config.photographs[{}]: of another scene", k));
    }
  }
  if (config.threads < 0) {
    throw ArgumentError(fmt::format("config.threads: {}, below 0", config.threads));
  }
  impl_->buildings = std::move(buildings);
  impl_->config = config;
  impl_->threads = threads_or_all(config.threads);
  impl_->rasteriser =
      config.method == Method::kPlain ? pixels::rasterise_plainly : pixels::best_rasteriser();
  if (config.method != Method::kPlain) {
    impl_->colouring = {pixels::best_shader(), pixels::best_reprojector()};
  }
  // The calling thread takes part in the loop, and may be one more than those asked for.
  for (int k = 0; k <= impl_->threads; ++k) {
    impl_->workspaces.push_back(std::make_unique<Workspace>());
  }
}

Eyes::~Eyes() = default;

void Eyes::render(const Camera& camera, std::span<const MeshView> views,
                  const render::Outputs& outputs, const DepthRange& range) {
  validate(camera);
  check_size("camera.width", camera.width);
  check_size("camera.height", camera.height);
  impl_->check_all(views, outputs, std::size_t{camera.width} * camera.height);
  if (!(range.near >= 0 && range.near < range.far)) {
    throw ArgumentError(fmt::format("range: near {} and far {} metres, not 0 <= near < far",
                                    range.near, range.far));
  }
  const Lattice& lattice = impl_->lattice_of(camera);
  impl_->eyes.clear();
  for (const MeshView& view : views) {
    impl_->eyes.emplace_back(view.eye, view.heading, view.elevation, view.roll);
  }
  impl_->draw({&lattice, nullptr, 1 / lattice.focal}, views, outputs, range);
}

void Eyes::render_equirectangular(std::uint32_t width, std::uint32_t height,
                                  std::span<const MeshView> views, const render::Outputs& outputs) {
  check_size("width", width);
  check_size("height", height);
  impl_->check_all(views, outputs, std::size_t{width} * height);
  const Sphere& sphere = impl_->sphere_of(width, height);
  impl_->eyes.clear();
  for (const MeshView& view : views) impl_->eyes.emplace_back(view.eye, view.heading, Radians(0));
  impl_->draw({nullptr, &sphere, static_cast<float>(kPi / height)}, views, outputs);
}

std::string Eyes::description() const {
  const std::string with =
      impl_->config.method == Method::kRaster
          ? pixels::rasteriser_variants().front().name
          : std::string(impl_->config.method == Method::kRays ? "Embree" : "scalar");
  return fmt::format("{} ({}, {} threads)", enum_name(impl_->config.method), with, impl_->threads);
}

EyesCache::Known::Known(std::string name, std::shared_ptr<const Scene> scene, int threads)
    : scan(std::move(name)), eyes({std::move(scene)}, {.threads = threads}) {}

EyesCache::EyesCache(SceneSource scene_of, int threads, std::size_t most)
    : scene_of_(std::move(scene_of)), threads_(threads), most_(most) {}

Eyes& EyesCache::of(const std::string& scan) {
  const auto found = std::ranges::find(known_, scan, &Known::scan);
  if (found != known_.end()) {
    known_.splice(known_.begin(), known_, found);
    return found->eyes;
  }
  // Before the next one is loaded, as they are what takes the memory.
  while (most_ > 0 && known_.size() >= most_) known_.pop_back();
  known_.emplace_front(scan, scene_of_(scan), threads_);
  return known_.front().eyes;
}

}  // namespace enfilade::continuous
