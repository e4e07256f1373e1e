/// \file  Episodes stepped over requests: the sessions of the arena, stored in the database. Runs
/// of the arena shown step by step: folders that `enfilade ask`, `enfilade mcp` and Python's arena
/// have written.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "enfilade/arena/pictures.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/wire.h"
#include "enfilade/arena/world.h"
#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/site.h"

namespace enfilade::service::store {
class Database;
}

namespace enfilade::service::sessions {

/// The requested episode.
struct NewSession {
  std::string task = "r2r";  ///< a benchmark's name, also of continuous space: "r2r-ce"
  std::string split;
  std::string episode;  ///< an instruction's id: "12_0"; of continuous space an episode's: "12"
  std::optional<std::uint32_t> steps = {}, mistakes = {};  ///< none: arena::usual_limits()
};

/// A session's number in addresses, and the secret of the client that began it.
struct Ticket {
  std::int64_t id = 0;
  std::string key;
};

/// One call, as it came.
struct NewCall {
  arena::Reading reading;
  /// Number of calls that the client has had responses to; no value: not checked. Another number
  /// than the session's is refused. So a call that is sent again after a broken connection is not
  /// performed twice.
  std::optional<std::int64_t> after = {};
};

/// The graph episodes of a split's annotations, or of a part of them.
std::unique_ptr<arena::GraphWorld> graph_world(const std::shared_ptr<const Site>& site,
                                               const tasks::Annotations& annotations,
                                               tasks::Instructions which);

/// All sessions of a server. The database has their calls. A session that is not in memory is
/// replayed from its calls, which gives the same observations, to the bit. So a killed server loses
/// nothing. All functions may be called from any thread; those of one session wait for each other.
///
/// No function gives away anything that a split hides: a session has no goal.
class Sessions {
 public:
  static constexpr std::int64_t kKeptSeconds = 30L * 24 * 3600;  ///< after the last call

  /// \param db outlives *this
  Sessions(std::shared_ptr<const Site> site, store::Database& db);
  ~Sessions();
  Sessions(const Sessions&) = delete;
  Sessions& operator=(const Sessions&) = delete;

  /// Begins a session, and drops those without a call for kKeptSeconds.
  /// \throws Refusal kNotFound for an unknown split or episode, kInvalidInput for limits out of
  /// range and tasks without sessions
  Ticket begin(const NewSession& wanted);
  /// {"session", "task", "split", "episode", "calls", "mistakes", "ending", "observation"};
  /// `ending` is null while it goes on.
  /// \throws Refusal kNotFound for an unknown session, or another client's
  nlohmann::ordered_json state(const Ticket& ticket);
  /// Carries out a call; adds "carried_out" to state(). \throws Refusal as state(), kConflict if it
  /// is over or NewCall::after is another number
  nlohmann::ordered_json call(const Ticket& ticket, const NewCall& wanted);
  /// Picture `number` from 0, JPEG.
  /// \throws Refusal as state(); kNotFound for an unknown number, or in continuous environments
  /// \throws ArgumentError for another size; as arena::PictureMaker
  std::string picture(const Ticket& ticket, arena::PictureKind kind, std::size_t number,
                      std::uint32_t size);
  /// The trajectory, in the benchmark's form of results: a list of one.
  /// \throws Refusal as state(), kConflict while it goes on
  std::string result(const Ticket& ticket);

 private:
  struct Shared;
  struct Live;
  struct Painters;
  using WorldKey = std::pair<std::string, std::string>;  // task, split

  std::shared_ptr<Shared> world_of(const WorldKey& key);
  std::unique_ptr<arena::World> open_world(const WorldKey& key) const;
  std::shared_ptr<Live> find(const Ticket& ticket);
  void open(Live& live) const;
  nlohmann::ordered_json state_of(const Live& live) const;
  template <class Use>
  auto with(const Ticket& ticket, const Use& use);

  std::shared_ptr<const Site> site_;
  store::Database& db_;
  std::unique_ptr<Painters> painters_;
  detail::OnceCache<WorldKey, std::shared_ptr<Shared>> worlds_;
  std::mutex mutex_;  // of live_
  std::map<std::int64_t, std::shared_ptr<Live>> live_;
};

/// The runs in a folder, read anew at each request, as they may still be written. All functions may
/// be called from any thread.
///
/// Only the model's input and output in a transcript are served, no other fields of a line. If
/// goals are hidden, an episode is served only if its id and its instruction are those of the
/// site's split. If a phase keeps goals secret, runs of splits that the site does not have are not
/// served. Names in requests are compared with those in folders, and never made into paths; links
/// inside a run are not followed.
class Replays {
 public:
  static constexpr std::size_t kMostRuns = 1000;                ///< that are listed
  static constexpr std::uintmax_t kMostBytes = 16ULL << 20ULL;  ///< of a transcript
  static constexpr std::size_t kMostLines = 10'000;             ///< of a transcript

  /// \param folder holds the folders of runs, or is one; empty: there are no runs
  /// \throws FileError if it is no folder
  Replays(std::shared_ptr<const Site> site, const std::filesystem::path& folder);

  /// {"runs": [{"run", "task", "split", "model", "prompt", "episodes", "problem"?}]}, by name;
  /// unknown values of a run are null.
  /// \param episode only runs that have it; empty: all
  nlohmann::ordered_json runs(std::string_view episode) const;
  /// As an entry of runs(), with "list": [{"episode", "ending", "steps", "mistakes"}, or
  /// {"episode", "problem"}].
  /// \throws Refusal kNotFound for an unknown run
  nlohmann::ordered_json run(std::string_view name, std::size_t offset, std::size_t limit) const;
  /// {"run", "task", "split", "model", "prompt", "episode", "instruction", "scan", "steps", "end",
  /// "place_problem"?}. A step has "observation", "call", "told", and optionally "text",
  /// "prompt_tokens", "answer_tokens" and "at". `at` is found by replaying the calls. It is left
  /// out from the first step on at which the replay differs; place_problem reports that.
  /// \throws Refusal kNotFound for an unknown run or episode; kInvalidInput for a transcript that
  /// cannot be read, naming file and line
  nlohmann::ordered_json episode(std::string_view run, std::string_view episode) const;

 private:
  struct Run;
  Run find(std::string_view name) const;

  std::shared_ptr<const Site> site_;
  std::filesystem::path folder_;
};

}  // namespace enfilade::service::sessions
