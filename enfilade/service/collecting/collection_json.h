/// \file  Collections, visits and tasks as in openapi.json, per kind of reader.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/service/collecting/tasks.h"

namespace enfilade::service::collecting {

/// The public part of a collection.
nlohmann::ordered_json collection_json(const Collection& collection, bool synthetic);
/// The part for reviewers and organisers only: its rules, its splits, and its progress.
nlohmann::ordered_json progress_json(store::Database& db, const Collection& collection);
/// For organisers: {"screening", "checks"} with the right answers.
nlohmann::ordered_json questions_json(store::Database& db, const Collection& collection);
nlohmann::ordered_json platform_json(const Platform& platform);
nlohmann::ordered_json visit_summary_json(const VisitSummary& visit);
std::string visits_csv(const std::vector<VisitSummary>& visits);

/// The parts of a visit's response.
struct VisitState {
  Visit visit;
  std::optional<Task> task;        ///< the visit's task
  std::optional<std::int64_t> of;  ///< tasks that it will have, if they are few enough to be shown
  std::int64_t practice = 0;       ///< practice tasks that are still to come
  bool finished = false;           ///< no more tasks are given to it
  bool screened_out = false;
  std::vector<Question> questions;  ///< to be answered first
  std::vector<Task> rejected;
  std::optional<std::int64_t> bonuses;  ///< once knowing them helps with no other task
};
/// For its worker.
nlohmann::ordered_json visit_json(const Collection& collection, const VisitState& state);
/// For its worker, after a practice task. Whether a trajectory reached the goal, and its end's
/// distance from it (metres, if the task needs it), or an example of a text.
nlohmann::ordered_json practice_json(const Task& task);
/// For its worker: nothing about the goal of kWalk.
nlohmann::ordered_json task_json(const Task& task);
/// The item of a task, for its worker.
nlohmann::ordered_json item_json(const Item& item, Kind kind);

/// For reviewers. \param secrets whether they may see who reached a secret goal
nlohmann::ordered_json work_json(const Task& task, bool secrets);
/// Adds the submitted content beside a text: the steps of a trajectory, the direction of the
/// answer, words with times, the turns of a dialogue. For a description, also how many found the
/// object by it.
void add_content(nlohmann::ordered_json& out, store::Database& db, const Task& task);
/// Adds leased and submitted, and the seconds between them by the server's clock; and page_seconds,
/// as the page measured them.
void add_times(nlohmann::ordered_json& out, const Task& task);
nlohmann::ordered_json work_summary_json(const WorkSummary& work, SummaryBy by);
nlohmann::ordered_json event_json(const Event& event);

}  // namespace enfilade::service::collecting
