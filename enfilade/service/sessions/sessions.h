/// \file  Episodes stepped over requests: the sessions of the arena, stored in the database.
#pragma once
#include <cstddef>
#include <cstdint>
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
#include "enfilade/service/sessions/painters.h"
#include "enfilade/service/site.h"

namespace enfilade::service::store {
class Database;
}

namespace enfilade::service::sessions {

/// The requested episode.
struct NewSession {
  std::string task = "r2r";  ///< a benchmark's name, also of continuous space: "r2r-ce"
  std::string split;
  /// An instruction's id: "12_0"; of continuous space an episode's: "12". Empty: any of the split.
  std::string episode = {};
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
/// No function gives away anything that a split hides: a session has no goal, and outcome() refuses
/// splits with hidden ones.
class Sessions {
 public:
  static constexpr std::int64_t kKeptSeconds = 30L * 24 * 3600;  ///< after the last call

  /// \param db outlives *this \param painters not null
  Sessions(std::shared_ptr<const Site> site, store::Database& db,
           std::shared_ptr<Painters> painters);
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
  /// outcome_json() of the trajectory (outcome.h).
  /// \throws Refusal as state(), kConflict while it goes on; kNotFound if the split has a hidden
  /// goal, and in continuous environments
  nlohmann::ordered_json outcome(const Ticket& ticket);

 private:
  struct Shared;
  struct Live;
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
  std::shared_ptr<Painters> painters_;
  detail::OnceCache<WorldKey, std::shared_ptr<Shared>> worlds_;
  std::mutex mutex_;  // of live_
  std::map<std::int64_t, std::shared_ptr<Live>> live_;
};

}  // namespace enfilade::service::sessions
