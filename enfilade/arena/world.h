/// \file  The episodes of a split for sessions, on a graph or in continuous environments.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "enfilade/agents/continuous_environment.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/agents/panorama.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/words.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::arena {

enum class Rule : std::uint8_t;
class Follower;

/// Size of an episode's path, for choosing a part of a split.
struct PathSize {
  std::string scan;
  std::size_t places = 0;  ///< viewpoints, or points of the reference path; hidden goals: the start
  double length = 0;       ///< metres
};

/// Episodes of one split, in order. Outlives its sessions. One thread at a time: they share their
/// caches.
///
///     auto episodes = std::make_shared<const tasks::EpisodeSet>(data.episodes("val_seen"));
///     arena::GraphWorld world(episodes);
///     const auto session = world.start(0);
class World {
 public:
  virtual ~World() = default;
  World& operator=(const World&) = delete;

  /// A copy with the same episodes, for another thread.
  virtual std::unique_ptr<World> another() const = 0;

  virtual std::string_view task() const noexcept = 0;  ///< "r2r", "r2r-ce"
  virtual const std::string& split() const noexcept = 0;
  virtual std::size_t size() const noexcept = 0;
  virtual bool goals_hidden() const noexcept = 0;  ///< of any episode
  /// As Session::episode_id(). \pre episode < size(), here and below
  virtual std::string episode_id(std::size_t episode) const = 0;
  virtual PathSize path_size(std::size_t episode) const = 0;
  /// Index of an episode's id; of ids that are there twice, the first. None: there is no such id.
  std::optional<std::size_t> find(std::string_view id) const;

  /// Begins an episode.
  /// \throws ArgumentError if `episode >= size()`, for limits out of range, and for SOON, whose
  /// answers no tool can give
  /// \throws LookupError (continuous) for a missing building
  /// \throws ActionError (continuous) for a start off the floor; errors of files
  virtual std::unique_ptr<Session> start(std::size_t episode, const Limits& limits = {}) = 0;
  /// A rule that steps through a session at its start (rules.h). \param seed for Rule::kRandom
  /// \param session outlives it \pre it is of this world
  /// \throws ArgumentError for Rule::kOracle where the goal is hidden
  virtual std::unique_ptr<Follower> follow(Rule rule, const Session& session,
                                           std::uint64_t seed = 1) const = 0;

  /// The entry of one trajectory in the benchmark's results files, JSON.
  /// \pre it is of a session of this world
  virtual std::string result(const Walked& walked) const = 0;
  /// A whole results file of such entries.
  virtual std::string results(std::span<const std::string> entries) const = 0;

 protected:
  World() = default;
  World(const World&) = default;
  void index_ids();  ///< for find(), once size() and episode_id() work

 private:
  std::shared_ptr<const std::map<std::string, std::size_t, std::less<>>> by_id_;
};

/// On graphs.
class GraphWorld : public World {
 public:
  /// \param words  for Place::what; empty: none \throws ArgumentError for null or no episode
  explicit GraphWorld(std::shared_ptr<const tasks::EpisodeSet> episodes, WordsSource words = {});
  const tasks::EpisodeSet& episodes() const noexcept { return *episodes_; }
  agents::PanoramaCache& panoramas() noexcept { return panoramas_; }
  /// Description of the view there; empty without words. \throws as Words::of()
  const std::string& words_of(const Standpoint& from);
  /// As start(), with what only sessions on graphs have.
  std::unique_ptr<GraphSession> start_on_graph(std::size_t episode, const Limits& limits = {});

  std::unique_ptr<World> another() const override;
  std::string_view task() const noexcept override;
  const std::string& split() const noexcept override;
  std::size_t size() const noexcept override;
  bool goals_hidden() const noexcept override;
  std::string episode_id(std::size_t episode) const override;
  PathSize path_size(std::size_t episode) const override;
  std::unique_ptr<Session> start(std::size_t episode, const Limits& limits = {}) override;
  std::unique_ptr<Follower> follow(Rule rule, const Session& session,
                                   std::uint64_t seed = 1) const override;
  std::string result(const Walked& walked) const override;
  std::string results(std::span<const std::string> entries) const override;

 private:
  GraphWorld(const GraphWorld& other);

  std::shared_ptr<const tasks::EpisodeSet> episodes_;
  agents::PanoramaCache panoramas_;
  WordsSource words_source_;
  std::unique_ptr<Words> words_;
  std::map<std::string, std::string> known_words_;  // by picture
};

/// In continuous space. A call is one to four actions.
class FreeWorld : public World {
 public:
  /// \param words  for Observation::what; empty: none
  /// \throws ArgumentError for a world without episodes or buildings
  FreeWorld(agents::ContinuousWorld world, const agents::ContinuousSetup& setup,
            WordsSource words = {});
  /// From a split in a folder of data, without the experts' trajectories, which no session needs.
  /// \throws as agents::load_continuous_split(), Buildings
  static std::unique_ptr<FreeWorld> open(const agents::ContinuousSetup& setup,
                                         const std::filesystem::path& data,
                                         const std::string& split, WordsSource words = {});
  const agents::ContinuousWorld& world() const noexcept { return world_; }
  /// As start(), with what only sessions in continuous space have.
  std::unique_ptr<ContinuousSession> start_free(std::size_t episode, const Limits& limits = {});

  std::unique_ptr<World> another() const override;
  std::string_view task() const noexcept override;
  const std::string& split() const noexcept override;
  std::size_t size() const noexcept override;
  bool goals_hidden() const noexcept override;
  std::string episode_id(std::size_t episode) const override;
  PathSize path_size(std::size_t episode) const override;
  std::unique_ptr<Session> start(std::size_t episode, const Limits& limits = {}) override;
  std::unique_ptr<Follower> follow(Rule rule, const Session& session,
                                   std::uint64_t seed = 1) const override;
  std::string result(const Walked& walked) const override;
  std::string results(std::span<const std::string> entries) const override;

 private:
  FreeWorld(const FreeWorld& other);

  agents::ContinuousWorld world_;
  const agents::ContinuousSetup* setup_;
  WordsSource words_source_;
  std::unique_ptr<Words> words_;
};

/// Limits that suit a benchmark: those of Limits, and in continuous space as many calls as its
/// actions need. \throws LookupError for an unknown one
Limits usual_limits(std::string_view task);

}  // namespace enfilade::arena
