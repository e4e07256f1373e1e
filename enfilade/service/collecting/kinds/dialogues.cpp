#include "enfilade/service/collecting/kinds/dialogues.h"

#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::collecting::kinds {
namespace {

using detail::Reason;
using detail::Refusal;
using json::Element;
using json::Faults;
using json::Path;
using nlohmann::ordered_json;

constexpr const char* kFileName = "dialogue";
constexpr std::size_t kLongestMessage = 500;
constexpr std::size_t kMostStepsAtOnce = 100;
constexpr std::int64_t kMostTurns = 5000;

bool is_message(std::string_view text) { return detail::is_prose(text, kLongestMessage); }

std::optional<DialogueRecord> find_dialogue(store::Database& db, std::int64_t task) {
  return db.find<DialogueRecord>(
      "SELECT id, navigator, oracle, finished FROM dialogue WHERE navigator = ?1 OR oracle = ?1",
      task);
}

std::vector<DialogueEntry> turns_of(store::Database& db, std::int64_t dialogue) {
  return db.select<DialogueEntry>(
      "SELECT id, role, text, viewpoint, heading, elevation, at FROM turn WHERE dialogue = ? "
      "ORDER BY id",
      dialogue);
}

/// Who may act now.
DialogueRole turn_of(const std::vector<DialogueEntry>& turns) {
  const auto said = std::ranges::find_if(
      turns.rbegin(), turns.rend(), [](const DialogueEntry& one) { return !one.text.empty(); });
  return said == turns.rend() || said->role == DialogueRole::kOracle ? DialogueRole::kNavigator
                                                                     : DialogueRole::kOracle;
}

/// Where the navigator stands.
DialogueEntry here_of(const WorkItem& item, const std::vector<DialogueEntry>& turns) {
  if (!turns.empty()) return turns.back();
  DialogueEntry start;
  start.viewpoint = item.path.front();
  start.heading = item.heading.value;
  return start;
}

struct Ending {
  double metres = std::numeric_limits<double>::infinity();
  std::vector<std::string> way;  ///< from here, both ends included
};
/// The nearest viewpoint of the item's region.
Ending nearest_end(const WorkItem& item, const std::string& viewpoint,
                   const graph::GraphSet& graphs) {
  const graph::NavGraph& graph = graphs.graph(item.scan);
  const auto from = graph.find(viewpoint);
  EN_CHECK(from);
  Ending best;
  std::optional<ViewpointIndex> nearest;
  for (const std::string& id : item.region) {
    const auto to = graph.find(id);
    if (!to || graph.distance(*from, *to) >= best.metres) continue;
    best.metres = graph.distance(*from, *to);
    nearest = to;
  }
  if (!nearest) return best;
  for (const ViewpointIndex v : graph.path(*from, *nearest).value_or(std::vector{*from})) {
    best.way.push_back(graph.id(v));
  }
  return best;
}

std::vector<std::string> way_shown(std::vector<std::string> way) {
  if (way.size() > kStepsShown + 1) way.resize(kStepsShown + 1);
  return way;
}

ordered_json turn_json(const DialogueEntry& turn) {
  ordered_json out{{"turn", turn.id}, {"role", enum_name(turn.role)}};
  if (!turn.text.empty()) out["text"] = turn.text;
  out["viewpoint"] = turn.viewpoint;
  out["heading"] = turn.heading;
  out["elevation"] = turn.elevation;
  return out;
}

constexpr const char* kLive =
    "EXISTS (SELECT 1 FROM task WHERE task.id = {} AND state = 'leased' AND expires > {})";

bool is_live(store::Database& db, std::optional<std::int64_t> task) {
  return task && db.find_number(
                     "SELECT 1 FROM task WHERE id = ? AND state = 'leased' AND "
                     "expires > ?",
                     *task, db.now()) != 0;
}

/// A task of the visit in a dialogue, with that.
struct Place {
  Assignment task;
  DialogueRecord dialogue;
  DialogueRole role = DialogueRole::kNavigator;
};
Place place_of(store::Database& db, const Visit& visit, std::int64_t id) {
  Place place{own_task(db, visit, id), {}};
  const auto dialogue = find_dialogue(db, id);
  if (!dialogue) {
    if (place.task.kind != WorkKind::kDialogue) {
      throw Refusal(Reason::kNotFound, "the task is no dialogue");
    }
    throw Refusal(Reason::kLeaseExpired, "the lease ended, and another worker has the seat now");
  }
  place.dialogue = *dialogue;
  place.role = dialogue->navigator == id ? DialogueRole::kNavigator : DialogueRole::kOracle;
  return place;
}

void add_turn(store::Database& db, std::int64_t dialogue, const DialogueEntry& turn) {
  db.run(
      "INSERT INTO turn (dialogue, role, text, viewpoint, heading, elevation, at) VALUES (?, ?, ?, "
      "?, ?, ?, ?)",
      dialogue, turn.role, turn.text, turn.viewpoint, turn.heading, turn.elevation, db.now());
}

/// What a body asks for.
struct Act {
  std::string say;
  std::vector<DialogueEntry> steps;
  bool stop = false;
};

DialogueEntry read_step(Element element, const Path& path, Faults& faults) {
  const detail::Fields fields(element, path, faults, {"viewpoint", "heading", "elevation"});
  DialogueEntry step;
  if (!fields.complete()) return step;
  step.viewpoint = fields.string("viewpoint");
  step.heading = fields.number("heading", 0, 2 * std::numbers::pi);
  step.elevation = fields.number("elevation", -std::numbers::pi / 2, std::numbers::pi / 2);
  return step;
}

Act read_act(std::string_view body, DialogueRole role) {
  Act act;
  const auto read = [&](const detail::Fields& fields, Faults& faults) {
    const Path root;
    const int asked =
        (fields.has("say") ? 1 : 0) + (fields.has("steps") ? 1 : 0) + (fields.has("stop") ? 1 : 0);
    if (asked != 1) faults.error(root, "no-act", "one of say, steps and stop is expected");
    if (role == DialogueRole::kOracle && !fields.has("say")) {
      faults.error(root, "no-act", "an oracle only says something");
    }
    if (fields.has("say")) {
      act.say = fields.text("say", is_message,
                            fmt::format("1 to {} printable characters", kLongestMessage));
    }
    if (fields.has("stop")) {
      act.stop = fields.boolean("stop");
      if (!act.stop) faults.error(fields.path("stop"), "no-act", "false, not true");
    }
    if (!fields.has("steps")) return;
    fields.list("steps", kMostStepsAtOnce, " steps", [&](Element one, const Path& path) {
      act.steps.push_back(read_step(one, path, faults));
    });
  };
  detail::read_body(body, kFileName, detail::kFormLimits, {}, {"say", "steps", "stop"}, read);
  return act;
}

/// \throws InvalidInput for a step that the graph does not have
void check_steps(const WorkItem& item, const DialogueEntry& here,
                 const std::vector<DialogueEntry>& steps, const graph::GraphSet& graphs) {
  const graph::NavGraph& graph = graphs.graph(item.scan);
  Faults faults(kFileName);
  const Path root;
  const Path path(root, "steps");
  auto last = graph.find(here.viewpoint);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Path step(path, k);
    const auto to = graph.find(steps[k].viewpoint);
    if (!to || !graph.included(*to)) {
      faults.error(Path(step, "viewpoint"), "unknown-viewpoint",
                   fmt::format("{:?} is no viewpoint of scan {}'s graph",
                               steps[k].viewpoint.substr(0, detail::kQuoted), item.scan));
    } else if (last && *last != *to && graph.edge(*last, *to) == nullptr) {
      faults.error(
          Path(step, "viewpoint"), "not-adjacent",
          fmt::format("no edge leads from {:?} to {:?}", graph.id(*last), steps[k].viewpoint));
    }
    last = to;
  }
  faults.throw_if_errors();
}

