#include "enfilade/agents/pilot.h"

#include <fmt/format.h>
#include <algorithm>

#include "enfilade/core/errors.h"

namespace enfilade::agents {
namespace {

constexpr std::uint64_t kPilotSeed = 1;  // as RunOptions::seed

void check_slots(const char* name, std::size_t found, std::size_t wanted) {
  if (found == wanted) return;
  throw ArgumentError(fmt::format("{}: {} elements for {} agents", name, found, wanted));
}

}  // namespace

Pilot::Pilot(Agent& agent, const tasks::EpisodeSet& episodes, ActionSpace actions,
             std::size_t max_actions)
    : agent_(agent), episodes_(episodes), actions_(actions), max_actions_(max_actions) {}

void Pilot::begin(std::span<const std::size_t> episodes) {
  const std::size_t n = episodes.size();
  sim::SimulatorConfig config = sim::SimulatorConfig::room_to_room();
  config.batch_size = n;
  auto batch = std::make_unique<EpisodeBatch>(episodes_, config);
  batch->begin(episodes);
  batch_ = std::move(batch);
  taken_ = 0;
  slots_.assign(n, {});
  rngs_.clear();
  observations_.resize(n);
  decisions_.assign(n, {});
  for (std::size_t i = 0; i < n; ++i) {
    const std::string& id = batch_->episode(i).instruction_id;
    rngs_.emplace_back(kPilotSeed, stream_of(id.data(), id.size()));
    slots_[i].at = batch_->state().viewpoint[i];
    slots_[i].visited.insert(slots_[i].at);
    observations_[i] = batch_->observation(i);
    observations_[i].rng = &rngs_[i];
  }
  agent_.start(observations_);
}

void Pilot::stop(std::size_t slot) {
  slots_[slot].moves.push_back(
      {true, batch_->state().viewpoint[slot], SixAction::kStop, slots_[slot].answer});
  batch_->end(slot);
}

// What a decision has led to, if it is a move in the action space.
void Pilot::note(std::size_t i, const Decision& decision, ViewpointIndex before) {
  Slot& slot = slots_[i];
  const ViewpointIndex now = batch_->state().viewpoint[i];
  if (actions_ == ActionSpace::kSixActions) {
    slot.moves.push_back({false, now, six_action_of(decision), slot.answer});
  } else if (now != before) {
    const bool fresh = slot.visited.insert(now).second;
    if (fresh || actions_ != ActionSpace::kMap) {
      slot.moves.push_back({false, now, SixAction::kForward, slot.answer});
    }
  }
}

// One small step of all.
void Pilot::step() {
  const std::size_t n = slots_.size();
  if (taken_ == max_actions_) {
    for (std::size_t i = 0; i < n; ++i) {
      if (!batch_->ended(i)) stop(i);
    }
    return;
  }
  for (std::size_t i = 0; i < n; ++i) {
    observations_[i] = batch_->observation(i);
    observations_[i].rng = &rngs_[i];
  }
  agent_.act(observations_, decisions_);
  ++taken_;
  std::vector<sim::Action> actions(n);
  std::vector<ViewpointIndex> before(n);
  for (std::size_t i = 0; i < n; ++i) {
    before[i] = batch_->state().viewpoint[i];
    if (batch_->ended(i)) continue;
    const Decision& d = decisions_[i];
    if (d.answer) slots_[i].answer = d.answer;
    if (d.stop) stop(i);
    if (!d.stop) actions[i] = {d.index, d.heading_change, d.elevation_change};
  }
  if (batch_->running() == 0) return;
  batch_->step(actions);
  for (std::size_t i = 0; i < n; ++i) {
    if (!batch_->ended(i)) note(i, decisions_[i], before[i]);
  }
}

void Pilot::next(std::span<const ViewpointIndex> here, std::span<const std::uint8_t> asked,
                 std::span<PilotMove> moves) {
  const std::size_t n = slots_.size();
  check_slots("viewpoints", here.size(), n);
  check_slots("agents that are asked", asked.size(), n);
  check_slots("moves", moves.size(), n);
  const auto wanted = [&](std::size_t i) { return asked[i] != 0 && !slots_[i].over; };
  for (std::size_t i = 0; i < n; ++i) {
    if (!wanted(i) || here[i] == slots_[i].at) continue;
    const graph::NavGraph& graph = batch_->graph(i);
    throw ArgumentError(fmt::format(
        "agent {} stands at viewpoint {}, but the last action of {} led to {}: take its actions", i,
        graph.id(here[i]), agent_.name(), graph.id(slots_[i].at)));
  }
  const auto waits = [&](std::size_t i) {
    return wanted(i) && slots_[i].moves.empty() && !batch_->ended(i);
  };
  const auto any_waits = [&] {
    for (std::size_t i = 0; i < n; ++i) {
      if (waits(i)) return true;
    }
    return false;
  };
  while (any_waits()) step();
  for (std::size_t i = 0; i < n; ++i) {
    moves[i] = {true, here[i], SixAction::kStop, {}};
    Slot& slot = slots_[i];
    if (!wanted(i)) continue;
    moves[i] = std::move(slot.moves.front());
    slot.moves.pop_front();
    slot.at = moves[i].to;
    slot.over = moves[i].stop;
    if (slot.over && actions_ == ActionSpace::kMap) moves[i].to = here[i];
  }
}

}  // namespace enfilade::agents
