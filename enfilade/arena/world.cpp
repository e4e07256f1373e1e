#include "enfilade/arena/world.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;

std::shared_ptr<const graph::GraphSet> graphs_of(const tasks::EpisodeSet* episodes) {
  if (episodes == nullptr || episodes->episodes.empty()) throw ArgumentError("episodes: none");
  return episodes->graphs;
}

std::string joined(std::span<const std::string> entries, std::string_view before,
                   std::string_view between, std::string_view after) {
  std::string all(before);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    if (k > 0) all += between;
    all += entries[k];
  }
  all += after;
  return all;
}

}  // namespace

std::optional<std::size_t> World::find(std::string_view id) const {
  const auto found = by_id_->find(id);
  return found == by_id_->end() ? std::nullopt : std::optional(found->second);
}

void World::index_ids() {
  auto by_id = std::make_shared<std::map<std::string, std::size_t, std::less<>>>();
  for (std::size_t e = 0; e < size(); ++e) by_id->emplace(episode_id(e), e);
  by_id_ = std::move(by_id);
}

GraphWorld::GraphWorld(std::shared_ptr<const tasks::EpisodeSet> episodes, WordsSource words)
    : episodes_(std::move(episodes)),
      panoramas_(graphs_of(episodes_.get())),
      words_source_(std::move(words)) {
  index_ids();
}

GraphWorld::GraphWorld(const GraphWorld& other)
    : World(other),
      episodes_(other.episodes_),
      panoramas_(episodes_->graphs),
      words_source_(other.words_source_) {}

const std::string& GraphWorld::words_of(const Standpoint& from) {
  static const std::string kNone;
  if (!words_source_) return kNone;
  if (!words_) words_ = words_source_();
  const std::string key = fmt::format("{}/{}/{:.4f}/{:.4f}", from.scan, from.place,
                                      to_degrees(from.heading), to_degrees(from.elevation));
  const auto [at, is_new] = known_words_.try_emplace(key);
  if (is_new) at->second = words_->of(from);
  return at->second;
}

std::unique_ptr<World> GraphWorld::another() const {
  return std::unique_ptr<World>(new GraphWorld(*this));
}
std::string_view GraphWorld::task() const noexcept {
  return tasks::benchmark(episodes_->task).name;
}
const std::string& GraphWorld::split() const noexcept { return episodes_->split; }
std::size_t GraphWorld::size() const noexcept { return episodes_->episodes.size(); }
bool GraphWorld::goals_hidden() const noexcept { return tasks::goals_hidden(*episodes_); }

std::string GraphWorld::episode_id(std::size_t episode) const {
  return episodes_->episodes[episode].instruction_id;
}

PathSize GraphWorld::path_size(std::size_t episode) const {
  const tasks::ReferencePath& path = episodes_->path_of(episodes_->episodes[episode]);
  const graph::NavGraph& graph = episodes_->graphs->graph(path.scan);
  return {graph.scan(), path.viewpoints.size(), tasks::length_of(path, graph)};
}

std::unique_ptr<Session> GraphWorld::start(std::size_t episode, const Limits& limits) {
  return start_on_graph(episode, limits);
}

std::string GraphWorld::result(const Walked& walked) const {
  const std::vector<tasks::Trajectory> one{std::get<tasks::Trajectory>(walked)};
  return Json::parse(tasks::to_json(one, *episodes_))[0].dump();
}

std::string GraphWorld::results(std::span<const std::string> entries) const {
  return joined(entries, "[\n", ",\n", "\n]\n");
}

FreeWorld::FreeWorld(agents::ContinuousWorld world, const agents::ContinuousSetup& setup,
                     WordsSource words)
    : world_(std::move(world)), setup_(&setup), words_source_(std::move(words)) {
  if (!world_.episodes || !world_.buildings) throw ArgumentError("world: no episodes or buildings");
  if (world_.episodes->episodes.empty()) throw ArgumentError("episodes: none");
  index_ids();
}

FreeWorld::FreeWorld(const FreeWorld& other)
    : World(other),
      world_(other.world_),
      setup_(other.setup_),
      words_source_(other.words_source_) {}

std::unique_ptr<FreeWorld> FreeWorld::open(const agents::ContinuousSetup& setup,
                                           const std::filesystem::path& data,
                                           const std::string& split, WordsSource words) {
  agents::ContinuousWorld world;
  world.episodes = std::make_shared<const tasks::ContinuousEpisodes>(
      agents::load_continuous_split(*setup.benchmark, data, split));
  world.buildings = std::make_shared<const continuous::Buildings>(data / setup.navigation_folder());
  return std::make_unique<FreeWorld>(std::move(world), setup, std::move(words));
}

std::unique_ptr<World> FreeWorld::another() const {
  return std::unique_ptr<World>(new FreeWorld(*this));
}
std::string_view FreeWorld::task() const noexcept { return setup_->benchmark->name; }
const std::string& FreeWorld::split() const noexcept { return world_.episodes->split; }
std::size_t FreeWorld::size() const noexcept { return world_.episodes->episodes.size(); }
bool FreeWorld::goals_hidden() const noexcept { return tasks::goals_hidden(*world_.episodes); }

std::string FreeWorld::episode_id(std::size_t episode) const {
  return tasks::text_of(world_.episodes->episodes[episode].id);
}

PathSize FreeWorld::path_size(std::size_t episode) const {
  const tasks::ContinuousEpisode& one = world_.episodes->episodes[episode];
  PathSize size{std::string(one.scan()), 1, 0};
  if (!one.reference_path) return size;
  const std::vector<Vec3d>& points = *one.reference_path;
  size.places = points.size();
  for (std::size_t k = 1; k < points.size(); ++k) size.length += length(points[k] - points[k - 1]);
  return size;
}

std::unique_ptr<Session> FreeWorld::start(std::size_t episode, const Limits& limits) {
  return start_free(episode, limits);
}

std::string FreeWorld::result(const Walked& walked) const {
  const std::vector<tasks::ContinuousResult> one{std::get<tasks::ContinuousResult>(walked)};
  return Json::parse(tasks::to_json(one, *world_.episodes, setup_->benchmark->results_form)).dump();
}

std::string FreeWorld::results(std::span<const std::string> entries) const {
  if (setup_->benchmark->results_form == tasks::ContinuousResultsForm::kRxr) {
    return joined(entries, "", "\n", "\n");
  }
  // Each is an object with its episode's id as the only name; the file is one object of them all.
  std::vector<std::string> inner;
  for (const std::string& one : entries) inner.push_back(one.substr(1, one.size() - 2));
  return joined(inner, "{\n", ",\n", "\n}\n");
}

Limits usual_limits(std::string_view task) {
  Limits limits;
  const tasks::Benchmark& benchmark = tasks::benchmark(task);
  if (!benchmark.continuous()) return limits;
  const auto actions = agents::continuous_setup(benchmark).simulator.most_steps;
  limits.steps = static_cast<std::uint32_t>((actions + kMostMoves - 1) / kMostMoves);
  return limits;
}

}  // namespace enfilade::arena
