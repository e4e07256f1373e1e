/// \file  Collections, visits and tasks as openapi.json has them, each for who may see it.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "enfilade/service/collecting/tasks.h"

namespace enfilade::service::collecting {

/// What everybody may see of a collection.
nlohmann::ordered_json collection_json(const Collection& collection, bool synthetic);

/// To its worker: nothing of a walk's goal.
nlohmann::ordered_json task_json(const Task& task);
/// As task_json(), of an item that nobody has.
nlohmann::ordered_json example_json(const Item& item, Kind kind);

nlohmann::ordered_json completion_json(const Completion& completion);

/// To reviewers. \param secrets whether they may know who reached a secret goal
nlohmann::ordered_json work_json(const Task& task, bool secrets);
nlohmann::ordered_json events_json(const std::vector<Event>& events);

}  // namespace enfilade::service::collecting
