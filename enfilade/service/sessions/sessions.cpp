#include "enfilade/service/sessions/sessions.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/core/rng.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/sessions/outcome.h"
#include "enfilade/service/store/database.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/results.h"

namespace enfilade::service::sessions {
namespace {

using detail::Reason;
using detail::Refusal;
using nlohmann::ordered_json;

constexpr std::size_t kMostLive = 4096;  // sessions in memory, some kilobytes each
constexpr std::size_t kMostWorlds = 64;  // splits: more than all benchmarks have

struct SessionRow {
  std::string hash, task, split, episode;
  std::uint32_t steps = 0, mistakes = 0;

  auto columns() { return std::tie(hash, task, split, episode, steps, mistakes); }
};

struct CallRow {
  std::string tool, argument, fault;  // either a tool or a fault

  auto columns() { return std::tie(tool, argument, fault); }
};

tasks::Task task_of(const std::string& name) {
  try {
    return tasks::benchmark(name, tasks::WorldKind::kGraph).task;
  } catch (const LookupError& error) {
    throw Refusal(Reason::kInvalidInput, fmt::format("task: {}", error.what()));
  }
}

/// The id of any episode; each is as likely as another.
std::string any_episode(const arena::World& world) {
  Rng rng(std::random_device{}());
  return world.episodes().id(rng.below(world.size()));
}

void carry_out(arena::Session& session, const CallRow& call) {
  if (call.fault.empty()) {
    session.call({call.tool, call.argument});
  } else {
    session.misread(call.fault);
  }
}

}  // namespace

std::unique_ptr<arena::GraphWorld> graph_world(const std::shared_ptr<const Site>& site,
                                               const tasks::Annotations& annotations,
                                               tasks::Instructions which) {
  const tasks::ObjectBoxes* objects =
      annotations.task == tasks::Task::kReverie ? site->objects() : nullptr;
  auto episodes = std::make_shared<tasks::EpisodeSet>(
      tasks::make_episodes(annotations, site->shared_graphs(), which, objects));
  // The site has them for as long as it lives.
  if (objects != nullptr) episodes->objects = {site, objects};
  return std::make_unique<arena::GraphWorld>(std::move(episodes));
}

// Episodes of one split, as everybody may see them; one thread at a time for all sessions, as they
// share what they look up.
struct Sessions::Shared {
  explicit Shared(std::unique_ptr<arena::World> opened) : world(std::move(opened)) {}

