#include "enfilade/arena/world.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::arena {

World::World(tasks::Split split, WordsSource words)
    : split_(std::move(split)), words_source_(std::move(words)) {
  if (split_.size() == 0) throw ArgumentError("episodes: none");
  auto by_id = std::make_shared<std::map<std::string, std::size_t, std::less<>>>();
  for (std::size_t e = 0; e < size(); ++e) by_id->emplace(split_.id(e), e);
  by_id_ = std::move(by_id);
}

World::World(const World& other)
    : split_(other.split_), by_id_(other.by_id_), words_source_(other.words_source_) {}

std::optional<std::size_t> World::find(std::string_view id) const {
  const auto found = by_id_->find(id);
  return found == by_id_->end() ? std::nullopt : std::optional(found->second);
}

void World::check(std::size_t episode, const SessionLimits& limits) const {
  validate(limits);
  if (episode < size()) return;
  throw ArgumentError(fmt::format("episode: {}; there are {}", episode, size()));
}

Words* World::words() {
  if (words_source_ && !words_) words_ = words_source_();
  return words_.get();
}

std::string World::result(const Walked& walked) const {
  const tasks::Trajectories one = std::visit(
      [](const auto& trajectory) { return tasks::Trajectories(std::vector{trajectory}); }, walked);
  const auto file = nlohmann::ordered_json::parse(tasks::to_json(one, split_));
  return (file.is_array() ? file[0] : file).dump();
}

std::string World::results(std::span<const std::string> entries) const {
  const tasks::Benchmark& benchmark = split_.benchmark();
  if (!benchmark.continuous()) return fmt::format("[\n{}\n]\n", fmt::join(entries, ",\n"));
  if (benchmark.form == tasks::ContinuousForm::kRxr) {
    return fmt::format("{}\n", fmt::join(entries, "\n"));
  }
  // Each is an object with its episode's id as the only name; the file is one object of them all.
  std::vector<std::string> inner;
  for (const std::string& one : entries) inner.push_back(one.substr(1, one.size() - 2));
  return fmt::format("{{\n{}\n}}\n", fmt::join(inner, ",\n"));
}

GraphWorld::GraphWorld(std::shared_ptr<const tasks::EpisodeSet> episodes, WordsSource words)
    : World(tasks::Split(std::move(episodes)), std::move(words)),
      panoramas_(World::episodes().on_graph()->graphs) {}

GraphWorld::GraphWorld(const GraphWorld& other)
    : World(other), panoramas_(episodes().on_graph()->graphs) {}

const std::string& GraphWorld::words_of(const Standpoint& from) {
  static const std::string kNone;
  Words* const words = World::words();
  if (words == nullptr) return kNone;
  const std::string key = fmt::format("{}/{}/{:.4f}/{:.4f}", from.scan, from.place,
                                      to_degrees(from.heading), to_degrees(from.elevation));
  const auto [at, is_new] = known_words_.try_emplace(key);
  if (is_new) at->second = words->of(from);
  return at->second;
}

std::unique_ptr<World> GraphWorld::another() const {
  return std::unique_ptr<World>(new GraphWorld(*this));
}

FloorWorld::FloorWorld(tasks::Split split, std::shared_ptr<const continuous::Buildings> buildings,
                       WordsSource words)
    : World(std::move(split), std::move(words)), buildings_(std::move(buildings)) {
  if (!buildings_) throw ArgumentError("world: no buildings");
}

FloorWorld::FloorWorld(const tasks::Split& split, const std::filesystem::path& data,
                       WordsSource words)
    : FloorWorld(split, agents::open_buildings(split.benchmark(), data), std::move(words)) {}

std::unique_ptr<World> FloorWorld::another() const {
  return std::unique_ptr<World>(new FloorWorld(*this));
}

SessionLimits usual_limits(std::string_view task) {
  SessionLimits limits;
  const tasks::Benchmark& benchmark = tasks::benchmark(task);
  if (!benchmark.continuous()) return limits;
  const auto actions = agents::continuous_setup(benchmark).simulator.most_steps;
  limits.steps = static_cast<std::uint32_t>((actions + kMostMoves - 1) / kMostMoves);
  return limits;
}

std::vector<std::size_t> spread_subset(const World& world, std::size_t count) {
  const std::size_t all = world.size();
  if (count == 0 || count > all) {
    throw ArgumentError(
        fmt::format("subset of {} episodes: split {} has {}", count, world.split(), all));
  }
  std::vector<std::size_t> order(all);
  std::iota(order.begin(), order.end(), 0U);
  std::vector<std::tuple<std::string, std::size_t, double, std::string>> keys;
  for (std::size_t e = 0; e < all; ++e) {
    tasks::PathSize size = world.episodes().path_size(e);
    keys.emplace_back(std::move(size.scan), size.places, size.length, world.episodes().id(e));
  }
  std::ranges::sort(order, {}, [&keys](std::size_t e) -> const auto& { return keys[e]; });
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(order[(2 * k + 1) * all / (2 * count)]);
  std::ranges::sort(chosen);
  return chosen;
}

std::vector<std::size_t> listed_subset(const World& world, const std::filesystem::path& file) {
  const std::string text = read_plain_text(file);
  std::set<std::size_t> chosen;
  std::vector<Diagnostic> faults;
  for (const auto& [number, id] : list_lines(text)) {
    if (faults.size() >= kMostFaultsKept) break;
    const auto refuse = [&](const char* code, const char* what) {
      faults.push_back({Severity::kError, file.string(), fmt::format("line {}", number), code,
                        fmt::format("{:?} {}", id.substr(0, 60), what)});
    };
    const auto found = world.find(id);
    if (!found) {
      refuse("unknown-episode", "is no episode of the split");
    } else if (!chosen.insert(*found).second) {
      refuse("repeated-episode", "is there twice");
    }
  }
  if (faults.empty() && chosen.empty()) {
    faults.push_back({Severity::kError, file.string(), "", "no-episode", "no id in it"});
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return {chosen.begin(), chosen.end()};
}

std::vector<std::size_t> subset_named(const World& world, const std::string& subset) {
  constexpr std::size_t kUsual = 100, kDigits = 8;
  const std::size_t all = world.size();
  if (subset.empty()) return spread_subset(world, std::min(kUsual, all));
  if (subset == "all") {
    std::vector<std::size_t> which(all);
    std::iota(which.begin(), which.end(), 0U);
    return which;
  }
  const bool number = subset.find_first_not_of("0123456789") == std::string::npos;
  if (number && subset.size() < kDigits) return spread_subset(world, std::stoul(subset));
  return listed_subset(world, subset);
}

double chance_of(std::size_t count) { return 1.96 * std::sqrt(0.25 / static_cast<double>(count)); }

}  // namespace enfilade::arena
