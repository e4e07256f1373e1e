/// \file  Continuous episodes as a reinforcement-learning environment: a batch of agents, one
/// action each.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/agents/continuous_run.h"

namespace enfilade::agents {

/// Episodes, buildings and settings. Shared by any number of environments.
struct ContinuousWorld {
  std::shared_ptr<const tasks::ContinuousEpisodes> episodes;
  std::shared_ptr<const tasks::ExpertWalks> experts;  ///< references of nDTW; null: none
  std::shared_ptr<const continuous::Buildings> buildings;
};

/// Which way a teacher leads.
enum class ContinuousExpert : std::uint8_t {
  kReference,  ///< along the reference path, as VLN-CE's experts: the agent "reference"
  kShortest,   ///< the shortest way to the goal: the agent "shortest"
};

/// A batch of agents, each in the episode that begin() gave it. One thread at a time.
class ContinuousEnvironment {
 public:
  /// Looks at the starts and goals of all episodes.
  /// \throws ArgumentError for nulls (experts may be), no episode, or as
  /// continuous::Simulator; what check_starts() and check_goals() throw
  ContinuousEnvironment(ContinuousWorld world, const continuous::SimulatorConfig& config);

  /// Begins episodes. If it throws, nothing has changed.
  /// \param chosen  an index of an episode per agent; below 0: no change
  /// \throws ArgumentError for another length, an index out of range, or if an agent that has never
  /// begun is left out
  void begin(std::span<const std::int64_t> chosen);
  /// One action per agent; those whose episode has ended do not move.
  /// \throws as continuous::Simulator::step()
  void step(std::span<const continuous::Action> actions);

  const ContinuousWorld& world() const noexcept { return world_; }
  const continuous::Simulator& simulator() const noexcept { return simulator_; }
  std::span<const std::uint32_t> episode() const noexcept { return episode_; }  ///< indices, (n)
  /// Geodesic, to the nearest goal, metres, (n); NaN: it is hidden, infinite: there is no way.
  std::span<const double> distance() const noexcept { return distance_; }
  /// The agent's trajectory so far. \pre it has begun
  const tasks::ContinuousResult& walk(std::size_t agent) const;
  /// The next action of a teacher, an oracle; kStop once an episode is over. It follows the agent
  /// from the start, even if its first call comes later. No value if the goal is hidden.
  /// \throws ArgumentError for an agent beyond the batch or that has not begun
  std::optional<continuous::Action> expert(std::size_t agent, ContinuousExpert rule);
  /// VLN-CE's measures of the agent's trajectory so far.
  /// \throws ArgumentError as expert(), and for a hidden goal
  tasks::ContinuousScore score(std::size_t agent) const;

 private:
  // An agent's episode.
  struct Slot {
    bool begun = false;
    std::size_t building = 0;
    std::optional<continuous::DistanceField> field;  // none: the goal is hidden
    tasks::ContinuousResult walk;
    std::optional<continuous::ReferenceFollower> teacher;
    ContinuousExpert rule = ContinuousExpert::kReference;
    std::size_t followed = 0;  // poses of the walk that the teacher has seen
    continuous::Action advice = continuous::Action::kStop;
  };
  void begin_one(std::size_t agent, std::size_t episode);
  void record(std::size_t agent);
  const Slot& slot(std::size_t agent) const;
  const tasks::ContinuousEpisode& episode_of(const Slot& slot) const;
  void make_teacher(Slot& slot, ContinuousExpert rule) const;

  ContinuousWorld world_;
  continuous::Simulator simulator_;
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> episode_;
  std::vector<double> distance_;
};

}  // namespace enfilade::agents