  std::mutex mutex;
  std::unique_ptr<arena::World> world;
};

// A session in memory, or one that is still to be replayed.
struct Sessions::Live {
  std::mutex mutex;
  std::int64_t id = 0;
  SessionRow row;
  std::shared_ptr<Shared> shared;
  std::unique_ptr<arena::Session> session;  // null: walk the calls again
  std::int64_t calls = 0;
};

Sessions::Sessions(std::shared_ptr<const Site> site, store::Database& db,
                   std::shared_ptr<Painters> painters)
    : site_(std::move(site)),
      db_(db),
      painters_(std::move(painters)),
      worlds_(kMostWorlds, [](const std::shared_ptr<Shared>&) { return std::size_t{1}; }) {}
Sessions::~Sessions() = default;

std::shared_ptr<Sessions::Shared> Sessions::world_of(const WorldKey& key) {
  return worlds_.get(key, [&] { return std::make_shared<Shared>(open_world(key)); });
}

std::unique_ptr<arena::World> Sessions::open_world(const WorldKey& key) const {
  const auto& [task, name] = key;
  const Refusal unknown(Reason::kNotFound,
                        fmt::format("there is no split {:.40} of {}", name, task));
  if (const auto* benchmark = tasks::find_benchmark(task); benchmark && benchmark->continuous()) {
    if (!detail::is_name(name)) throw unknown;  // the name becomes a file's
    const dataset::Dataset data(site_->folder());
    if (!data.has_split(*benchmark, name)) throw unknown;
    return std::make_unique<arena::FloorWorld>(data.split(*benchmark, name, {.experts = false}),
                                               site_->folder());
  }
  const tasks::Task known = task_of(task);
  const PublicSplit* split = site_->find_split(name, known);
  if (split == nullptr) throw unknown;
  if (split->annotations.paths.empty()) {  // a file of annotations may be an empty list
    throw Refusal(Reason::kNotFound, fmt::format("split {} of {} has no episode", name, task));
  }
  return graph_world(site_, split->annotations, tasks::Instructions::kScored);
}

Ticket Sessions::begin(const NewSession& wanted) {
  const std::shared_ptr<Shared> shared = world_of({wanted.task, wanted.split});
  arena::SessionLimits limits = arena::usual_limits(wanted.task);
  limits.steps = wanted.steps.value_or(limits.steps);
  limits.mistakes = wanted.mistakes.value_or(limits.mistakes);
  auto live = std::make_shared<Live>();
  Ticket ticket;
  ticket.key = detail::new_secret("play_");
  live->row = {detail::sha256(ticket.key),
               wanted.task,
               wanted.split,
               wanted.episode.empty() ? any_episode(*shared->world) : wanted.episode,
               limits.steps,
               limits.mistakes};
  live->shared = shared;
  try {
    const std::scoped_lock lock(shared->mutex);
    if (const auto episode = shared->world->find(live->row.episode)) {
      live->session = shared->world->start(*episode, limits);
    }
  } catch (const ArgumentError& error) {  // limits, or a start off the floor
    throw Refusal(Reason::kInvalidInput, error.what());
  }
  if (live->session == nullptr) {
    throw Refusal(Reason::kNotFound, fmt::format("split {} of {} has no episode {:.40?}",
                                                 wanted.split, wanted.task, wanted.episode));
  }
  int forgotten = 0;
  ticket.id = live->id = db_.transact([&] {
    const std::int64_t long_ago = db_.now() - kKeptSeconds;
    db_.run("DELETE FROM play_call WHERE play IN (SELECT id FROM play WHERE touched < ?)",
            long_ago);
    forgotten = db_.run("DELETE FROM play WHERE touched < ?", long_ago);
    return db_.insert(
        "INSERT INTO play (hash, task, split, episode, steps, mistakes, touched) "
        "VALUES (?, ?, ?, ?, ?, ?, ?)",
        live->row.hash, live->row.task, live->row.split, live->row.episode, live->row.steps,
        live->row.mistakes, db_.now());
  });
  const std::scoped_lock lock(mutex_);
  if (live_.size() >= kMostLive || forgotten > 0) {
    // Unused ones; those in the database are replayed at their next request.
    std::erase_if(live_, [](const auto& one) { return one.second.use_count() == 1; });
  }
  live_.emplace(live->id, std::move(live));
  return ticket;
}

std::shared_ptr<Sessions::Live> Sessions::find(const Ticket& ticket) {
  const std::string hash = detail::sha256(ticket.key);
  const auto own = [&](const std::shared_ptr<Live>& live) {
    // One answer for what there is not and what is another's: numbers can be guessed.
    if (live == nullptr || live->row.hash != hash) {
      throw Refusal(Reason::kNotFound, "there is no such session, or the key is another's");
    }
    return live;
  };
  {
    const std::scoped_lock lock(mutex_);
    const auto found = live_.find(ticket.id);
    if (found != live_.end()) return own(found->second);
  }
  const auto row = db_.find<SessionRow>(
      "SELECT hash, task, split, episode, steps, mistakes FROM play WHERE id = ?", ticket.id);
  if (!row) return own(nullptr);
  auto live = std::make_shared<Live>();
  live->id = ticket.id;
  live->row = *row;
  own(live);
  live->shared = world_of({row->task, row->split});
  const std::scoped_lock lock(mutex_);
  return live_.try_emplace(ticket.id, std::move(live)).first->second;
}

// Walks what is kept and was not walked here: all of it, or what came to another server.
// \pre the caller has live.mutex
void Sessions::open(Live& live) const {
  if (live.session == nullptr) live.calls = 0;
  const auto calls = db_.select<CallRow>(
      "SELECT tool, argument, fault FROM play_call WHERE play = ? AND number >= ? ORDER BY number",
      live.id, live.calls);
  if (live.session != nullptr && calls.empty()) return;
  const std::scoped_lock lock(live.shared->mutex);
  auto session = std::move(live.session);  // gone, if a call cannot be walked
  if (session == nullptr) {
    const auto episode = live.shared->world->find(live.row.episode);
    if (!episode) {
      throw Refusal(Reason::kNotFound, "the data set has changed: the session's episode is gone");
    }
    session = live.shared->world->start(*episode, {live.row.steps, live.row.mistakes});
  }
  for (const CallRow& call : calls) carry_out(*session, call);
  live.session = std::move(session);
  live.calls += std::ssize(calls);
}

template <class Use>
auto Sessions::with(const Ticket& ticket, const Use& use) {
  const std::shared_ptr<Live> live = find(ticket);
  const std::scoped_lock lock(live->mutex);
  open(*live);
  return use(*live);
}

ordered_json Sessions::state_of(const Live& live) const {
  const arena::Session& session = *live.session;
  ordered_json out{{"session", live.id},      {"task", live.row.task},
                   {"split", live.row.split}, {"episode", live.row.episode},
                   {"calls", live.calls},     {"mistakes", session.mistakes()},
                   {"ending", nullptr}};
  if (const auto ending = session.ending()) out["ending"] = arena::name_of(*ending);
  out["observation"] = ordered_json::parse(to_json(session.observation()));
  return out;
}

ordered_json Sessions::state(const Ticket& ticket) {
  return with(ticket, [this](const Live& live) { return state_of(live); });
}

ordered_json Sessions::call(const Ticket& ticket, const NewCall& wanted) {
  return with(ticket, [&](Live& live) {
    if (wanted.after && *wanted.after != live.calls) {
      throw Refusal(Reason::kConflict, fmt::format("after: {}, but the session has had {} calls",
                                                   *wanted.after, live.calls));
    }
    if (live.session->ending()) throw Refusal(Reason::kConflict, "the session is over");
    CallRow call;
    if (wanted.reading.call) {
      call = {wanted.reading.call->tool, wanted.reading.call->argument, ""};
    } else {
      call.fault = wanted.reading.fault;
    }
    // First the stored call, then its consequences: after a crash in between it is replayed.
    db_.transact([&] {
      if (db_.run("UPDATE play SET touched = ? WHERE id = ?", db_.now(), live.id) == 0) {
        throw Refusal(Reason::kNotFound, "the session has expired: no call for too long");
      }
      const int kept = db_.run(
          "INSERT INTO play_call (play, number, tool, argument, fault) VALUES (?, ?, ?, ?, ?) "
          "ON CONFLICT DO NOTHING",
          live.id, live.calls, call.tool, call.argument, call.fault);
      if (kept == 0) {
        throw Refusal(Reason::kConflict, "another call of the session came to another server");
      }
    });
    const std::uint32_t before = live.session->mistakes();
    try {
      const std::scoped_lock lock(live.shared->mutex);
      carry_out(*live.session, call);
    } catch (...) {
      live.session.reset();  // the call is kept, so it is to be walked again
      throw;
    }
    ++live.calls;
    ordered_json out{{"carried_out", live.session->mistakes() == before}};
    out.update(state_of(live));
    return out;
  });
}

std::string Sessions::picture(const Ticket& ticket, arena::PictureKind kind, std::size_t number,
                              std::uint32_t size) {
  const auto order = with(ticket, [&](const Live& live) -> std::optional<arena::PictureOrder> {
    const bool on_graph = live.shared->world->episodes().on_graph() != nullptr;
    if (!on_graph || live.session->ending()) return std::nullopt;
    const auto all = order_pictures(*live.session, kind, size);
    if (number >= all.size()) return std::nullopt;
    return all[number];
  });
  if (!order) throw Refusal(Reason::kNotFound, "there is no such picture now");
  return painters_->draw(*order);
}

std::string Sessions::result(const Ticket& ticket) {
  return with(ticket, [](const Live& live) {
    if (!live.session->ending()) {
      throw Refusal(Reason::kConflict, "the session goes on: it has no result yet");
    }
    const arena::World& world = *live.shared->world;
    return world.results(std::vector{world.result(live.session->walked())});
  });
}

ordered_json Sessions::outcome(const Ticket& ticket) {
  return with(ticket, [](const Live& live) {
    const tasks::Split& split = live.shared->world->episodes();
    if (split.on_graph() == nullptr) {
      throw Refusal(Reason::kNotFound, "sessions in continuous environments have no outcome");
    }
    if (split.goals_hidden()) {
      throw Refusal(Reason::kNotFound, fmt::format("split {} of {} has hidden goals: no outcome",
                                                   live.row.split, live.row.task));
    }
    if (!live.session->ending()) {
      throw Refusal(Reason::kConflict, "the session goes on: it has no outcome yet");
    }
    return outcome_json(*split.on_graph(), std::get<tasks::Trajectory>(live.session->walked()));
  });
}

}  // namespace enfilade::service::sessions
