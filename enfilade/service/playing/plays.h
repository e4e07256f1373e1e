/// \file  Episodes walked over requests: the sessions of the arena, kept in the database.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>

#include "enfilade/arena/pictures.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/wire.h"
#include "enfilade/arena/world.h"
#include "enfilade/service/detail/kept.h"
#include "enfilade/service/site.h"

namespace enfilade::service::store {
class Database;
}

namespace enfilade::service::playing {

/// What somebody wants to walk.
struct NewPlay {
  std::string task = "r2r";  ///< a benchmark's name, also of continuous space: "r2r-ce"
  std::string split;
  std::string episode;  ///< an instruction's id: "12_0"; of continuous space an episode's: "12"
  std::optional<std::uint32_t> steps = {}, mistakes = {};  ///< none: arena::usual_limits()
};

/// Who walks: the number in addresses, and the secret that only who has begun it knows.
struct Ticket {
  std::int64_t id = 0;
  std::string key;
};

/// One call, as it came.
struct NewCall {
  arena::Reading reading;
  /// How many calls the caller has had answers to; another number than the play's is refused, so
  /// that a call which is sent again after a broken connection is not carried out twice. None: not
  /// checked.
  std::optional<std::int64_t> after = {};
};

/// All plays of a server. The database has what was called; a play that is not in memory is walked
/// again from its calls, which gives the same observations, to the bit. So a server that is killed
/// loses nothing. All functions may be called from any thread; of one play they wait for each
/// other.
///
/// Nothing that a split hides is ever told: a session knows no goal.
class Plays {
 public:
  static constexpr std::int64_t kKeptSeconds = 30L * 24 * 3600;  ///< after the last call

  /// \param db outlives *this
  Plays(std::shared_ptr<const Site> site, store::Database& db);
  ~Plays();
  Plays(const Plays&) = delete;
  Plays& operator=(const Plays&) = delete;

  /// Begins a play, and forgets those that nobody has called for kKeptSeconds.
  /// \throws Refusal kNotFound for a split or an episode that there is not, kInvalidInput for
  /// limits out of range and tasks that cannot be played
  Ticket begin(const NewPlay& wanted);
  /// {"session", "task", "split", "episode", "calls", "mistakes", "ending", "observation"};
  /// `ending` is null while it goes on. \throws Refusal kNotFound for a play that there is not, or
  /// another's
  nlohmann::ordered_json state(const Ticket& ticket);
  /// Carries out a call; adds "carried_out" to state(). \throws Refusal as state(), kConflict if it
  /// is over or NewCall::after is another number
  nlohmann::ordered_json call(const Ticket& ticket, const NewCall& wanted);
  /// Picture `number` from 0, JPEG. \throws Refusal as state(), kNotFound for a number that there
  /// is not, or in continuous space; ArgumentError for another size; as arena::Painter
  std::string picture(const Ticket& ticket, arena::Pictures kind, std::size_t number,
                      std::uint32_t size);
  /// What was walked, in the benchmark's form of results: a list of one.
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
  detail::Kept<WorldKey, std::shared_ptr<Shared>> worlds_;
  std::mutex mutex_;  // of live_
  std::map<std::int64_t, std::shared_ptr<Live>> live_;
};

}  // namespace enfilade::service::playing
