/// \file  Collections, visits and tasks as openapi.json has them, each for those who may see it.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/service/collecting/tasks.h"

namespace enfilade::service::collecting {

/// What everybody may see of a collection.
nlohmann::ordered_json collection_json(const Collection& collection, bool synthetic);
/// What reviewers and organisers see besides: its rules, its splits, and how far the work is.
nlohmann::ordered_json progress_json(store::Database& db, const Collection& collection);
/// For organisers: {"screening", "checks"} with the answers that are right.
nlohmann::ordered_json questions_json(store::Database& db, const Collection& collection);
nlohmann::ordered_json platform_json(const Platform& platform);
nlohmann::ordered_json visit_summary_json(const VisitSummary& visit);
std::string visits_csv(const std::vector<VisitSummary>& visits);

/// What a visit's answer is made of.
struct VisitState {
  Visit visit;
  std::optional<Task> task;        ///< what the visit holds
  std::optional<std::int64_t> of;  ///< tasks that it will have, if they are few enough to be told
  std::int64_t practice = 0;       ///< practice tasks that are still to come
  bool finished = false;           ///< no more tasks are given to it
  bool screened_out = false;
  std::vector<Question> questions;  ///< to be answered first
  std::vector<Task> rejected;
  std::optional<std::int64_t> bonuses;  ///< once knowing them helps with no other task
};
/// For its worker.
nlohmann::ordered_json visit_json(const Collection& collection, const VisitState& state);
/// For its worker, after a practice task: whether a walk reached the goal, and how far from it it
/// ended (metres, where that is asked for), or an example of what may be written.
nlohmann::ordered_json practice_json(const Task& task);
/// For its worker: nothing of a walk's goal.
nlohmann::ordered_json task_json(const Task& task);
/// The item of a task as its worker sees it.
nlohmann::ordered_json item_json(const Item& item, Kind kind);

/// For reviewers. \param secrets whether they may know who reached a secret goal
nlohmann::ordered_json work_json(const Task& task, bool secrets);
/// Adds what was submitted beside a text: the steps of a walk, where somebody pointed, words with
/// their times, the turns of a dialogue; and of a description, how many found the object by it.
void add_content(nlohmann::ordered_json& out, store::Database& db, const Task& task);
/// Adds leased and submitted, and the seconds between them by the server's clock; and page_seconds,
/// as the page measured them.
void add_times(nlohmann::ordered_json& out, const Task& task);
nlohmann::ordered_json work_summary_json(const WorkSummary& work, SummaryBy by);
nlohmann::ordered_json event_json(const Event& event);

}  // namespace enfilade::service::collecting
