#include "enfilade/agents/run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <optional>
#include <utility>

#include "enfilade/agents/random.h"
#include "enfilade/agents/shortest.h"
#include "enfilade/core/errors.h"

namespace enfilade::agents {
namespace {

using r2r::Episode;
using r2r::EpisodeSet;
using r2r::Trajectory;

// Runs the episodes [first, first + count) in one simulator, to the end of the last.
class BatchRun {
 public:
  BatchRun(Agent& agent, const EpisodeSet& episodes, const RunOptions& options, std::size_t first,
           std::size_t count)
      : agent_(agent),
        episodes_(episodes),
        options_(options),
        first_(first),
        simulator_(episodes.graphs, batch_config(options, count)),
        buffer_(count, options.simulator.max_navigable),
        state_(buffer_.spans()),
        observations_(count),
        decisions_(count),
        actions_(count),
        trajectories_(count) {}

  std::vector<Trajectory> run() {
    begin();
    for (std::size_t actions = 0; actions < options_.max_actions && running_ > 0; ++actions) {
      observe();
      agent_.act(observations_, decisions_);
      apply();
    }
    return std::move(trajectories_);
  }

 private:
  static sim::SimulatorConfig batch_config(const RunOptions& options, std::size_t count) {
    sim::SimulatorConfig config = options.simulator;
    config.batch_size = count;
    config.seed = options.seed;
    return config;
  }

  const Episode& episode(std::size_t slot) const { return episodes_.episodes[first_ + slot]; }

  void begin() {
    std::vector<sim::EpisodeStart> starts;
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      const Episode& e = episode(i);
      const r2r::ReferencePath& path = episodes_.path_of(e);
      starts.push_back({{path.scan, path.viewpoints.front()}, path.heading, Radians(0)});
      rngs_.emplace_back(options_.seed,
                         stream_of(e.instruction_id.data(), e.instruction_id.size()));
    }
    simulator_.new_episodes(starts, state_);
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      trajectories_[i].episode = first_ + i;
      record(i);
      Observation& seen = observations_[i];
      seen.episode = &episode(i);
      seen.graph = &episodes_.graph_of(episode(i));
      seen.reference = episodes_.path_of(episode(i)).viewpoints;
      seen.rng = &rngs_[i];
    }
    running_ = observations_.size();
    observe();
    agent_.start(observations_);
  }

  void observe() {
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      Observation& seen = observations_[i];
      seen.viewpoint = state_.viewpoint[i];
      seen.heading = Radians(state_.heading[i]);
      seen.elevation = Radians(state_.elevation[i]);
      seen.view_index = state_.view_index[i];
      seen.step = state_.step[i];
      const std::size_t row = i * buffer_.max_navigable();
      const std::size_t n = state_.navigable_count[i];
      seen.navigable = {state_.navigable_viewpoint.subspan(row, n),
                        state_.navigable_rel_heading.subspan(row, n),
                        state_.navigable_rel_elevation.subspan(row, n),
                        state_.navigable_distance.subspan(row, n)};
    }
  }

  // Ended episodes stay where they are: the simulator steps the whole batch.
  void apply() {
    for (std::size_t i = 0; i < decisions_.size(); ++i) {
      Observation& seen = observations_[i];
      if (!seen.ended && decisions_[i].stop) {
        seen.ended = true;
        --running_;
      }
      const Decision& d = decisions_[i];
      actions_[i] =
          seen.ended ? sim::Action{} : sim::Action{d.index, d.heading_change, d.elevation_change};
    }
    if (running_ == 0) return;
    simulator_.step(actions_, state_);
    for (std::size_t i = 0; i < decisions_.size(); ++i) {
      if (!observations_[i].ended) record(i);
    }
  }

  void record(std::size_t slot) {
    trajectories_[slot].points.push_back(
        {state_.viewpoint[slot], Radians(state_.heading[slot]), Radians(state_.elevation[slot])});
  }

  Agent& agent_;
  const EpisodeSet& episodes_;
  const RunOptions& options_;
  std::size_t first_;
  std::size_t running_ = 0;
  sim::Simulator simulator_;
  sim::StateBuffer buffer_;
  sim::StateSpans state_;
  std::vector<Rng> rngs_;
  std::vector<Observation> observations_;
  std::vector<Decision> decisions_;
  std::vector<sim::Action> actions_;
  std::vector<Trajectory> trajectories_;
};

void require_goals(const Agent& agent, const EpisodeSet& episodes) {
  for (const r2r::ReferencePath& path : episodes.paths) {
    if (path.viewpoints.size() > 1) continue;
    throw ArgumentError(fmt::format("agent {} needs the goal, which split {} hides (path {})",
                                    agent.name(), episodes.split, path.path_id));
  }
}

}  // namespace

std::vector<Trajectory> run_agent(Agent& agent, const EpisodeSet& episodes,
                                  const RunOptions& options, const Progress& progress) {
  if (options.batch_size == 0) throw ArgumentError("batch size 0: at least 1 is needed");
  if (agent.needs_goal()) require_goals(agent, episodes);
  const std::size_t total = episodes.episodes.size();
  std::vector<Trajectory> all;
  all.reserve(total);
  for (std::size_t first = 0; first < total; first += options.batch_size) {
    const std::size_t count = std::min(options.batch_size, total - first);
    for (Trajectory& one : BatchRun(agent, episodes, options, first, count).run()) {
      all.push_back(std::move(one));
    }
    if (progress) progress(all.size(), total);
  }
  return all;
}

std::unique_ptr<Agent> make_agent(std::string_view name) {
  if (name == "random") return std::make_unique<RandomAgent>();
  if (name == "shortest") return std::make_unique<ShortestAgent>();
  throw LookupError(fmt::format("agent {:?}: there is none of that name; there are: {}", name,
                                fmt::join(agent_names(), ", ")));
}

std::vector<std::string> agent_names() { return {"random", "shortest"}; }

}  // namespace enfilade::agents
