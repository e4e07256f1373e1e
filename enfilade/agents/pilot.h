/// \file  Runs an Agent inside a BatchEnvironment.
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

/// An agent's next move, for any action space.
struct PilotMove {
  bool stop = true;
  /// Target: a neighbour; for kMap the next viewpoint that it has not visited, through visited
  /// ones. Its own viewpoint, if it stops or turns.
  ViewpointIndex to;
  SixAction action = SixAction::kStop;  ///< of kSixActions
  std::optional<Answer> answer = {};    ///< the last one that it gave
  friend bool operator==(const PilotMove&, const PilotMove&) = default;
};

/// Lets an Agent choose in any of the action spaces of BatchEnvironment, in any process. The Agent
/// turns and moves in the simulator's room_to_room() configuration. Each slot has a twin in a
/// simulator of the pilot's own, and next() returns the agent's moves there. One thread at a time.
class Pilot {
 public:
  /// `agent` and `episodes` have to outlive *this. \param max_actions of the agent, after which an
  /// episode is stopped
  Pilot(Agent& agent, const tasks::EpisodeSet& episodes, ActionSpace actions,
        std::size_t max_actions = 1000);

  /// New episodes, one per slot. \param episodes indices into EpisodeSet::episodes
  /// \throws as EpisodeBatch::begin(), and errors of the agent
  void begin(std::span<const std::size_t> episodes);
  std::size_t size() const noexcept { return slots_.size(); }  ///< slots; 0 before begin()

  /// The next move of each slot that `asked` marks with a number other than 0; a stop for others
  /// and for ended episodes. Returned moves must be made: `here`, the slots' viewpoints in the
  /// environment, is compared with the agent's.
  /// \throws ArgumentError for spans of other lengths, or a slot that is elsewhere
  void next(std::span<const ViewpointIndex> here, std::span<const std::uint8_t> asked,
            std::span<PilotMove> moves);

 private:
  struct Slot {
    std::deque<PilotMove> moves;  // not returned yet
    ViewpointIndex at;            // where the environment should be
    bool over = false;            // its stop was returned
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
