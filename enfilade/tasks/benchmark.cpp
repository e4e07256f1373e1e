#include "enfilade/tasks/benchmark.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks {
namespace {

using Texts = std::string_view;

constexpr auto kSplits = std::to_array<Texts>({"train", "val_seen", "val_unseen", "test"});
constexpr auto kRxrSplits = std::to_array<Texts>(
    {"train", "val_seen", "val_unseen", "test_standard_public", "test_challenge_public", "test"});
constexpr auto kSoonSplits =
    std::to_array<Texts>({"train", "val_seen_instrs", "val_unseen_instrs", "val_unseen_house",
                          "val_seen", "val_unseen", "test"});

constexpr auto kR2rPlaces =
    std::to_array<Texts>({"r2r/R2R_{}.json", "tasks/R2R/data/R2R_{}.json", "R2R/R2R_{}.json",
                          "R2R_{}.json", "R2R/annotations/R2R_{}_enc.json"});
constexpr auto kR2rLastPlaces =
    std::to_array<Texts>({"r2r-last/R2R_{}.json", "R2R/annotations/LastSent/R2R_{}_enc.json",
                          "LastSent/R2R_{}_enc.json"});
constexpr auto kR2rBackPlaces =
    std::to_array<Texts>({"r2r-back/R2R_{}.json", "R2R/annotations/ReturnBack/R2R_{}_enc.json",
                          "ReturnBack/R2R_{}_enc.json"});
constexpr auto kR4rPlaces = std::to_array<Texts>(
    {"r4r/R4R_{}.json", "R4R/annotations/R4R_{}_enc.json", "R4R/R4R_{}.json", "R4R_{}.json"});
constexpr auto kRxrPlaces =
    std::to_array<Texts>({"rxr/rxr_{}_guide.jsonl", "RxR/annotations/rxr_{}_guide_enc_xlmr.jsonl",
                          "RxR/rxr_{}_guide.jsonl", "rxr_{}_guide.jsonl"});
constexpr auto kReveriePlaces =
    std::to_array<Texts>({"reverie/REVERIE_{}.json", "reverie/v2/REVERIE_{}.json",
                          "REVERIE/annotations/REVERIE_{}_enc.json",
                          "tasks/REVERIE/data/REVERIE_{}.json", "REVERIE_{}.json"});
constexpr auto kCvdnPlaces =
    std::to_array<Texts>({"cvdn/{}.json", "tasks/NDH/data/{}.json", "CVDN/annotations/{}.json",
                          "CVDN/annotations/{}_enc.json"});
constexpr auto kSoonPlaces =
    std::to_array<Texts>({"soon/{}.json", "SOON/annotations/{}.json",
                          "SOON/annotations/bert_enc/{}_enc_pseudo_obj_label.jsonl",
                          "SOON/annotations/bert_enc/{}_enc.jsonl"});

// VLN-CE's: newer versions first; of one version the one with tokens.
constexpr auto kR2rCeFolders =
    std::to_array<Texts>({"R2R_VLNCE_v1-3_preprocessed", "R2R_VLNCE_v1-3",
                          "R2R_VLNCE_v1-2_preprocessed", "R2R_VLNCE_v1-2"});
constexpr auto kR2rCeBertFolders =
    std::to_array<Texts>({"R2R_VLNCE_v1-3_BERTidx", "R2R_VLNCE_v1-2_preprocessed_BERTidx"});
constexpr auto kRxrCeFolders = std::to_array<Texts>({"RxR_VLNCE_v0", "RxR_VLNCE_v0_enc_xlmr"});

constexpr std::array<FilePlaces, 1> kR2rFiles{{{"", kR2rPlaces}}};
constexpr std::array<FilePlaces, 1> kR2rLastFiles{{{"", kR2rLastPlaces}}};
constexpr std::array<FilePlaces, 1> kR2rBackFiles{{{"", kR2rBackPlaces}}};
constexpr std::array<FilePlaces, 1> kR4rFiles{{{"", kR4rPlaces}}};
constexpr std::array<FilePlaces, 1> kRxrFiles{{{"guide", kRxrPlaces}}};
constexpr std::array<FilePlaces, 1> kReverieFiles{{{"", kReveriePlaces}}};
constexpr std::array<FilePlaces, 1> kCvdnFiles{{{"", kCvdnPlaces}}};
constexpr std::array<FilePlaces, 1> kSoonFiles{{{"", kSoonPlaces}}};
constexpr std::array<FilePlaces, 2> kR2rCeFiles{
    {{"", kR2rCeFolders, "{}"}, {"bertidx", kR2rCeBertFolders, "{}_bertidx", false}}};
constexpr std::array<FilePlaces, 2> kRxrCeFiles{
    {{"guide", kRxrCeFolders, "{}_guide"}, {"follower", kRxrCeFolders, "{}_follower"}}};

// Behind the table of CVDN is HAMT's scorer: its success is to end in the region, and it needs none
// of the paths that files without dialogues lack. Goal progress is the same in all of CVDN's.
constexpr auto kBenchmarks = std::to_array<Benchmark>({
    {.name = "r2r",
     .title = "R2R",
     .splits = kSplits,
     .files = kR2rFiles,
     .scorers = scorers::kR2r,
     .scored_instructions = kScoredInstructions,
     .leaderboard = "Those of R2R's test are known to its leaderboard only: hand the file in at "
                    "eval.ai, challenge 97",
     .in_paper = true},
    {.name = "r2r-last",
     .title = "R2R-Last",
     .task = Task::kR2rLast,
     .splits = kSplits,
     .files = kR2rLastFiles,
     .scorers = scorers::kR2rLast,
     .table_scorer = "hamt"},
    {.name = "r2r-back",
     .title = "R2R-Back",
     .task = Task::kR2rBack,
     .goal = GoalKind::kTurningPoint,
     .answer = AnswerKind::kTurningPoint,
     .splits = kSplits,
     .files = kR2rBackFiles,
     .scorers = scorers::kR2rBack,
     .table_scorer = "hamt"},
    {.name = "r4r",
     .title = "R4R",
     .task = Task::kR4r,
     .joins_paths = true,
     .splits = kSplits,
     .files = kR4rFiles,
     .scorers = scorers::kR4r,
     .table_scorer = "hamt"},
    {.name = "rxr",
     .title = "RxR",
     .task = Task::kRxr,
     .paths = Task::kRxr,
     .splits = kRxrSplits,
     .files = kRxrFiles,
     .scorers = scorers::kRxr,
     .table_scorer = "hamt",
     .languages = true},
    {.name = "reverie",
     .title = "REVERIE",
     .task = Task::kReverie,
     .goal = GoalKind::kObject,
     .answer = AnswerKind::kObject,
     .splits = kSplits,
     .files = kReverieFiles,
     .scorers = scorers::kReverie,
     .table_scorer = "official",
     .along_edges = false},
    {.name = "cvdn",
     .title = "CVDN",
     .task = Task::kCvdn,
     .paths = Task::kCvdn,
     .goal = GoalKind::kRegion,
     .starts_between = true,
     .splits = kSplits,
     .test_file = "test_cleaned",
     .files = kCvdnFiles,
     .scorers = scorers::kCvdn,
     .table_scorer = "hamt",
     .along_edges = false},
    {.name = "soon",
     .title = "SOON",
     .task = Task::kSoon,
     .paths = Task::kSoon,
     .goal = GoalKind::kBoxes,
     .answer = AnswerKind::kPoint,
     .splits = kSoonSplits,
     .files = kSoonFiles,
     .scorers = scorers::kSoon,
     .table_scorer = "duet",
     .along_edges = false},
    {.name = "r2r-ce",
     .title = "R2R-CE",
     .world = WorldKind::kContinuous,
     .goal = GoalKind::kPoint,
     .splits = kSplits,
     .files = kR2rCeFiles,
     .scorers = scorers::kR2rCe,
     .form = ContinuousForm::kR2r},
    {.name = "rxr-ce",
     .title = "RxR-CE",
     .world = WorldKind::kContinuous,
     .task = Task::kRxr,
     .paths = Task::kRxr,
     .goal = GoalKind::kPoint,
     .splits = kRxrSplits,
     .files = kRxrCeFiles,
     .scorers = scorers::kRxrCe,
     .languages = true,
     .form = ContinuousForm::kRxr},
});

// benchmark(Task) is an index.
consteval bool is_by_task() {
  for (std::size_t k = 0; k < kBenchmarks.size(); ++k) {
    const Benchmark& one = kBenchmarks[k];
    const bool graph = k <= static_cast<std::size_t>(Task::kSoon);
    if (one.continuous() == graph) return false;
    if (graph && one.task != static_cast<Task>(k)) return false;
  }
  return true;
}
static_assert(is_by_task());

std::vector<std::string_view> names_of(std::optional<WorldKind> world) {
  std::vector<std::string_view> names;
  for (const Benchmark& one : kBenchmarks) {
    if (!world || one.world == *world) names.push_back(one.name);
  }
  return names;
}

const FilePlaces& files_of(const Benchmark& benchmark, std::string_view kind) {
  if (kind.empty()) return benchmark.files.front();
  const auto found = std::ranges::find(benchmark.files, kind, &FilePlaces::kind);
  if (found != benchmark.files.end()) return *found;
  throw LookupError(fmt::format("{} has no files of kind {}", benchmark.title, quote(kind)));
}

// Continuous: Enfilade's folder, those of the public code, the same where that has them, none.
std::vector<std::string> patterns_of(const FilePlaces& files, std::string_view ending) {
  if (files.name.empty()) return {files.places.begin(), files.places.end()};
  const std::string file = fmt::format("{}{}.json.gz", files.name, ending);
  std::vector<std::string> patterns{"vlnce/" + file};
  for (const std::string_view before : {"", "data/datasets/"}) {
    for (const std::string_view folder : files.places) {
      patterns.push_back(fmt::format("{}{}/{{}}/{}", before, folder, file));
    }
  }
  patterns.push_back(file);
  return patterns;
}

std::vector<std::filesystem::path> fill(const std::vector<std::string>& patterns,
                                        std::string_view split) {
  std::vector<std::filesystem::path> places;
  for (std::string place : patterns) {
    for (std::size_t at = place.find("{}"); at != std::string::npos;
         at = place.find("{}", at + split.size())) {
      place.replace(at, 2, split);
    }
    places.emplace_back(place);
    constexpr std::string_view kPacked = ".gz";
    const bool packed = place.ends_with(kPacked);  // people unpack files, too
    places.emplace_back(packed ? place.substr(0, place.size() - kPacked.size())
                               : place.append(kPacked));
  }
  return places;
}

}  // namespace

