// peer_render: our pictures beside the old simulator's and OpenCV's remap, in turn in one process:
// the same walk over the same files; times and ratios.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "apps/common/program.h"
#include "bench/cpu_time.h"
#include "bench/peer/old_simulator.h"
#include "bench/peer/remap.h"
#include "bench/render_speed.h"
#include "enfilade/core/threads.h"

namespace enfilade::bench {
namespace {

using namespace apps;

struct Options {
  std::string data;
  std::size_t passes = 7;
  int threads = 0;
  BenchSettings settings;

  std::filesystem::path images() const { return std::filesystem::path(data) / "v1/scans"; }
  std::filesystem::path connectivity() const {
    return std::filesystem::path(data) / "connectivity";
  }
};

Buildings open(const Options& o) {
  scan::PanoramaPlaces places;
  places.images = {o.images()};
  places.connectivity = o.connectivity();
  return open_buildings(places, scan::load_scan_list(o.connectivity()));
}

// The least of several passes; seconds a frame.
struct Times {
  double wall = std::numeric_limits<double>::infinity();
  double cpu = std::numeric_limits<double>::infinity();

  // `draw` returns how many frames; CPU time is that of all threads.
  template <class F>
  void pass(const F& draw) {
    const Stopwatch watch;
    const double start = process_cpu_seconds();
    const auto frames = static_cast<double>(draw());
    cpu = std::min(cpu, (process_cpu_seconds() - start) / frames);
    wall = std::min(wall, watch.seconds() / frames);
  }
};

// Mean difference of two pictures, in levels; `swapped`: the second is BGR.
class Difference {
 public:
  void add(std::span<const std::uint8_t> rgb, std::span<const std::uint8_t> other, bool swapped) {
    for (std::size_t i = 0; i < rgb.size(); ++i) {
      const std::size_t at = swapped ? i - i % 3 + 2 - i % 3 : i;
      sum_ += static_cast<std::uint64_t>(std::abs(int{rgb[i]} - int{other[at]}));
    }
    count_ += rgb.size();
  }
  bool any() const { return count_ > 0; }
  double mean() const { return static_cast<double>(sum_) / static_cast<double>(count_); }
  // Another picture altogether is tens of levels away; other filters and edges less than two.
  void check(const char* peer) const {
    constexpr double kMost = 3;
    if (any() && mean() > kMost) {
      throw Error(
          fmt::format("{} draws other pictures than we do: {:.1f} levels apart on average, "
                      "allowed are {:.0f}",
                      peer, mean(), kMost));
    }
  }