std::string content_of(const DialogueRecord& dialogue, const WorkItem& item,
                       const std::vector<DialogueEntry>& turns, std::int64_t begun) {
  ordered_json list = ordered_json::array();
  list.push_back({{"role", "navigator"},
                  {"viewpoint", item.path.front()},
                  {"heading", item.heading.value},
                  {"elevation", 0.0},
                  {"seconds", 0}});
  for (const DialogueEntry& turn : turns) {
    ordered_json one = turn_json(turn);
    one.erase("turn");
    one["seconds"] = std::max<std::int64_t>(turn.at - begun, 0);
    list.push_back(std::move(one));
  }
  return ordered_json{{"dialogue", dialogue.id}, {"turns", std::move(list)}}.dump();
}

/// Both tasks are submitted.
void finish(store::Database& db, const Place& place, const std::vector<DialogueEntry>& turns,
            const graph::GraphSet& graphs) {
  const WorkItem& item = place.task.item;
  const double error = nearest_end(item, here_of(item, turns).viewpoint, graphs).metres;
  // A navigator who took over a free seat came later than the first turns.
  const std::int64_t begun =
      turns.empty() ? place.task.leased : std::min(place.task.leased, turns.front().at);
  const std::string content = content_of(place.dialogue, item, turns, begun);
  for (const auto& task : {place.dialogue.navigator, place.dialogue.oracle}) {
    if (!task) continue;
    db.run(
        "UPDATE task SET state = 'submitted', content = ?2, digest = ?3, seconds = CASE "
        "WHEN ?4 > leased THEN ?4 - leased ELSE 0 END, error = ?5, submitted = ?4, draft = '' "
        "WHERE id = ?1 AND state IN "
        "('leased', 'lapsed')",
        *task, content, detail::sha256(content), db.now(), error);
  }
  db.run("UPDATE dialogue SET finished = ? WHERE id = ?", db.now(), place.dialogue.id);
  update_item(db, place.task);
}

}  // namespace