const Scorer& Benchmark::scorer(std::string_view scorer_name) const {
  if (scorer_name.empty()) return scorers.front();
  const auto found = std::ranges::find(scorers, scorer_name, &Scorer::name);
  if (found != scorers.end()) return *found;
  std::vector<std::string_view> names;
  for (const Scorer& one : scorers) names.push_back(one.name);
  throw LookupError(fmt::format("no scorer {} for {}; there are {}", quote(scorer_name), title,
                                fmt::join(names, ", ")));
}

std::span<const Benchmark> benchmarks() noexcept { return kBenchmarks; }

const Benchmark* find_benchmark(std::string_view name) noexcept {
  const auto* found = std::ranges::find(kBenchmarks, name, &Benchmark::name);
  return found == kBenchmarks.end() ? nullptr : found;
}

const Benchmark& benchmark(std::string_view name) {
  if (const Benchmark* found = find_benchmark(name)) return *found;
  throw LookupError(fmt::format("no task {}; there are {}", quote(name),
                                fmt::join(names_of(std::nullopt), ", ")));
}

const Benchmark& benchmark(std::string_view name, WorldKind world) {
  const Benchmark* found = find_benchmark(name);
  if (found != nullptr && found->world == world) return *found;
  const std::string_view what = world == WorldKind::kGraph ? "task" : "continuous benchmark";
  throw LookupError(
      fmt::format("no {} {}; there are {}", what, quote(name), fmt::join(names_of(world), ", ")));
}

const Benchmark& benchmark(Task task) noexcept {
  return kBenchmarks[static_cast<std::size_t>(task)];
}

std::vector<std::filesystem::path> episode_places(const Benchmark& benchmark,
                                                  std::string_view split, std::string_view kind) {
  const std::vector<std::string> patterns = patterns_of(files_of(benchmark, kind), "");
  std::vector<std::filesystem::path> places = fill(patterns, split);
  if (split == "test" && !benchmark.test_file.empty()) {
    for (auto& place : fill(patterns, benchmark.test_file)) places.push_back(std::move(place));
  }
  return places;
}

std::vector<std::filesystem::path> expert_places(const Benchmark& benchmark, std::string_view split,
                                                 std::string_view kind) {
  const FilePlaces& files = files_of(benchmark, kind);
  if (!benchmark.continuous()) return {};
  return fill(patterns_of(files.experts ? files : benchmark.files.front(), "_gt"), split);
}

}  // namespace enfilade::tasks
