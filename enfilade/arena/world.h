/// \file  The episodes of a split for sessions, in either world. Parts of a split, for evaluations
/// in which each step costs money.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/agents/continuous_setup.h"
#include "enfilade/agents/panorama.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/words.h"
#include "enfilade/tasks/split.h"

namespace enfilade::arena {

/// Rules that step through a session without a model: answers of a mock server, and baselines.
enum class Rule : std::uint8_t {
  kFirst,   ///< always to the first place, and never stops; in continuous space forward
  kRandom,  ///< as the agent "random" of the same seed, step by step
  kOracle,  ///< the shortest way to the goal; of REVERIE it names the object, of R2R-Back the turn
  kStop,    ///< stops at once
};
constexpr std::array<std::string_view, 4> names_of(Rule /*enum*/) {
  return {"first", "random", "oracle", "stop"};
}
/// \throws LookupError listing the names
Rule rule_named(std::string_view name);

/// Follows a rule through one session, which outlives it: gives the next call.
/// \pre the session has not ended, and did all that was said before
using Follower = std::function<Call()>;

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

  const tasks::Split& episodes() const noexcept { return split_; }
  std::string_view task() const noexcept { return split_.benchmark().name; }  ///< "r2r", "r2r-ce"
  const std::string& split() const noexcept { return split_.name(); }
  std::size_t size() const noexcept { return split_.size(); }
  /// Index of an episode's id; of ids that are there twice, the first. None: there is no such id.
  std::optional<std::size_t> find(std::string_view id) const;

  /// All tools of its sessions, also those that are impossible at some steps, in the order of Tool.
  /// ToolUse::allowed has the values that are the same at every step; it is empty for others.
  virtual std::vector<ToolUse> tools() const = 0;

  /// Begins an episode.
  /// \throws ArgumentError if `episode >= size()`, for limits out of range, and for SOON, whose
  /// answers no tool can give
  /// \throws LookupError (continuous) for a missing building
  /// \throws ActionError (continuous) for a start off the floor; errors of files
  virtual std::unique_ptr<Session> start(std::size_t episode, const SessionLimits& limits = {}) = 0;
  /// A rule that steps through a session at its start. \param seed for Rule::kRandom
  /// \param session outlives it \pre it is of this world
  /// \throws ArgumentError for Rule::kOracle where the goal is hidden
  virtual Follower follow(Rule rule, const Session& session, std::uint64_t seed = 1) const = 0;

  /// The entry of one trajectory in the benchmark's results files, JSON.
  /// \pre it is of a session of this world
  std::string result(const Walked& walked) const;
  /// A whole results file of such entries.
  std::string results(std::span<const std::string> entries) const;

 protected:
  /// \throws ArgumentError for no episode
  explicit World(tasks::Split split, WordsSource words);
  World(const World& other);  ///< Words are of one thread
  /// What says how a view looks; null without words.
  Words* words();
  /// \throws ArgumentError for limits out of range, or episode >= size()
  void check(std::size_t episode, const SessionLimits& limits) const;

 private:
  tasks::Split split_;
  std::shared_ptr<const std::map<std::string, std::size_t, std::less<>>> by_id_;
  WordsSource words_source_;
  std::unique_ptr<Words> words_;
};

/// On graphs.
class GraphWorld : public World {
 public:
  /// \param words  for Neighbour::what; empty: none \throws ArgumentError for null or no episode
  explicit GraphWorld(std::shared_ptr<const tasks::EpisodeSet> episodes, WordsSource words = {});
  agents::PanoramaCache& panoramas() noexcept { return panoramas_; }
  /// Description of the view there; empty without words. \throws as Words::of()
  const std::string& words_of(const Standpoint& from);
  /// As start(), with what only sessions on graphs have.
  std::unique_ptr<GraphSession> start_on_graph(std::size_t episode,
                                               const SessionLimits& limits = {});

  std::unique_ptr<World> another() const override;
  std::vector<ToolUse> tools() const override;
  std::unique_ptr<Session> start(std::size_t episode, const SessionLimits& limits = {}) override {
    return start_on_graph(episode, limits);
  }
  Follower follow(Rule rule, const Session& session, std::uint64_t seed = 1) const override;

 private:
  GraphWorld(const GraphWorld& other);

  agents::PanoramaCache panoramas_;
  std::map<std::string, std::string> known_words_;  // by picture
};

/// On floors, in continuous space. A call is one to four actions.
class FloorWorld : public World {
 public:
  /// \param words  for SessionObservation::what; empty: none
  /// \throws ArgumentError for no episode or null buildings \pre split.benchmark().continuous()
  FloorWorld(tasks::Split split, std::shared_ptr<const continuous::Buildings> buildings,
             WordsSource words = {});
  /// In the buildings of a folder of data. \throws as above; Buildings
  FloorWorld(const tasks::Split& split, const std::filesystem::path& data, WordsSource words = {});
  const std::shared_ptr<const continuous::Buildings>& buildings() const noexcept {
    return buildings_;
  }

  std::unique_ptr<World> another() const override;
  std::vector<ToolUse> tools() const override;
  std::unique_ptr<Session> start(std::size_t episode, const SessionLimits& limits = {}) override;
  Follower follow(Rule rule, const Session& session, std::uint64_t seed = 1) const override;

 private:
  std::shared_ptr<const continuous::Buildings> buildings_;
};

/// Limits that suit a benchmark: those of SessionLimits, and in continuous space as many
/// calls as its actions need. \throws LookupError for an unknown one
SessionLimits usual_limits(std::string_view task);

/// `count` episodes of a split, spread evenly over its buildings and, in each, over the lengths of
/// the paths. In the order of scan, length and instruction id, it takes one from the middle of each
/// of `count` equal parts. No random number is involved, so "216" always means the same subset.
/// \returns indices, ascending
/// \throws ArgumentError for 0 or more than the number of episodes
std::vector<std::size_t> spread_subset(const World& world, std::size_t count);

/// Those of a file with an instruction id a line, in the order of the split.
/// \throws FileError; InvalidInput naming the lines of ids that the split does not have, or that
/// are there twice
std::vector<std::size_t> listed_subset(const World& world, const std::filesystem::path& file);

/// A user's choice: a number as spread_subset(); "all"; empty: 100, or all if there are fewer; else
/// a file as listed_subset().
/// \throws as these
std::vector<std::size_t> subset_named(const World& world, const std::string& subset);

/// Uncertainty of a share of `count` episodes: half of the 95 % interval of a binomial at one half,
/// 1.96 sqrt(1 / 4n). For example 0.067 for 216.
/// \pre count > 0
double chance_of(std::size_t count);

}  // namespace enfilade::arena
