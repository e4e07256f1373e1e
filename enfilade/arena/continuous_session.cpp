#include <fmt/format.h>
#include <algorithm>
#include <span>
#include <utility>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/arena/detail/texts.h"
#include "enfilade/arena/world.h"

namespace enfilade::arena {
namespace {

using continuous::Action;

constexpr std::size_t kMovesWithoutLooks = 3;  // of R2R-CE; RxR-CE has all

continuous::SimulatorConfig one_walker(continuous::SimulatorConfig config) {
  config.batch_size = 1;
  config.threads = 1;
  return config;
}

std::string times(int n) { return n == 1 ? "once" : fmt::format("{} times", n); }

/// The tools of every step. \param looks whether the camera turns up and down
std::vector<ToolUse> continuous_tools(bool looks) {
  ToolUse move{Tool::kMove, "actions", {}, true};
  const auto moves = std::span(detail::kMoves).subspan(1);
  const auto allowed = moves.first(looks ? moves.size() : kMovesWithoutLooks);
  move.allowed.assign(allowed.begin(), allowed.end());
  return {std::move(move), {Tool::kStop, {}, {}}};
}

bool has_looks(const tasks::Benchmark& benchmark) {
  return benchmark.form == tasks::ContinuousForm::kRxr;
}

class ContinuousSession : public Session {
 public:
  ContinuousSession(const FloorWorld& world, const agents::ContinuousSetup& setup,
                    std::size_t episode, const SessionLimits& limits, Words* words)
      : Session(limits),
        episodes_(world.episodes().continuous()),
        words_(words),
        looks_(has_looks(*setup.benchmark)),
        eye_height_(setup.simulator.eye_height),
        episode_(episode),
        simulator_(world.buildings(), one_walker(setup.simulator)) {
    walk_.episode = episode;
    simulator_.new_episode(
        0, agents::start_of(episode_of(), world.buildings()->at(episode_of().scan())));
    record();
    begin();
  }

  Walked walked() const override { return walk_; }
  std::size_t episode() const override { return episode_; }
  std::string episode_id() const override { return tasks::text_of(episode_of().id); }
  Standpoint standpoint() const override {
    const continuous::StateSpans now = simulator_.state();
    const Vec3d eye = to_double(now.position[0]) + Vec3d{0, 0, eye_height_};
    return {std::string(episode_of().scan()),
            fmt::format("{:.6f}/{:.6f}/{:.6f}", eye.x, eye.y, eye.z), eye, Radians(now.heading[0]),
            Radians(now.elevation[0])};
  }

 protected:
  void carry_out(Tool tool, const std::vector<std::string>& values) override {
    if (tool == Tool::kStop) {
      step(Action::kStop);
      tell("You stopped.");
      return end(Ending::kStopped);
    }
    int collisions = 0;
    double metres = 0;
    std::size_t done = 0;
    for (const std::string& name : values) {
      const Vec3f before = simulator_.state().position[0];
      step(static_cast<Action>(std::ranges::find(detail::kMoves, name) - detail::kMoves.begin()));
      metres += length(simulator_.state().position[0] - before);
      collisions += simulator_.state().collided[0];
      ++done;
      if (simulator_.state().episode[0] != continuous::EpisodeState::kWalking) break;
    }
    tell(fmt::format(
        "You did {} of {} actions and walked {:.2f} m{}.", done, values.size(), metres,
        collisions == 0 ? "" : fmt::format("; a wall was in the way {}", times(collisions))));
    if (simulator_.state().episode[0] != continuous::EpisodeState::kWalking) {
      end(Ending::kOutOfSteps);
    }
  }

  void look_around(SessionObservation& seen) override {
    seen.instruction = episode_of().instruction.text;
    seen.heading = Radians(simulator_.state().heading[0]);
    seen.elevation = Radians(simulator_.state().elevation[0]);
    if (words_ != nullptr) seen.what = words_->of(standpoint());
    if (seen.tools.empty()) seen.tools = continuous_tools(looks_);
  }

 private:
  const tasks::ContinuousEpisode& episode_of() const { return episodes_->episodes[episode_]; }

  void step(Action action) {
    simulator_.step({&action, 1});
    walk_.actions.push_back(static_cast<std::uint8_t>(action));
    walk_.collided.push_back(simulator_.state().collided[0]);
    record();
  }
  void record() {
    walk_.positions.push_back(simulator_.state().position[0]);
    walk_.headings.emplace_back(simulator_.state().heading[0]);
  }

  std::shared_ptr<const tasks::ContinuousEpisodes> episodes_;
  Words* words_;  // null: none
  bool looks_;
  double eye_height_;
  std::size_t episode_;
  continuous::Simulator simulator_;
  tasks::ContinuousResult walk_;
};

}  // namespace

std::vector<ToolUse> FloorWorld::tools() const {
  return continuous_tools(has_looks(episodes().benchmark()));
}

std::unique_ptr<Session> FloorWorld::start(std::size_t episode, const SessionLimits& limits) {
  check(episode, limits);
  return std::make_unique<ContinuousSession>(
      *this, agents::continuous_setup(episodes().benchmark()), episode, limits, words());
}

}  // namespace enfilade::arena
