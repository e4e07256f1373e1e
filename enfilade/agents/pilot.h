/// \file  An agent at the controls of somebody else's environment.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "enfilade/agents/agent.h"
#include "enfilade/agents/batch_environment.h"
#include "enfilade/agents/episode_batch.h"
#include "enfilade/agents/six_actions.h"
#include "enfilade/core/rng.h"

namespace enfilade::agents {

/// What an agent does next, in the words of an action space.
struct PilotMove {
  bool stop = true;
  /// Where it goes: a neighbour; of kMap the next viewpoint that it has not visited, through
  /// visited ones. Where it is, if it stops or turns.
  ViewpointIndex to;
  SixAction action = SixAction::kStop;  ///< of kSixActions
  std::optional<Answer> answer = {};    ///< the last one that it gave
  friend bool operator==(const PilotMove&, const PilotMove&) = default;
};

/// Lets an Agent, which turns and walks in the simulator's room_to_room() configuration, choose in
/// any of the action spaces of BatchEnvironment, wherever that runs: each slot has its twin in a
/// simulator of the pilot's own, and next() says what the agent has done there. One thread at a
/// time.
class Pilot {
 public:
  /// `agent` and `episodes` have to outlive *this. \param max_actions of the agent, after which an
  /// episode is stopped
  Pilot(Agent& agent, const tasks::EpisodeSet& episodes, ActionSpace actions,
        std::size_t max_actions = 1000);

  /// New episodes, one a slot. \param episodes indices into EpisodeSet::episodes
  /// \throws as EpisodeBatch::begin(), and errors of the agent
  void begin(std::span<const std::size_t> episodes);
  std::size_t size() const noexcept { return slots_.size(); }  ///< slots; 0 before begin()

  /// The next move of each slot that `asked` marks with a number other than 0; of others and of
  /// ended episodes `moves` is a stop. What was asked for has to happen: `here`, where the slots
  /// stand in the environment, is compared with where the agent has gone.
  /// \throws ArgumentError for spans of other lengths, or a slot that stands elsewhere
  void next(std::span<const ViewpointIndex> here, std::span<const std::uint8_t> asked,
            std::span<PilotMove> moves);

 private:
  struct Slot {
    std::deque<PilotMove> moves;  // that were not asked for yet
    ViewpointIndex at;            // where the environment should be
    bool over = false;            // its stop was asked for
    std::set<ViewpointIndex> visited;
    std::optional<Answer> answer;
  };
  void step();
  void note(std::size_t slot, const Decision& decision, ViewpointIndex before);
  void stop(std::size_t slot);

  Agent& agent_;
  const tasks::EpisodeSet& episodes_;
  ActionSpace actions_;
  std::size_t max_actions_, taken_ = 0;
  std::unique_ptr<EpisodeBatch> batch_;
  std::vector<Slot> slots_;
  std::vector<Rng> rngs_;
  std::vector<Observation> observations_;
  std::vector<Decision> decisions_;
};

}  // namespace enfilade::agents
