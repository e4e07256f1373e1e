#include "enfilade/tasks/benchmark.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "enfilade/core/errors.h"
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
constexpr auto kCvdnSplits =
    std::to_array<Texts>({"train", "val_seen", "val_unseen", "test_cleaned", "test"});
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
constexpr auto kR2rCePlaces = std::to_array<Texts>(
    {"vlnce/{}.json.gz", "R2R_VLNCE_v1-3_preprocessed/{}/{}.json.gz",
     "R2R_VLNCE_v1-3/{}/{}.json.gz", "R2R_VLNCE_v1-2_preprocessed/{}/{}.json.gz",
     "R2R_VLNCE_v1-2/{}/{}.json.gz", "data/datasets/R2R_VLNCE_v1-3_preprocessed/{}/{}.json.gz",
     "data/datasets/R2R_VLNCE_v1-3/{}/{}.json.gz",
     "data/datasets/R2R_VLNCE_v1-2_preprocessed/{}/{}.json.gz",
     "data/datasets/R2R_VLNCE_v1-2/{}/{}.json.gz", "{}.json.gz"});
constexpr auto kR2rCeExperts = std::to_array<Texts>(
    {"vlnce/{}_gt.json.gz", "R2R_VLNCE_v1-3_preprocessed/{}/{}_gt.json.gz",
     "R2R_VLNCE_v1-3/{}/{}_gt.json.gz", "R2R_VLNCE_v1-2_preprocessed/{}/{}_gt.json.gz",
     "R2R_VLNCE_v1-2/{}/{}_gt.json.gz",
     "data/datasets/R2R_VLNCE_v1-3_preprocessed/{}/{}_gt.json.gz",
     "data/datasets/R2R_VLNCE_v1-3/{}/{}_gt.json.gz",
     "data/datasets/R2R_VLNCE_v1-2_preprocessed/{}/{}_gt.json.gz",
     "data/datasets/R2R_VLNCE_v1-2/{}/{}_gt.json.gz", "{}_gt.json.gz"});
constexpr auto kR2rCeBertPlaces = std::to_array<Texts>(
    {"vlnce/{}_bertidx.json.gz", "R2R_VLNCE_v1-3_BERTidx/{}/{}_bertidx.json.gz",
     "R2R_VLNCE_v1-2_preprocessed_BERTidx/{}/{}_bertidx.json.gz",
     "data/datasets/R2R_VLNCE_v1-3_BERTidx/{}/{}_bertidx.json.gz",
     "data/datasets/R2R_VLNCE_v1-2_preprocessed_BERTidx/{}/{}_bertidx.json.gz",
     "{}_bertidx.json.gz"});
constexpr auto kRxrCeGuides = std::to_array<Texts>(
    {"vlnce/{}_guide.json.gz", "RxR_VLNCE_v0/{}/{}_guide.json.gz",
     "RxR_VLNCE_v0_enc_xlmr/{}/{}_guide.json.gz", "data/datasets/RxR_VLNCE_v0/{}/{}_guide.json.gz",
     "data/datasets/RxR_VLNCE_v0_enc_xlmr/{}/{}_guide.json.gz", "{}_guide.json.gz"});
constexpr auto kRxrCeGuideExperts = std::to_array<Texts>(
    {"vlnce/{}_guide_gt.json.gz", "RxR_VLNCE_v0/{}/{}_guide_gt.json.gz",
     "RxR_VLNCE_v0_enc_xlmr/{}/{}_guide_gt.json.gz",
     "data/datasets/RxR_VLNCE_v0/{}/{}_guide_gt.json.gz",
     "data/datasets/RxR_VLNCE_v0_enc_xlmr/{}/{}_guide_gt.json.gz", "{}_guide_gt.json.gz"});
constexpr auto kRxrCeFollowers = std::to_array<Texts>(
    {"vlnce/{}_follower.json.gz", "RxR_VLNCE_v0/{}/{}_follower.json.gz",
     "RxR_VLNCE_v0_enc_xlmr/{}/{}_follower.json.gz",
     "data/datasets/RxR_VLNCE_v0/{}/{}_follower.json.gz",
     "data/datasets/RxR_VLNCE_v0_enc_xlmr/{}/{}_follower.json.gz", "{}_follower.json.gz"});
constexpr auto kRxrCeFollowerExperts = std::to_array<Texts>(
    {"vlnce/{}_follower_gt.json.gz", "RxR_VLNCE_v0/{}/{}_follower_gt.json.gz",
     "RxR_VLNCE_v0_enc_xlmr/{}/{}_follower_gt.json.gz",
     "data/datasets/RxR_VLNCE_v0/{}/{}_follower_gt.json.gz",
     "data/datasets/RxR_VLNCE_v0_enc_xlmr/{}/{}_follower_gt.json.gz", "{}_follower_gt.json.gz"});

