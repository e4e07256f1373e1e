#include "enfilade/agents/continuous_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::agents {

using continuous::Action;
using continuous::Buildings;
using continuous::EpisodeState;
using continuous::Simulator;

namespace {

// The place of each episode's building, or a fault.
std::vector<std::size_t> find_buildings(const tasks::ContinuousEpisodes& episodes,
                                        const Buildings& buildings) {
  std::vector<std::size_t> found;
  for (const tasks::ContinuousEpisode& e : episodes.episodes) {
    found.push_back(buildings.at(e.scan()));
  }
  return found;
}

// The episodes of one split in the slots of one simulator.
class Runner {
 public:
  Runner(ContinuousAgent& agent, const tasks::ContinuousEpisodes& episodes,
         std::shared_ptr<const Buildings> buildings, const ContinuousRunOptions& options)
      : agent_(agent),
        episodes_(episodes),
        buildings_(std::move(buildings)),
        options_(options),
        places_(find_buildings(episodes, *buildings_)),
        slots_(std::min(options.batch_size, episodes.episodes.size())) {
    check_starts(episodes, *buildings_, options.simulator.start_reach);
    results_.resize(episodes.episodes.size());
    order_.resize(results_.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::ranges::stable_sort(order_, {}, [this](std::size_t e) { return places_[e]; });
  }

  std::vector<tasks::ContinuousResult> run(const Progress& progress) {
    continuous::SimulatorConfig config = options_.simulator;
    config.batch_size = std::max<std::size_t>(slots_.size(), 1);
    Simulator simulator(buildings_, config);
    seen_.resize(slots_.size());
    std::vector<Action> actions(slots_.size(), Action::kStop);
    for (std::size_t s = 0; s < slots_.size(); ++s) begin_next(simulator, s);
    while (done_ < results_.size()) {
      agent_.act(seen_, actions);
      simulator.step(actions);
      for (std::size_t s = 0; s < slots_.size(); ++s) {
        if (slots_[s].ended) continue;
        record(simulator, s, actions[s]);
        if (simulator.state().episode[s] == EpisodeState::kWalking) continue;
        ++done_;
        if (progress) progress(done_, results_.size());
        begin_next(simulator, s);
      }
    }
    return std::move(results_);
  }

 private:
  struct Slot {
    std::size_t episode = 0;
    bool ended = true;
    Rng rng{0};
  };

  void begin_next(Simulator& simulator, std::size_t s) {
    Slot& slot = slots_[s];
    slot.ended = next_ == results_.size();
    seen_[s].ended = slot.ended;
    if (slot.ended) return;
    slot.episode = order_[next_++];
    const tasks::ContinuousEpisode& episode = episodes_.episodes[slot.episode];
    const std::string id = tasks::text_of(episode.id);
    slot.rng = Rng(options_.seed, stream_of(id.data(), id.size()));
    simulator.new_episode(s, start_of(episode, places_[slot.episode]));
    tasks::ContinuousResult& result = results_[slot.episode];
    result.episode = slot.episode;
    add_pose(simulator, s, result);
    look(simulator, s);
    agent_.start(s, seen_[s], simulator.config());
  }

  void record(const Simulator& simulator, std::size_t s, Action action) {
    tasks::ContinuousResult& result = results_[slots_[s].episode];
    result.actions.push_back(static_cast<std::uint8_t>(action));
    result.collided.push_back(simulator.state().collided[s]);
    add_pose(simulator, s, result);
    look(simulator, s);
  }

  static void add_pose(const Simulator& simulator, std::size_t s, tasks::ContinuousResult& result) {
    result.positions.push_back(simulator.state().position[s]);
    result.headings.emplace_back(simulator.state().heading[s]);
  }

  void look(const Simulator& simulator, std::size_t s) {
    const continuous::StateSpans state = simulator.state();
    Slot& slot = slots_[s];
    seen_[s] = {.episode = &episodes_.episodes[slot.episode],
                .buildings = buildings_.get(),
                .building = state.building[s],
                .pose = {state.position[s], Radians(state.heading[s]), Radians(state.elevation[s])},
                .floor = simulator.floor_point(s),
                .collided = state.collided[s] != 0,
                .step = state.steps[s],
                .rng = &slot.rng,
                .ended = false};
  }

  ContinuousAgent& agent_;
  const tasks::ContinuousEpisodes& episodes_;
  std::shared_ptr<const Buildings> buildings_;
  const ContinuousRunOptions& options_;
  std::vector<std::size_t> places_;  // buildings by episode
  std::vector<std::size_t> order_;   // building by building, for agents that have to load them
  std::vector<Slot> slots_;
  std::vector<ContinuousObservation> seen_;  // by slot
  std::vector<tasks::ContinuousResult> results_;
  std::size_t next_ = 0, done_ = 0;
};

void require_goals(const tasks::ContinuousEpisodes& episodes, std::string_view who) {
  for (const tasks::ContinuousEpisode& e : episodes.episodes) {
    if (e.goal_hidden()) {
      throw ArgumentError(fmt::format("{}: episode {} of {} hides its goal, which is needed", who,
                                      tasks::text_of(e.id), episodes.file));
    }
  }
}

}  // namespace

continuous::EpisodeStart start_of(const tasks::ContinuousEpisode& episode, std::size_t building) {
  return {.building = building,
          .pose = {to_float(episode.start), episode.start_heading(), Radians(0)}};
}

void check_starts(const tasks::ContinuousEpisodes& episodes, const Buildings& buildings,
                  const continuous::Reach& reach) {
  const std::vector<std::size_t> places = find_buildings(episodes, buildings);
  std::vector<Diagnostic> faults;
  for (std::size_t e = 0; e < episodes.episodes.size(); ++e) {
    const tasks::ContinuousEpisode& episode = episodes.episodes[e];
    const Vec3f p = to_float(episode.start);
    if (buildings.floor(places[e]).nearest(p, reach)) continue;
    if (faults.size() == kMostFaultsKept) break;
    const Vec3d start = episode.start;
    faults.push_back(
        {Severity::kError, episodes.file, fmt::format("$.episodes[{}].start_position", e),
         "start-off-floor",
         fmt::format("no floor of {} within {} m of ({}, {}, {}), z up, and {} m above "
                     "or below",
                     episode.scan(), reach.aside, start.x + 0, start.y + 0, start.z + 0,
                     reach.above_below)});
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

void check_goals(const tasks::ContinuousEpisodes& episodes, const Buildings& buildings,
                 std::span<const std::size_t> which) {
  std::vector<Diagnostic> faults;
  for (const std::size_t e : which) {
    const tasks::ContinuousEpisode& episode = episodes.episodes.at(e);
    if (episode.goal_hidden()) continue;
    const continuous::Floor& floor = buildings.floor(buildings.at(episode.scan()));
    const bool any = std::ranges::any_of(*episode.goals, [&](const tasks::ContinuousGoal& goal) {
      return floor.nearest(to_float(goal.position), {1, 1}).has_value();
    });
    if (any) continue;
    if (faults.size() == kMostFaultsKept) break;
    faults.push_back({Severity::kError, episodes.file, fmt::format("$.episodes[{}].goals", e),
                      "goal-off-floor",
                      fmt::format("no floor of {} within 1 m of any goal", episode.scan())});
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

continuous::DistanceField goal_field(const tasks::ContinuousEpisode& episode,
                                     const continuous::Floor& floor) {
  std::vector<continuous::FloorPoint> goals;
  for (const tasks::ContinuousGoal& goal : *episode.goals) {
    if (const auto found = floor.nearest(to_float(goal.position), {1, 1})) {
      goals.push_back(*found);
    }
  }
  if (goals.empty()) {
    throw ArgumentError(fmt::format("episode {}: no floor of {} within 1 m of its goal",
                                    tasks::text_of(episode.id), episode.scan()));
  }
  return floor.field(goals);
}

std::vector<tasks::ContinuousResult> run_continuous(ContinuousAgent& agent,
                                                    const tasks::ContinuousEpisodes& episodes,
                                                    std::shared_ptr<const Buildings> buildings,
                                                    const ContinuousRunOptions& options,
                                                    const Progress& progress) {
  if (options.batch_size == 0) throw ArgumentError("batch_size: 0, at least 1");
  if (!buildings) throw ArgumentError("buildings: null");
  if (agent.needs_goal()) require_goals(episodes, agent.name());
  return Runner(agent, episodes, std::move(buildings), options).run(progress);
}

tasks::ExpertWalks record_experts(const tasks::ContinuousEpisodes& episodes,
                                  std::shared_ptr<const Buildings> buildings,
                                  const ContinuousRunOptions& options, const Progress& progress) {
  const std::unique_ptr<ContinuousAgent> expert = make_continuous_agent("reference");
  const auto walks = run_continuous(*expert, episodes, std::move(buildings), options, progress);
  tasks::ExpertWalks experts;
  for (const tasks::ContinuousResult& walk : walks) {
    tasks::ExpertWalk& made = experts[tasks::text_of(episodes.episodes[walk.episode].id)];
    made.actions = walk.actions;
    made.locations.push_back(to_double(walk.positions.front()));
    for (std::size_t k = 0; k < walk.actions.size(); ++k) {
      if (walk.actions[k] != static_cast<std::uint8_t>(Action::kForward)) continue;
      ++made.forward_steps;
      made.locations.push_back(to_double(walk.positions[k + 1]));
    }
  }
  return experts;
}

std::vector<double> goal_distances(const tasks::ContinuousResult& walk,
                                   const tasks::ContinuousEpisode& episode,
                                   const Buildings& buildings) {
  const continuous::Floor& floor = buildings.floor(buildings.at(episode.scan()));
  const continuous::DistanceField field = goal_field(episode, floor);
  std::vector<double> distances;
  for (std::size_t k = 0; k < walk.positions.size(); ++k) {
    if (k > 0 && walk.positions[k] == walk.positions[k - 1]) {
      distances.push_back(distances.back());
      continue;
    }
    const auto at = floor.nearest(walk.positions[k], {1, 1});
    distances.push_back(at ? field.distance(*at) : std::numeric_limits<double>::infinity());
  }
  return distances;
}

namespace {

// What nDTW compares with: an expert's walk, the reference path, or the way from start to goal.
std::vector<tasks::Point3> reference_of(const tasks::ContinuousEpisode& episode,
                                        const tasks::ExpertWalks& experts) {
  const auto expert = experts.find(tasks::text_of(episode.id));
  std::vector<Vec3d> reference;
  if (expert != experts.end()) {
    reference = expert->second.locations;
  } else if (episode.reference_path) {
    reference = *episode.reference_path;
  } else {
    reference = {episode.start, episode.goals->front().position};
  }
  return tasks::reference_to_score(reference);
}

void check_can_be_scored(std::span<const tasks::ContinuousResult> walks,
                         const tasks::ContinuousEpisodes& episodes, const Buildings& buildings) {
  require_goals(episodes, "score");
  std::vector<std::size_t> walked;
  for (const tasks::ContinuousResult& walk : walks) walked.push_back(walk.episode);
  check_goals(episodes, buildings, walked);
}

}  // namespace

tasks::ScoreTable compute_score(std::span<const tasks::ContinuousResult> walks,
                                const tasks::ContinuousEpisodes& episodes,
                                const Buildings& buildings, const tasks::ExpertWalks& experts,
                                const tasks::Benchmark& benchmark, const tasks::Scorer& scorer,
                                const Progress& progress) {
  check_can_be_scored(walks, episodes, buildings);
  const std::size_t width = scorer.metrics.size();
  std::vector<double> values(walks.size() * width);
  for (std::size_t k = 0; k < walks.size(); ++k) {
    const tasks::ContinuousEpisode& episode = episodes.episodes.at(walks[k].episode);
    const tasks::ScoredWalk scored =
        tasks::to_score(walks[k], goal_distances(walks[k], episode, buildings));
    scorer.on_floor(scored.view(), reference_of(episode, experts),
                    std::span(values).subspan(k * width, width));
    if (progress) progress(k + 1, walks.size());
  }
  tasks::ScoreTable table =
      tasks::make_score_table(benchmark, scorer, walks, episodes, std::move(values));
  table.floor = buildings.floor_name();
  return table;
}

tasks::ContinuousScore score_continuous_walk(const tasks::ContinuousResult& walk,
                                             const tasks::ContinuousEpisode& episode,
                                             const Buildings& buildings,
                                             const tasks::ExpertWalks& experts) {
  const tasks::ScoredWalk scored = tasks::to_score(walk, goal_distances(walk, episode, buildings));
  return tasks::score_continuous(scored.view(), reference_of(episode, experts));
}

std::vector<tasks::ContinuousScore> score_continuous_walks(
    std::span<const tasks::ContinuousResult> walks, const tasks::ContinuousEpisodes& episodes,
    const Buildings& buildings, const tasks::ExpertWalks& experts, const Progress& progress) {
  check_can_be_scored(walks, episodes, buildings);
  std::vector<tasks::ContinuousScore> scores;
  for (const tasks::ContinuousResult& walk : walks) {
    scores.push_back(
        score_continuous_walk(walk, episodes.episodes.at(walk.episode), buildings, experts));
    if (progress) progress(scores.size(), walks.size());
  }
  return scores;
}

}  // namespace enfilade::agents
