#include <fmt/format.h>
#include <algorithm>
#include <span>
#include <utility>

#include "enfilade/arena/detail/moves.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/errors.h"

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

class OneContinuousSession : public ContinuousSession {
 public:
  OneContinuousSession(const agents::ContinuousWorld& world, const agents::ContinuousSetup& setup,
                       std::size_t episode, const Limits& limits, Words* words)
      : ContinuousSession(limits),
        world_(world),
        words_(words),
        looks_(setup.benchmark->form == tasks::ContinuousForm::kRxr),
        eye_height_(setup.simulator.eye_height),
        episode_(episode),
        simulator_(world.buildings, one_walker(setup.simulator)) {
    walk_.episode = episode;
    simulator_.new_episode(
        0, agents::start_of(episode_of(), world_.buildings->at(episode_of().scan())));
    record();
    begin();
  }

  continuous::Pose pose() const override {
    const continuous::StateSpans now = simulator_.state();
    return {now.position[0], Radians(now.heading[0]), Radians(now.elevation[0])};
  }
  Walked walked() const override { return walk_; }
  std::size_t episode() const override { return episode_; }
  std::string episode_id() const override { return tasks::text_of(episode_of().id); }
  Standpoint standpoint() const override {
    const continuous::Pose now = pose();
    const Vec3d eye = to_double(now.position) + Vec3d{0, 0, eye_height_};
    return {std::string(episode_of().scan()),
            fmt::format("{:.6f}/{:.6f}/{:.6f}", eye.x, eye.y, eye.z), eye, now.heading,
            now.elevation};
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
      step(std::ranges::find(detail::kMoves, name, &detail::Move::name)->action);
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

  void look_around(Observation& seen) override {
    seen.instruction = episode_of().instruction.text;
    seen.heading = Radians(simulator_.state().heading[0]);
    seen.elevation = Radians(simulator_.state().elevation[0]);
    if (words_ != nullptr) seen.what = words_->of(standpoint());
    if (!seen.tools.empty()) return;
    ToolUse move{Tool::kMove, "actions", {}, true};
    const std::size_t count = looks_ ? detail::kMoves.size() : kMovesWithoutLooks;
    for (const detail::Move& one : std::span(detail::kMoves).first(count))
      move.allowed.emplace_back(one.name);
    seen.tools.push_back(std::move(move));
    seen.tools.push_back({Tool::kStop, {}, {}});
  }

 private:
  const tasks::ContinuousEpisode& episode_of() const { return world_.episodes->episodes[episode_]; }

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

  agents::ContinuousWorld world_;
  Words* words_;  // null: none
  bool looks_;
  double eye_height_;
  std::size_t episode_;
  continuous::Simulator simulator_;
  tasks::ContinuousResult walk_;
};

}  // namespace

std::unique_ptr<ContinuousSession> FreeWorld::start_free(std::size_t episode,
                                                         const Limits& limits) {
  validate(limits);
  if (episode >= size()) {
    throw ArgumentError(fmt::format("episode: {}; there are {}", episode, size()));
  }
  if (words_source_ && !words_) words_ = words_source_();
  return std::make_unique<OneContinuousSession>(world_, *setup_, episode, limits, words_.get());
}

}  // namespace enfilade::arena