 private:
  std::uint64_t sum_ = 0;
  std::size_t count_ = 0;
};

std::span<const std::uint8_t> bytes_of(const render::Outputs& outputs, std::size_t agent,
                                       const Camera& camera) {
  const std::size_t size = std::size_t{3} * camera.width * camera.height;
  const auto* first = reinterpret_cast<const std::uint8_t*>(outputs.colour->pixels.data());
  return {first + agent * size, size};
}

// Our walk, step by step, and the pictures of its first steps.
struct Recording {
  OldWalk walk;
  std::vector<std::vector<render::View>> views;     // by step and agent
  std::vector<std::vector<std::uint8_t>> pictures;  // RGB of all agents, by step; the first few
  std::vector<std::vector<std::uint32_t>> indices;  // of the 36 views, by step and agent
};

Recording record(const Options& o, const Buildings& buildings, const Combination& c,
                 Drawing& drawing, bool eight_bit) {
  constexpr std::size_t kKeptFrames = 60;
  Recording r;
  r.walk.camera = c.camera;
  r.walk.images = o.images();
  r.walk.connectivity = o.connectivity();
  r.walk.cache_panoramas = buildings.viewpoints();
  drawing.walk([&](Walk& walk, const render::Outputs& outputs) {
    if (!r.views.empty()) {
      r.walk.actions.emplace_back(walk.actions().begin(), walk.actions().end());
    }
    r.views.emplace_back(walk.views().begin(), walk.views().end());
    r.indices.emplace_back(walk.state().view_index.begin(), walk.state().view_index.end());
    if (eight_bit && r.pictures.size() * c.batch < kKeptFrames) {
      const auto first = bytes_of(outputs, 0, c.camera);
      r.pictures.emplace_back(first.data(), first.data() + c.batch * first.size());
    }
  });
  for (const render::View& view : r.views.front()) {
    const scan::PanoramaSource& source = buildings.panoramas->source(view.scan);
    r.walk.scans.push_back(source.scan());
    r.walk.viewpoints.push_back(source.poses()[view.viewpoint.at()].viewpoint);
  }
  return r;
}

// Both walk the same way and see the same; the walk is also each one's first, which decodes.
Difference compare(const Recording& r, OldSimulator& old, const Camera& camera) {
  Difference difference;
  const std::size_t size = std::size_t{3} * camera.width * camera.height;
  old.walk([&](std::size_t step, std::span<const OldSight> agents) {
    for (std::size_t i = 0; i < agents.size(); ++i) {
      const render::View& ours = r.views[step][i];
      constexpr double kSame = 1e-9;
      if (ours.viewpoint.at() != agents[i].viewpoint ||
          std::abs(ours.heading.value - agents[i].heading) > kSame ||
          std::abs(ours.elevation.value - agents[i].elevation) > kSame) {
        throw Error(
            fmt::format("the old simulator walks elsewhere at step {}, agent {}: viewpoint "
                        "{} at heading {}, ours {} at {}",
                        step, i, agents[i].viewpoint, agents[i].heading, ours.viewpoint.at(),
                        ours.heading.value));
      }
      if (step < r.pictures.size()) {
        difference.add(std::span(r.pictures[step]).subspan(i * size, size), agents[i].bgr, true);
      }
    }
  });
  return difference;
}

std::string text_of(const Camera& camera) {
  return fmt::format("{}x{}", camera.width, camera.height);
}

void compare_old(const Options& o, const Combination& c) {
  const Buildings buildings = open(o);
  Drawing ours(buildings, c, o.settings, c.batch);
  const bool eight_bit = c.outputs.starts_with("rgb");
  Recording recording = record(o, buildings, c, ours, eight_bit);
  recording.walk.depth = c.outputs.ends_with("+depth");
  // Of Mesa's software rasteriser, which takes all cores otherwise.
  if (c.threads > 0) setenv("LP_NUM_THREADS", std::to_string(c.threads).c_str(), 1);
  const auto old = make_old_simulator(recording.walk);
  const Difference difference = compare(recording, *old, c.camera);
  difference.check("the old simulator");
  const std::size_t frames = recording.views.size() * c.batch;
  Times our_times, old_times;
  for (std::size_t i = 0; i < o.passes; ++i) {
    our_times.pass([&] { return ours.walk(); });
    old_times.pass([&] {
      old->walk({});
      return frames;
    });
  }
  const auto both = [](const Times& t) {
    return fmt::format("{:.3f} / {:.3f}", 1e3 * t.wall, 1e3 * t.cpu);
  };
  fmt::print("{:<10}{:<11}{:>6}{:>17}{:>17}{:>10.1f}{:>9.1f}{:>13}\n", text_of(c.camera), c.outputs,
             c.batch, both(our_times), both(old_times), old_times.wall / our_times.wall,
             old_times.cpu / our_times.cpu,
             difference.any() ? fmt::format("{:.2f}", difference.mean()) : "other format");
}

// One view of a panorama that remap has.
struct RemapFrame {
  std::size_t panorama, view;
};

// Gives remap all panoramas of the walk, as we draw them to the six sides.
std::vector<RemapFrame> give_panoramas(const Buildings& buildings, const Recording& r,
                                       const BenchSettings& settings, Remap& remap) {
  const std::uint32_t n = buildings.face_size();
  const Combination faces{{n, n, degrees(90)}, "rgb", 1, 1, true};
  const auto cache = std::make_shared<render::FaceCache>(buildings.panoramas);
  render::RendererConfig config;
  config.backend = settings.backend;
  config.threads = 1;
  const auto renderer = render::make_renderer(cache, config);
  const OutputMemory memory(faces.outputs, faces.camera, kCubeFaces);
  std::map<std::pair<ScanIndex, ViewpointIndex>, std::size_t> numbers;
  std::vector<RemapFrame> frames;
  for (std::size_t step = 0; step < r.views.size(); ++step) {
    for (std::size_t i = 0; i < r.views[step].size(); ++i) {
      const render::View& view = r.views[step][i];
      const auto [at, added] = numbers.try_emplace({view.scan, view.viewpoint}, 0);
      if (added) {
        renderer->render(faces.camera, face_views(view.scan, view.viewpoint), memory.outputs());
        const auto first = bytes_of(memory.outputs(), 0, faces.camera);
        at->second = remap.add({first.data(), first.data() + kCubeFaces * first.size()});
      }
      frames.push_back({at->second, r.indices[step][i]});
    }
  }
  return frames;
}

Difference compare_remap(const Recording& r, std::span<const RemapFrame> frames, Remap& remap,
                         std::span<std::uint8_t> picture) {
  Difference difference;
  std::size_t frame = 0;
  for (const std::vector<std::uint8_t>& step : r.pictures) {
    for (std::size_t at = 0; at < step.size(); at += picture.size(), ++frame) {
      remap.draw(frames[frame].panorama, frames[frame].view, picture);
      difference.add(std::span(step).subspan(at, picture.size()), picture, false);
    }
  }
  return difference;
}

void compare_remap(const Options& o, Combination c) {
  const PinnedThread pinned;
  c.threads = 1;
  const Buildings buildings = open(o);
  Drawing ours(buildings, c, o.settings, c.batch);
  const Recording recording = record(o, buildings, c, ours, true);
  const auto remap = make_remap(c.camera, buildings.face_size());
  const std::vector<RemapFrame> frames = give_panoramas(buildings, recording, o.settings, *remap);
  const std::size_t size = std::size_t{3} * c.camera.width * c.camera.height;
  std::vector<std::uint8_t> memory(c.batch * size);
  const auto picture = [&](std::size_t i) {
    return std::span(memory).subspan(i % c.batch * size, size);
  };
  const Difference difference = compare_remap(recording, frames, *remap, picture(0));
  difference.check("OpenCV's remap");
  Times our_times, own_maps, one_map;
  for (std::size_t pass = 0; pass < o.passes; ++pass) {
    our_times.pass([&] { return ours.walk(); });
    own_maps.pass([&] {
      for (std::size_t i = 0; i < frames.size(); ++i) {
        remap->draw(frames[i].panorama, frames[i].view, picture(i));
      }
      return frames.size();
    });
    one_map.pass([&] {
      for (std::size_t i = 0; i < frames.size(); ++i) {
        remap->draw(frames[i].panorama, render::kDiscreteViews / 2, picture(i));
      }
      return frames.size();
    });
  }
  const double pixels = static_cast<double>(c.camera.width) * c.camera.height;
  const auto ns = [&](const Times& t) { return 1e9 * t.cpu / pixels; };
  fmt::print("{:<10}{:<11}{:>6}{:>13.2f}{:>14.2f}{:>14.2f}{:>16.2f}{:>15.2f}{:>13.2f}\n",
             text_of(c.camera), c.outputs, c.batch, ns(our_times), ns(own_maps), ns(one_map),
             our_times.cpu / own_maps.cpu, our_times.cpu / one_map.cpu, difference.mean());
}

Combination combination(std::uint32_t width, std::uint32_t height, const char* outputs,
                        std::size_t batch, int threads) {
  return {{width, height, degrees(60)}, outputs, batch, threads, false};
}

// In a process of its own: the old simulator cannot be set up twice in one. True in that process.
bool run_apart(const std::function<void()>& work) {
  (void)std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) throw Error("fork: cannot start a process for a row");
  if (child == 0) {
    work();
    return true;
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw Error(WIFSIGNALED(status)
                    ? fmt::format("a row's process died of signal {}", WTERMSIG(status))
                    : "a row failed; its message is above");
  }
  return false;
}

bool print_old(const Options& o) {
  fmt::print("{}, {} threads that draw on both sides; milliseconds a frame, by wall and by CPU:\n",
             old_simulator_description(), threads_or_all(o.threads));
  fmt::print("{:<10}{:<11}{:>6}{:>17}{:>17}{:>10}{:>9}{:>13}\n", "size", "outputs", "batch", "ours",
             "old", "x by wall", "x by CPU", "levels apart");
  for (const Combination& c : {combination(640, 480, "rgb", 10, o.threads),
                               combination(640, 480, "rgb+depth", 10, o.threads),
                               combination(224, 224, "rgb", 100, o.threads),
                               combination(224, 224, "f16", 100, o.threads)}) {
    if (run_apart([&] { compare_old(o, c); })) return true;
  }
  return false;
}

bool print_remap(const Options& o) {
  fmt::print("\n{}, remap with ready 16-bit maps; one pinned thread, CPU nanoseconds a pixel:\n",
             remap_description());
  fmt::print("{:<10}{:<11}{:>6}{:>13}{:>14}{:>14}{:>16}{:>15}{:>13}\n", "size", "outputs", "batch",
             "ours", "map a view", "one map", "of map a view", "of one map", "levels apart");
  for (const Combination& c :
       {combination(640, 480, "rgb", 10, 1), combination(224, 224, "rgb", 100, 1)}) {
    if (run_apart([&] { compare_remap(o, c); })) return true;
  }
  return false;
}

ExitCode run(const Options& o) {
  std::array<double, 1> load{};
  (void)getloadavg(load.data(), 1);
  fmt::print(
      "{}, {} cores, load {:.1f} before; {} frames a pass, least of {} passes in turn\n"
      "one walk over {}, all decoded\n\n",
      processor_name(), available_threads(), load[0], o.settings.frames, o.passes,
      o.images().string());
  if (!old_simulator_built()) {
    fmt::print("{}\n", old_simulator_description());
  } else if (print_old(o)) {
    return kSuccess;
  }
  if (!remap_built()) {
    fmt::print("{}\n", remap_description());
  } else {
    (void)print_remap(o);
  }
  return kSuccess;
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  using namespace enfilade;
  using namespace enfilade::bench;
  CLI::App app("Draws a walk with Enfilade, the old simulator and OpenCV's remap, and compares.",
               "peer_render");
  Options o;
  int status = apps::kSuccess;
  apps::add_value(app, "--data", o.data, "DIR",
                  "Folder with connectivity/ and v1/scans/SCAN/matterport_skybox_images/, strips "
                  "of faces in them")
      ->required()
      ->check(CLI::ExistingDirectory);
  apps::add_whole_number(app, "--passes", o.passes, "Of each, in turn");
  apps::add_whole_number(app, "--frames", o.settings.frames, "A pass");
  apps::add_threads_option(app, o.threads, "That draw, on both sides; 0: all cores");
  apps::add_value(app, "--cpu-target", o.settings.cpu_target, "NAME",
                  "Our instruction set, instead of the fastest (bench_render --help lists them)");
  apps::set_examples(app, {"enfilade homes -o homes --homes 2 --size 512 --samples 1 --paths 0 "
                           "--parts strips",
                           "peer_render --data homes"});
  app.callback([&] { status = run(o); });
  return apps::run_program(app, argc, argv, status);
}
