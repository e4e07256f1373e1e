// Reading and making the files of the benchmarks: an RxR guide of 126,000 lines (SYNTHETIC: words
// of chance along the paths of R2R, in the form of the released files), REVERIE's val unseen with
// all boxes in one file, R4R joined from R2R and read back, its walks scored and written. Files lie
// in the system's temporary folder and have just been written, so that they are in its cache.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/main.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/rng.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/r4r.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLines = 126000,
                      kWords = 101;  // RxR: 78 words in the mean, and more of te-IN

fs::path data_folder() { return scan::DataRoot::from_environment()->folder(); }

// A file that is gone at the end.
class MadeFile {
 public:
  MadeFile(const std::string& name, const std::string& content)
      : path_(fs::temp_directory_path() / ("enfilade_bench_" + name)) {
    write_file_atomically(path_, content);
  }
  ~MadeFile() { fs::remove(path_); }
  MadeFile(const MadeFile&) = delete;
  MadeFile& operator=(const MadeFile&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

tasks::Annotations r2r(const char* split) {
  return tasks::load_annotations(scan::DataRoot::from_environment()->annotations(split), split);
}

// A line as RxR's guides have it.
void append_line(std::size_t id, const tasks::PathAnnotation& path, Rng& rng, std::string& lines) {
  static constexpr const char* kSome[]{"Okay,", "now",  "you",  "are",   "standing", "in",
                                       "front", "of",   "the",  "white", "door.",    "Turn",
                                       "to",    "your", "left", "and",   "walk",     "forward."};
  std::string text, timed;
  double time = 0.4;
  for (std::size_t k = 0; k < kWords; ++k) {
    const std::string word = kSome[rng.below(std::size(kSome))];
    const double end = time + 0.1 * static_cast<double>(1 + rng.below(6));
    if (k > 0) text += ' ';
    text += word;
    timed += fmt::format(R"({}{{"start_time": {:.1f}, "word": "{}", "end_time": {:.1f}}})",
                         k > 0 ? ", " : "", time, word, end);
    time = end;
  }
  std::string ids;
  for (const std::string& viewpoint : path.path) {
    ids += fmt::format(R"({}"{}")", ids.empty() ? "" : ", ", viewpoint);
  }
  fmt::format_to(
      std::back_inserter(lines),
      R"({{"path_id": {}, "split": "train", "scan": "{}", "heading": {}, "path": [{}], )"
      R"("instruction_id": {}, "annotator_id": 19, "language": "en-US", "instruction": "{}", )"
      R"("timed_instruction": [{}], "edit_distance": 0.11137440758293839}})"
      "\n",
      path.path_id, path.scan, path.heading.value, ids, id, text, timed);
}

void rxr_guide(benchmark::State& state) {
  const tasks::Annotations paths = r2r("train");
  Rng rng(1);
  std::string lines;
  for (std::size_t k = 0; k < kLines; ++k) {
    append_line(k, paths.paths[k % paths.paths.size()], rng, lines);
  }
  const MadeFile file("rxr_guide.jsonl", lines);
  const std::size_t bytes = lines.size();
  std::string().swap(lines);
  for (auto _ : state) {
    benchmark::DoNotOptimize(tasks::load_annotations(file.path(), "train", tasks::Task::kRxr));
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kLines));
}

// Instructions, and the boxes around all viewpoints, unpacked.
void reverie_with_boxes(benchmark::State& state) {
  const fs::path folder = data_folder() / "reverie";
  const MadeFile boxes("boxes.json", read_text_file(folder / "BBox.json.gz"));
  for (auto _ : state) {
    benchmark::DoNotOptimize(tasks::load_annotations(folder / "v2/REVERIE_val_unseen.json",
                                                     "val_unseen", tasks::Task::kReverie));
    benchmark::DoNotOptimize(tasks::ObjectBoxes::load(boxes.path()));
  }
}

// From the files of R2R and of the graphs to the text of R4R's.
void make_r4r(benchmark::State& state, const char* split) {
  const auto data = *scan::DataRoot::from_environment();
  std::size_t bytes = 0;
  for (auto _ : state) {
    const auto graphs = graph::GraphSet::open(data.connectivity());
    bytes = to_json(tasks::join_paths(r2r(split), *graphs)).size();
  }
  state.counters["megabytes"] = static_cast<double>(bytes) / 1e6;
}

void read_r4r(benchmark::State& state) {
  const auto graphs = graph::GraphSet::open(scan::DataRoot::from_environment()->connectivity());
  const std::string text = to_json(tasks::join_paths(r2r("train"), *graphs));
  const MadeFile file("r4r.json", text);
  for (auto _ : state) {
    benchmark::DoNotOptimize(tasks::load_annotations(file.path(), "train", tasks::Task::kR4r));
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
}

// R4R's val unseen with a walk of 20 actions in every episode.
struct R4rWalks {
  tasks::EpisodeSet episodes;
  std::vector<tasks::Trajectory> trajectories;
};

R4rWalks r4r_walks() {
  const auto graphs = graph::GraphSet::open(scan::DataRoot::from_environment()->connectivity());
  tasks::Annotations r4r{"val_unseen", "R4R", {}, tasks::Task::kR4r};
  for (tasks::JoinedPath& one : tasks::join_paths(r2r("val_unseen"), *graphs).paths) {
    r4r.paths.push_back(std::move(one.path));
  }
  R4rWalks walks{tasks::make_episodes(r4r, graphs), {}};
  Rng rng(1);
  for (std::size_t i = 0; i < walks.episodes.episodes.size(); ++i) {
    const tasks::Episode& episode = walks.episodes.episodes[i];
    const graph::NavGraph& graph = walks.episodes.graph_of(episode);
    ViewpointIndex at = walks.episodes.path_of(episode).viewpoints.front();
    tasks::Trajectory& trajectory = walks.trajectories.emplace_back();
    trajectory.episode = i;
    for (std::uint64_t k = 0; k <= 20; ++k) {
      trajectory.points.push_back({at, degrees(30.0 * static_cast<double>(k % 12)), Radians(0)});
      const auto edges = graph.edges(at);
      if (rng.below(3) > 0) at = edges[rng.below(edges.size())].target;  // else a turn
    }
  }
  return walks;
}

// All of HAMT's metrics, nDTW, SDTW and CLS among them, with their intervals.
void score_r4r(benchmark::State& state) {
  const R4rWalks walks = r4r_walks();
  const auto& scorer = tasks::benchmark(tasks::Task::kR4r).scorers.front();
  for (auto _ : state) {
    benchmark::DoNotOptimize(compute_score(walks.trajectories, walks.episodes, scorer));
  }
  state.SetItemsProcessed(state.iterations() *
                          static_cast<std::int64_t>(walks.trajectories.size()));
}

void write_results(benchmark::State& state) {
  const R4rWalks walks = r4r_walks();
  std::size_t bytes = 0;
  for (auto _ : state) bytes = to_json(walks.trajectories, walks.episodes).size();
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes));
}

template <class Function>
void add(const char* name, const Function& function) {
  benchmark::RegisterBenchmark(name, function)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->MeasureProcessCPUTime();
}

void register_all() {
  add("rxr_guide", rxr_guide);
  add("reverie_with_boxes", reverie_with_boxes);
  add("make_r4r/val_unseen", [](benchmark::State& state) { make_r4r(state, "val_unseen"); });
  add("make_r4r/train", [](benchmark::State& state) { make_r4r(state, "train"); });
  add("read_r4r/train", read_r4r);
  add("score_r4r/val_unseen", score_r4r);
  add("write_results/r4r_val_unseen", write_results);
}

}  // namespace
}  // namespace enfilade

int main(int argc, char** argv) { return enfilade::bench::run(argc, argv, enfilade::register_all); }
