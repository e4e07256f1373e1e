// bench_render: frames a second, time to the first frame, memory of a walk.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "bench/machine_limits.h"
#include "bench/render_speed.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/render/devices.h"
#include "enfilade/scan/data_root.h"

namespace enfilade::bench {
namespace {

using namespace apps;

using Json = nlohmann::ordered_json;

struct Options {
  std::string mode = "walk";
  std::vector<std::string> images;
  std::string connectivity, scans, backend = "cpu";
  std::string sizes = "640x480", outputs = "rgb,rgb+depth", batches = "1,10,100", threads = "0";
  std::string caches = "hot", json;
  double vfov = 60;
  std::size_t cache_mb = render::FaceCacheConfig().bytes >> 20;
  bool first_frame_child = false;
  BenchSettings settings;
};

std::vector<std::string> list_of(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

std::uint32_t number(const char* option, const std::string& text, std::uint32_t least) {
  std::uint32_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (code != std::errc() || stop != end || value < least || value > 65536) {
    throw UsageError(
        fmt::format("{}: {:?} is not a whole number from {} to 65536", option, text, least));
  }
  return value;
}

Camera camera_of(const std::string& size, double vfov) {
  const std::size_t x = std::min(size.find('x'), size.size());
  const Camera camera{number("--size", size.substr(0, x), 1),
                      number("--size", size.substr(std::min(x + 1, size.size())), 1),
                      degrees(vfov)};
  validate(camera);
  return camera;
}

std::vector<Combination> combinations(const Options& o) {
  std::vector<Combination> all;
  for (const std::string& size : list_of(o.sizes)) {
    for (const std::string& outputs : list_of(o.outputs)) {
      for (const std::string& batch : list_of(o.batches)) {
        for (const std::string& threads : list_of(o.threads)) {
          for (const std::string& cache : list_of(o.caches)) {
            if (cache != "hot" && cache != "cold") {
              throw UsageError(fmt::format("--cache: {:?} is neither hot nor cold", cache));
            }
            all.push_back({camera_of(size, o.vfov), outputs, number("--batch", batch, 1),
                           static_cast<int>(number("--threads", threads, 0)), cache == "cold"});
          }
        }
      }
    }
  }
  return all;
}

scan::PanoramaPlaces places(const Options& o) {
  scan::PanoramaPlaces places;
  places.images.assign(o.images.begin(), o.images.end());
  places.connectivity = o.connectivity;
  if (o.connectivity.empty()) {
    if (const auto data = scan::DataRoot::from_environment()) {
      places.connectivity = data->connectivity();
    }
  }
  return places;
}

Buildings open(const Options& o) {
  if (o.images.empty()) return synthetic_buildings();
  return open_buildings(places(o), list_of(o.scans));
}

Json conditions(const Options& o, const Buildings& buildings) {
  return {{"machine", processor_name()},        {"cores", available_threads()},
          {"simd", render::cpu_target()},       {"backend", o.backend},
          {"panoramas", buildings.origin},      {"viewpoints", buildings.viewpoints()},
          {"face_size", buildings.face_size()}, {"cache_bytes", o.settings.cache_bytes},
          {"prefetch", o.settings.prefetch},    {"vfov_degrees", o.vfov}};
}

Json json_of(const MemoryRates& rates) {
  return {{"bytes", rates.bytes},
          {"read", rates.read},
          {"read_pieces", rates.read_pieces},
          {"write", rates.write},
          {"write_past_caches", rates.write_past_caches}};
}

Json json_of(const MachineLimits& limits) {
  return {{"clock_hz", limits.clock_hz},
          {"cache_size", limits.cache_size},
          {"cache", json_of(limits.cache)},
          {"memory", json_of(limits.memory)}};
}

void print_rates(const char* name, const MemoryRates& rates) {
  const auto giga = [](double rate) { return rate / 1e9; };
  fmt::print("{:<14}{:>7} MiB{:>11.1f}{:>14.1f}{:>9.1f}{:>20.1f}\n", name, rates.bytes >> 20,
             giga(rates.read), giga(rates.read_pieces), giga(rates.write),
             giga(rates.write_past_caches));
}

void print_limits(const MachineLimits& limits) {
  fmt::print("one thread    {:.2f} GHz (chains of additions, in this run); GB/s, in this run:\n",
             limits.clock_hz / 1e9);
  fmt::print("{:<25}{:>11}{:>14}{:>9}{:>20}\n", "", "read", "1 KiB pieces", "write",
             "write past caches");
  print_rates("last level", limits.cache);
  print_rates("memory", limits.memory);
  fmt::print("\n");
}

// Beside the clock and the memory of the machine; none for back ends that aren't one thread.
struct Shares {
  double nanoseconds = 0, cycles = 0;  // a pixel
  bool texels_in_cache = false;        // all decoded faces fit into half of the last level
  double bound = 0;                    // time that memory alone takes, of the time that it took
};

std::optional<Shares> shares_of(const Measurement& m, std::uint32_t face_size,
                                const MachineLimits& limits) {
  if (m.cpu_seconds <= 0) return std::nullopt;
  const Camera& camera = m.combination.camera;
  const double pixels = static_cast<double>(camera.width) * camera.height;
  const OutputMemory one(m.combination.outputs, camera, 1);
  const PictureTraffic traffic = picture_traffic(camera, face_size, one.outputs(), 1);
  Shares shares;
  shares.nanoseconds = 1e9 * m.cpu_seconds / pixels;
  shares.cycles = m.cpu_seconds * limits.clock_hz / pixels;
  shares.texels_in_cache = m.cache_bytes <= limits.cache_size / 2;
  const MemoryRates& texels_in = shares.texels_in_cache ? limits.cache : limits.memory;
  shares.bound = memory_bound(traffic, texels_in, limits) / m.cpu_seconds;
  return shares;
}

void print_conditions(const Json& conditions) {
  for (const auto& [name, value] : conditions.items()) {
    fmt::print("{:<14}{}\n", name, value.is_string() ? value.get<std::string>() : value.dump());
  }
  fmt::print("\n");
}

void finish(const Options& o, const Buildings& buildings, const Json& rows,
            const Json& limits = nullptr) {
  if (o.json.empty()) return;
  Json report{{"mode", o.mode}, {"conditions", conditions(o, buildings)}, {"rows", rows}};
  if (!limits.is_null()) report["one_thread"] = limits;
  write_output(o.json, report.dump(1) + "\n");
}

Json row_of(const Measurement& m, const std::optional<Shares>& shares) {
  const Combination& c = m.combination;
  Json row{{"renderer", m.renderer},
           {"width", c.camera.width},
           {"height", c.camera.height},
           {"outputs", c.outputs},
           {"batch", c.batch},
           {"threads", c.threads},
           {"cache", c.cold ? "cold" : "hot"},
           {"median", m.median()},
           {"per_second", m.per_second},
           {"decoding_share", m.decoding_share},
           {"faces_per_frame", m.faces_per_frame},
           {"cache_bytes", m.cache_bytes}};
  if (shares) {
    row["cpu_ns_per_pixel"] = shares->nanoseconds;
    row["cycles_per_pixel"] = shares->cycles;
    row["memory_bound_share"] = shares->bound;
    row["texels_in"] = shares->texels_in_cache ? "last level" : "memory";
  }
  return row;
}

void print_header() {
  fmt::print("{:>71}{:>11}{:>35}\n", "", "", "one pinned thread, CPU time:");
  fmt::print("{:<10}{:<14}{:>6}{:>8}{:>6}{:>10}{:>17}{:>10}{:>12}{:>9}{:>10}{:>9}  {}\n", "size",
             "outputs", "batch", "threads", "cache", "frames/s", "min .. max", "decoding",
             "faces/frame", "ns/pixel", "cycles/px", "of bound", "texels in");
}

void print_row(const Measurement& m, const std::optional<Shares>& shares) {
  const Combination& c = m.combination;
  fmt::print("{:<10}{:<14}{:>6}{:>8}{:>6}{:>10.0f}{:>17}{:>10}{:>12.2f}",
             fmt::format("{}x{}", c.camera.width, c.camera.height), c.outputs, c.batch,
             threads_or_all(c.threads), c.cold ? "cold" : "hot", m.median(),
             fmt::format("{:.0f} .. {:.0f}", m.per_second.front(), m.per_second.back()),
             fmt::format("{:.1f} %", 100 * m.decoding_share), m.faces_per_frame);
  if (shares) {
    fmt::print("{:>9.2f}{:>10.1f}{:>9}  {}", shares->nanoseconds, shares->cycles,
               fmt::format("{:.0f} %", 100 * shares->bound),
               shares->texels_in_cache ? "last level" : "memory");
  }
  fmt::print("\n");
  (void)std::fflush(stdout);
}

void run_table(const Options& o) {
  const bool sweep = o.mode == "sweep";
  Options own = o;
  if (sweep) {  // has a batch of its own, and always decodes
    own.batches = fmt::format("{}", render::kDiscreteViews);
    own.caches = "cold";
  }
  const std::vector<Combination> all = combinations(own);
  for (const Combination& c : all) (void)OutputMemory(c.outputs, {1, 1, degrees(60)}, 1);
  const Buildings buildings = open(o);
  print_conditions(conditions(o, buildings));
  const MachineLimits limits = measure_machine_limits();
  print_limits(limits);
  print_header();
  Json rows = Json::array();
  for (const Combination& c : all) {
    const Measurement m =
        sweep ? measure_sweep(buildings, c, o.settings) : measure(buildings, c, o.settings);
    if (rows.empty()) fmt::print("{}\n", m.renderer);
    const std::optional<Shares> shares = shares_of(m, buildings.face_size(), limits);
    print_row(m, shares);
    rows.push_back(row_of(m, shares));
  }
  finish(o, buildings, rows, json_of(limits));
}

void run_walk_memory(const Options& o) {
  Options own = o;
  if (o.batches == Options().batches) own.batches = "1";
  const Combination c = combinations(own).front();
  const Buildings buildings = open(o);
  print_conditions(conditions(o, buildings));
  const WalkMemory m = measure_walk_memory(buildings, c, o.settings);
  const auto megabytes = [](std::size_t bytes) { return static_cast<double>(bytes) / 1e6; };
  fmt::print("{} frames of {}x{} {} at batch {}, {} viewpoints seen\n", m.frames, c.camera.width,
             c.camera.height, c.outputs, c.batch, m.viewpoints_seen);
  fmt::print("{:<46}{:>8.1f} MB (before the walk {:.1f})\n",
             "own memory between frames, at most (RssAnon)", megabytes(m.most.anonymous),
             megabytes(m.before.anonymous));
  fmt::print("{:<46}{:>8.1f} MB\n", "page cache that it shares, at most (RssFile)",
             megabytes(m.most.file_backed));
  fmt::print("{:<46}{:>8.1f} MB\n", "both together, at most (VmHWM)", megabytes(m.most.peak));
  finish(o, buildings,
         Json::array({{{"frames", m.frames},
                       {"viewpoints_seen", m.viewpoints_seen},
                       {"anonymous_bytes", m.most.anonymous},
                       {"file_backed_bytes", m.most.file_backed},
                       {"peak_bytes", m.most.peak}}}));
}

// What this program was started with, plus the option that makes a child of it.
std::vector<std::string> child_arguments(const Options& o) {
  std::vector<std::string> arguments{"bench_render",
                                     "first-frame",
                                     "--first-frame-child",
                                     "--scans",
                                     list_of(o.scans).front(),
                                     "--backend",
                                     o.backend,
                                     "--size",
                                     list_of(o.sizes).front(),
                                     "--outputs",
                                     list_of(o.outputs).front(),
                                     "--threads",
                                     list_of(o.threads).front()};
  for (const std::string& folder : o.images)
    arguments.insert(arguments.end(), {"--images", folder});
  if (!o.connectivity.empty()) {
    arguments.insert(arguments.end(), {"--connectivity", o.connectivity});
  }
  return arguments;
}

// Milliseconds from before a process is made to the byte that it writes when its frame is done.
double time_child(const Options& o) {
  std::vector<std::string> arguments = child_arguments(o);
  std::vector<char*> argv;
  for (std::string& one : arguments) argv.push_back(one.data());
  argv.push_back(nullptr);
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw FileError("pipe: cannot make one");
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execv("/proc/self/exe", argv.data());
    _exit(kInternal);
  }
  close(ends[1]);
  char byte = 0;
  const bool drew = child > 0 && read(ends[0], &byte, 1) == 1;
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  close(ends[0]);
  int status = 0;
  if (child > 0) waitpid(child, &status, 0);
  if (!drew || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw FileError("first-frame: the process that draws it failed; its message is above");
  }
  return took.count();
}

void run_first_frame(const Options& o) {
  if (o.images.empty()) throw UsageError("first-frame needs --images and --scans: it opens files");
  if (o.first_frame_child) {
    const auto panoramas = scan::PanoramaSet::open(places(o), list_of(o.scans));
    draw_first_frame(panoramas, combinations(o).front(), o.settings);
    write_output("-", ".");
    return;
  }
  constexpr std::size_t kProcesses = 20;
  std::vector<double> milliseconds;
  for (std::size_t i = 0; i < kProcesses; ++i) milliseconds.push_back(time_child(o));
  std::ranges::sort(milliseconds);
  const Buildings buildings = open(o);
  print_conditions(conditions(o, buildings));
  fmt::print("process start to first frame, {} {}: {:.1f} ms (median of {}; {:.1f} .. {:.1f})\n",
             list_of(o.sizes).front(), list_of(o.outputs).front(), milliseconds[kProcesses / 2],
             kProcesses, milliseconds.front(), milliseconds.back());
  finish(o, buildings, Json::array({{{"milliseconds", milliseconds}}}));
}

ExitCode run(Options o) {
  o.settings.cache_bytes = o.cache_mb << 20;
  const auto backend = find_enum<render::Backend>(o.backend);
  if (!backend) throw UsageError(fmt::format("--backend {}: there is none", o.backend));
  o.settings.backend = *backend;
  if (!o.images.empty() && o.scans.empty()) {
    throw UsageError("--images needs --scans: ids with commas between");
  }
  if (o.images.empty() && !o.scans.empty()) {
    throw UsageError("--scans needs --images: the folder that has them");
  }
  if (o.mode == "first-frame") {
    run_first_frame(o);
  } else if (o.mode == "walk-memory") {
    run_walk_memory(o);
  } else {
    run_table(o);
  }
  return kSuccess;
}

void add_place_options(CLI::App& app, Options& o) {
  app.add_option("--images", o.images,
                 "Folder of stores or of Matterport3D's scans; may be given more than once "
                 "(default: synthetic panoramas in memory)")
      ->type_name("DIR")
      ->allow_extra_args(false);
  app.add_option("--connectivity", o.connectivity,
                 "Folder of SCAN_connectivity.json, for loose files (default: ENFILADE_DATA's)")
      ->type_name("DIR");
  app.add_option("--scans", o.scans, "Scans to walk in, commas between")->type_name("LIST");
}

void add_combination_options(CLI::App& app, Options& o) {
  app.add_option("--backend", o.backend, "What draws")
      ->check(CLI::IsMember({"cpu", "cpu-scalar", "gl", "cuda"}))
      ->capture_default_str();
  app.add_option("--gl-device", o.settings.gl_device, "Index or UUID of an EGL device");
  app.add_option("--cpu-target", o.settings.cpu_target,
                 fmt::format("Instruction set of the cpu back end, instead of the fastest: {}",
                             fmt::join(render::cpu_targets(), ", ")));
  app.add_option("--size", o.sizes, "Pixels, commas between")
      ->capture_default_str()
      ->type_name("WxH,...");
  app.add_option("--vfov", o.vfov, "Opening from top to bottom, degrees")
      ->check(finite_number())
      ->capture_default_str();
  app.add_option("--outputs", o.outputs,
                 "Commas between rows of the table, + between parts of one: rgb, bgr, rgba, f16, "
                 "f32, depth, class, instance")
      ->capture_default_str()
      ->type_name("LIST");
  app.add_option("--batch", o.batches, "Agents")->capture_default_str()->type_name("N,...");
  app.add_option("--threads", o.threads, "That draw and decode; 0: all cores")
      ->capture_default_str()
      ->type_name("N,...");
  app.add_option("--cache", o.caches, "hot: all decoded before; cold: nothing, each repetition")
      ->capture_default_str()
      ->type_name("LIST");
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  using namespace enfilade::bench;
  CLI::App app("Measures how fast panoramas are drawn.", "bench_render");
  Options o;
  int status = kSuccess;
  app.add_option("mode", o.mode,
                 "walk: agents walk at random; sweep: 36 views of every panorama, decoding "
                 "included; first-frame: from process start; walk-memory: what a walk takes")
      ->check(CLI::IsMember({"walk", "sweep", "first-frame", "walk-memory"}))
      ->capture_default_str();
  add_place_options(app, o);
  add_combination_options(app, o);
  app.add_option("--cache-mb", o.cache_mb, "Size of the cache when it is cold, MiB")
      ->check(whole_number())
      ->capture_default_str();
  app.add_flag("--prefetch", o.settings.prefetch, "Decode neighbours ahead, in one more thread");
  app.add_option("--frames", o.settings.frames, "A repetition of a walk")
      ->check(whole_number(1))
      ->capture_default_str();
  app.add_option("--reps", o.settings.repetitions, "Of which the median is printed")
      ->check(whole_number(1))
      ->capture_default_str();
  app.add_option("--json", o.json, "Write the table as JSON too")->type_name("FILE");
  app.add_flag("--first-frame-child", o.first_frame_child)->group("");  // hidden: we call ourselves
  set_examples(app, {"bench_render --size 640x480,224x224 --outputs rgb,f16 --threads 1,2",
                     "bench_render --images stores --scans 17DRP5sb8fy --cache hot,cold --batch 10",
                     "bench_render sweep --images stores --scans 17DRP5sb8fy --outputs rgb",
                     "bench_render first-frame --images stores --scans 17DRP5sb8fy --outputs rgb"});
  app.callback([&] { status = run(o); });
  return run_program(app, argc, argv, status);
}