std::optional<Seat> find_seat(store::Database& db, const Collection& collection,
                              std::int64_t worker) {
  const std::string navigates = fmt::format(fmt::runtime(kLive), "dialogue.navigator", "?3");
  const std::string answers = fmt::format(fmt::runtime(kLive), "dialogue.oracle", "?3");
  return db.find<Seat>(
      fmt::format("SELECT dialogue.id, item, CASE WHEN {0} THEN 'oracle' ELSE 'navigator' END FROM "
                  "dialogue JOIN item ON item.id = item WHERE collection = ?1 AND finished IS NULL "
                  "AND ({0}) <> ({1}) AND NOT EXISTS (SELECT 1 FROM task WHERE task.item = item.id "
                  "AND task.worker = ?2) ORDER BY dialogue.id LIMIT 1",
                  navigates, answers),
      collection.id, worker, db.now());
}

void take_seat(store::Database& db, const std::optional<Seat>& seat, std::int64_t task,
               std::int64_t item) {
  const DialogueRole role = seat ? seat->role : DialogueRole::kNavigator;
  db.run("UPDATE task SET role = ? WHERE id = ?", role, task);
  if (!seat) {
    db.run("INSERT INTO dialogue (item, navigator) VALUES (?, ?)", item, task);
  } else if (role == DialogueRole::kNavigator) {
    db.run("UPDATE dialogue SET navigator = ? WHERE id = ?", task, seat->dialogue);
  } else {
    db.run("UPDATE dialogue SET oracle = ? WHERE id = ?", task, seat->dialogue);
  }
}

bool holds_seat(store::Database& db, std::int64_t task) {
  const auto dialogue = find_dialogue(db, task);
  return dialogue && !dialogue->finished;
}

