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
/// For organisers.
nlohmann::ordered_json platform_json(const Platform& platform);
nlohmann::ordered_json visit_summary_json(const VisitSummary& visit);
std::string visits_csv(const std::vector<VisitSummary>& visits);

/// For its worker. \param task what the visit holds  \param finished no more tasks are given to it
nlohmann::ordered_json visit_json(const Collection& collection, const Visit& visit,
                                  const std::optional<Task>& task, bool finished);
/// For its worker: nothing of a walk's goal.
nlohmann::ordered_json task_json(const Task& task);
/// The item of a task as its worker sees it.
nlohmann::ordered_json item_json(const Item& item, Kind kind);

/// For reviewers. \param secrets whether they may know who reached a secret goal
nlohmann::ordered_json work_json(const Task& task, bool secrets);
nlohmann::ordered_json event_json(const Event& event);

}  // namespace enfilade::service::collecting