constexpr std::array<FilePlaces, 1> kR2rFiles{{{"", kR2rPlaces}}};
constexpr std::array<FilePlaces, 1> kR2rLastFiles{{{"", kR2rLastPlaces}}};
constexpr std::array<FilePlaces, 1> kR2rBackFiles{{{"", kR2rBackPlaces}}};
constexpr std::array<FilePlaces, 1> kR4rFiles{{{"", kR4rPlaces}}};
constexpr std::array<FilePlaces, 1> kRxrFiles{{{"guide", kRxrPlaces}}};
constexpr std::array<FilePlaces, 1> kReverieFiles{{{"", kReveriePlaces}}};
constexpr std::array<FilePlaces, 1> kCvdnFiles{{{"", kCvdnPlaces}}};
constexpr std::array<FilePlaces, 1> kSoonFiles{{{"", kSoonPlaces}}};
constexpr std::array<FilePlaces, 2> kR2rCeFiles{
    {{"", kR2rCePlaces, kR2rCeExperts}, {"bertidx", kR2rCeBertPlaces, kR2rCeExperts}}};
constexpr std::array<FilePlaces, 2> kRxrCeFiles{
    {{"guide", kRxrCeGuides, kRxrCeGuideExperts},
     {"follower", kRxrCeFollowers, kRxrCeFollowerExperts}}};

// Behind the table of CVDN is HAMT's scorer: its success is to end in the region, and it needs none
// of the paths that files without dialogues lack. Goal progress is the same in all of CVDN's.
constexpr auto kBenchmarks = std::to_array<Benchmark>({
    {.name = "r2r",
     .title = "R2R",
     .splits = kSplits,
     .files = kR2rFiles,
     .scorers = scorers::kR2r,
     .scored_instructions = kScoredInstructions,
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
     .splits = kCvdnSplits,
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
     .world = World::kContinuous,
     .goal = GoalKind::kPoint,
     .splits = kSplits,
     .files = kR2rCeFiles,
     .scorers = scorers::kR2rCe,
     .form = ContinuousForm::kR2r,
     .results_form = ContinuousResultsForm::kR2r},
    {.name = "rxr-ce",
     .title = "RxR-CE",
     .world = World::kContinuous,
     .task = Task::kRxr,
     .paths = Task::kRxr,
     .goal = GoalKind::kPoint,
     .splits = kRxrSplits,
     .files = kRxrCeFiles,
     .scorers = scorers::kRxrCe,
     .languages = true,
     .form = ContinuousForm::kRxr,
     .results_form = ContinuousResultsForm::kRxr},
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

std::vector<std::string_view> names_of(std::optional<World> world) {
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
  throw LookupError(fmt::format("{} has no files of kind {:?}", benchmark.title, kind));
}

std::vector<std::filesystem::path> fill(std::span<const std::string_view> patterns,
                                        std::string_view split) {
  std::vector<std::filesystem::path> places;
  for (const std::string_view pattern : patterns) {
    std::string place(pattern);
    for (std::size_t at = place.find("{}"); at != std::string::npos;
         at = place.find("{}", at + split.size())) {
      place.replace(at, 2, split);
    }
    places.emplace_back(place);
    if (!place.ends_with(".gz")) places.emplace_back(place + ".gz");
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
  throw LookupError(fmt::format("no scorer {:?} for {}; there are {}", scorer_name, title,
                                fmt::join(names, ", ")));
}

std::span<const Benchmark> benchmarks() noexcept { return kBenchmarks; }

const Benchmark* find_benchmark(std::string_view name) noexcept {
  const auto* found = std::ranges::find(kBenchmarks, name, &Benchmark::name);
  return found == kBenchmarks.end() ? nullptr : found;
}

const Benchmark& benchmark(std::string_view name) {
  if (const Benchmark* found = find_benchmark(name)) return *found;
  throw LookupError(
      fmt::format("no task {:?}; there are {}", name, fmt::join(names_of(std::nullopt), ", ")));
}

const Benchmark& benchmark(std::string_view name, World world) {
  const Benchmark* found = find_benchmark(name);
  if (found != nullptr && found->world == world) return *found;
  const std::string_view what = world == World::kGraph ? "task" : "continuous benchmark";
  throw LookupError(
      fmt::format("no {} {:?}; there are {}", what, name, fmt::join(names_of(world), ", ")));
}

const Benchmark& benchmark(Task task) noexcept {
  return kBenchmarks[static_cast<std::size_t>(task)];
}

std::vector<std::filesystem::path> episode_places(const Benchmark& benchmark,
                                                  std::string_view split, std::string_view kind) {
  return fill(files_of(benchmark, kind).episodes, split);
}

std::vector<std::filesystem::path> expert_places(const Benchmark& benchmark, std::string_view split,
                                                 std::string_view kind) {
  return fill(files_of(benchmark, kind).experts, split);
}

}  // namespace enfilade::tasks