ordered_json dialogue_json(store::Database& db, const Visit& visit, std::int64_t id,
                           std::int64_t after, const graph::GraphSet& graphs) {
  return db.transact([&] {
    const Place place = place_of(db, visit, id);
    const bool open = place.task.state == AssignmentState::kLeased;
    // One that ran out may have gone to another: asking for a task renews it if there is a place.
    const std::int64_t left = place.task.expires - db.now();
    if (open && left > 0 && left < place.task.lease_seconds / 2) {
      db.run("UPDATE task SET expires = ? WHERE id = ?", db.now() + place.task.lease_seconds, id);
    }
    const std::vector<DialogueEntry> turns = turns_of(db, place.dialogue.id);
    const DialogueEntry here = here_of(place.task.item, turns);
    const bool oracle = place.role == DialogueRole::kOracle;
    ordered_json out{
        {"role", enum_name(place.role)},
        {"partner", is_live(db, oracle ? place.dialogue.navigator : place.dialogue.oracle)},
        {"turn", enum_name(turn_of(turns))},
        {"turns", ordered_json::array()},
        {"here",
         {{"viewpoint", here.viewpoint}, {"heading", here.heading}, {"elevation", here.elevation}}},
        {"finished", place.dialogue.finished.has_value()}};
    for (const DialogueEntry& turn : turns) {
      if (turn.id > after) out["turns"].push_back(turn_json(turn));
    }
    if (oracle) {
      const Ending ending = nearest_end(place.task.item, here.viewpoint, graphs);
      out["arrived"] = ending.metres == 0;
      out["ahead"] = way_shown(ending.way);
    }
    return out;
  });
}

void act_in_dialogue(store::Database& db, const Visit& visit, std::int64_t id,
                     std::string_view body, const graph::GraphSet& graphs) {
  db.transact([&] {
    const Place place = place_of(db, visit, id);
    if (place.dialogue.finished) {
      throw Refusal(Reason::kAlreadySubmitted, "the dialogue is finished");
    }
    renew_lease(db, visit, id);
    const Act act = read_act(body, place.role);
    std::vector<DialogueEntry> turns = turns_of(db, place.dialogue.id);
    if (turn_of(turns) != place.role) {
      throw Refusal(Reason::kConflict, "it is the other one's turn");
    }
    if (static_cast<std::int64_t>(turns.size() + act.steps.size()) > kMostTurns) {
      throw Refusal(Reason::kConflict, "the dialogue is too long to go on");
    }
    DialogueEntry here = here_of(place.task.item, turns);
    here.role = place.role;
    if (act.stop) return finish(db, place, turns, graphs);
    if (!act.say.empty()) {
      here.text = act.say;
      return add_turn(db, place.dialogue.id, here);
    }
    here.text.clear();
    check_steps(place.task.item, here, act.steps, graphs);
    for (const DialogueEntry& step : act.steps) add_turn(db, place.dialogue.id, step);
  });
}

std::vector<ordered_json> cvdn_instances(const Assignment& task, const graph::GraphSet& graphs) {
  const ordered_json content = ordered_json::parse(task.content);
  const ordered_json& turns = content.at("turns");
  const auto game = content.at("dialogue").get<std::int64_t>();
  std::vector<std::string> walked{task.item.path.front()};
  ordered_json history = ordered_json::array();
  std::vector<ordered_json> instances;
  const auto begin_instance = [&](const ordered_json& at) {
    const std::string& here = walked.back();
    instances.push_back(
        {{"inst_idx", game * 1000 + static_cast<std::int64_t>(instances.size())},
         {"scan", task.item.scan},
         {"target", task.item.target},
         {"start_pano",
          {{"heading", at.at("heading")}, {"elevation", at.at("elevation")}, {"pano", here}}},
         {"dialog_history", history},
         {"nav_history", walked},
         {"game_idx", game},
         {"end_panos", task.item.region},
         {"player_path", {here}},
         {"planner_path", way_shown(nearest_end(task.item, here, graphs).way)}});
  };
  begin_instance(turns.at(0));
  for (const ordered_json& turn : turns) {
    const auto viewpoint = turn.at("viewpoint").get<std::string>();
    if (viewpoint != walked.back()) {
      walked.push_back(viewpoint);
      instances.back()["player_path"].push_back(viewpoint);
    }
    if (!turn.contains("text")) continue;
    history.push_back(
        {{"nav_idx", walked.size() - 1}, {"role", turn.at("role")}, {"message", turn.at("text")}});
    if (turn.at("role") == "oracle") begin_instance(turn);
  }
  return instances;
}

}  // namespace enfilade::service::collecting::kinds
