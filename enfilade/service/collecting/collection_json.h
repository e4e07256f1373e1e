/// \file  Collections, visits and tasks as in openapi.json, per kind of reader. Reads and checks
/// what workers submit.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/service/collecting/assignments.h"
#include "enfilade/service/server.h"

namespace enfilade::service::collecting {

/// A collection as its reader sees it. Reviewers and organisers also see its rules, splits and
/// progress; organisers also the right answers to its questions, and its link.
nlohmann::ordered_json collection_json(store::Database& db, const Collection& collection,
                                       bool synthetic, std::optional<TokenRole> reader = {});
nlohmann::ordered_json visit_summary_json(const VisitSummary& visit);
std::string visits_csv(const std::vector<VisitSummary>& visits);

/// How a visit stands, for its worker; changes nothing.
/// \param finished whether no more tasks are given to it; no value: is_finished()
nlohmann::ordered_json visit_json(store::Database& db, const Collection& collection,
                                  std::int64_t visit, std::optional<bool> finished = {});
/// For its worker, after a practice task. Whether a trajectory reached the goal, and its end's
/// distance from it (metres, if the task needs it), or an example of a text.
nlohmann::ordered_json practice_json(const Assignment& task);
/// For its worker: nothing about the goal of kWalk.
nlohmann::ordered_json task_json(const Assignment& task);
/// The item of a task, for its worker.
nlohmann::ordered_json item_json(const WorkItem& item, WorkKind kind);

/// For reviewers. \param secrets whether they may see who reached a secret goal
nlohmann::ordered_json work_json(const Assignment& task, bool secrets);
/// Adds the submitted content beside a text: the steps of a trajectory, the direction of the
/// answer, words with times, the turns of a dialogue. For a description, also how many found the
/// object by it.
void add_content(nlohmann::ordered_json& out, store::Database& db, const Assignment& task);
/// Adds leased and submitted, and the seconds between them by the server's clock; and page_seconds,
/// as the page measured them.
void add_times(nlohmann::ordered_json& out, const Assignment& task);
nlohmann::ordered_json work_summary_json(const WorkSummary& work, SummaryBy by);
nlohmann::ordered_json event_json(const Event& event);

/// A task's work by its kind, as openapi.json has it.
/// - kWrite, kDescribe: {"instruction", "seconds", "flags"}
/// - kWalk: {"steps": [{"viewpoint", "heading", "elevation", "seconds"}], "camera"}: a trajectory
///   that an agent could have made, from the item's start along edges of its graph. The content is
///   the list of steps.
/// - kFind: {"steps", "camera", "point": {"heading", "elevation"}}: a trajectory, and the direction
///   of its worker's answer at its end. Candidates are the site's objects, and the item's outlines.
/// - kGuide: {"instruction", "words": [{"word", "start", "end"}], "steps", "spoken", "seconds",
///   "flags"}: the spoken words along the item's path, one by one, and the steps. Words are those
///   of the instruction between blanks; they begin one after another. Steps may go back and forth
///   on the path, but must reach its end.
///
/// \throws InvalidInput with its faults (up to 1000) and their JSON paths; for a body beyond
/// detail::kWorkLimits. No message gives away more of the item's path than its start
/// \throws Refusal kConflict for a dialogue
SubmittedWork read_work(std::string_view body, const Assignment& task, const Site& site);

/// 10 to 2000 characters, three words at least. \throws InvalidInput; where: JSON path
void check_instruction(std::string_view instruction, const char* where);

}  // namespace enfilade::service::collecting
