/// \file  Dialogues of two workers: the navigator moves and asks, the oracle sees the path and
/// answers.
///
/// A dialogue has two seats. Each is held by a task of the same item, and is free when no worker
/// has that task any more. Then the next worker takes it over and continues. The last message
/// decides whose turn it is: an oracle answers once, and until then the navigator stays.
#pragma once
#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/service/collecting/assignments.h"

namespace enfilade::service::collecting::kinds {

enum class DialogueRole : std::uint8_t { kNavigator, kOracle };
constexpr std::array<std::string_view, 2> names_of(DialogueRole /*enum*/) {
  return {"navigator", "oracle"};
}

/// Steps of the shortest path that the oracle sees, as in CVDN.
inline constexpr std::size_t kStepsShown = 5;

/// A message, or a step.
struct DialogueEntry {
  std::int64_t id = 0;
  DialogueRole role = DialogueRole::kNavigator;
  std::string text;       ///< empty of a step
  std::string viewpoint;  ///< where the navigator stands
  double heading = 0, elevation = 0;
  std::int64_t at = 0;  ///< seconds since 1970

  auto columns() { return std::tie(id, role, text, viewpoint, heading, elevation, at); }
};

struct DialogueRecord {
  std::int64_t id = 0;
  std::optional<std::int64_t> navigator, oracle;  ///< tasks
  std::optional<std::int64_t> finished;           ///< when

  auto columns() { return std::tie(id, navigator, oracle, finished); }
};

/// A free seat of a dialogue whose other seat is taken.
struct Seat {
  std::int64_t dialogue = 0, item = 0;
  DialogueRole role = DialogueRole::kOracle;

  auto columns() { return std::tie(dialogue, item, role); }
};
/// The oldest one of an item that is new to the worker.
std::optional<Seat> find_seat(store::Database& db, const Collection& collection,
                              std::int64_t worker);
/// Gives the seat to a task, or begins a dialogue as its navigator. \pre within a transaction
void take_seat(store::Database& db, const std::optional<Seat>& seat, std::int64_t task,
               std::int64_t item);
/// Whether the task has a seat of a dialogue that is not finished.
bool holds_seat(store::Database& db, std::int64_t task);

/// State for one of the two: {"role", "partner", "turn", "turns", "here", "finished"}. For the
/// oracle also "ahead", the next viewpoints of the shortest path, and "arrived", as in
/// openapi.json. The lease is renewed if half of it is over, so that waiting for an answer does not
/// lose the task.
/// \param after leaves out turns up to that id
/// \throws Refusal kNotFound if the task is not this visit's, or is not a dialogue
nlohmann::ordered_json dialogue_json(store::Database& db, const Visit& visit, std::int64_t task,
                                     std::int64_t after, const graph::GraphSet& graphs);

/// An action of one of the two, checked against the graph:
/// - {"say": text}
/// - {"steps": [{"viewpoint", "heading", "elevation"}]} by the navigator
/// - {"stop": true} by the navigator at the goal; submits both tasks
///
/// \throws InvalidInput with its faults; Refusal kConflict if it is the other's turn, and as
/// save_draft()
void act_in_dialogue(store::Database& db, const Visit& visit, std::int64_t task,
                     std::string_view body, const graph::GraphSet& graphs);

/// {"dialogue", "turns": [{"role", "text" | none, "viewpoint", "heading", "elevation", "seconds"}]}
/// is the content of both tasks.
/// Instances of CVDN's navigation from dialogue history of one dialogue: one before anything is
/// said, and one after each answer. \param task  of its navigator
std::vector<nlohmann::ordered_json> cvdn_instances(const Assignment& task,
                                                   const graph::GraphSet& graphs);

}  // namespace enfilade::service::collecting::kinds
