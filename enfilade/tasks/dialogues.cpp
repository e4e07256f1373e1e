#include "enfilade/tasks/dialogues.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks {
namespace {

using json::Element;
using json::Faults;
using json::Path;
using Json = nlohmann::ordered_json;

enum Wanted : std::size_t {
  kId,
  kScan,
  kTarget,
  kStart,
  kEnds,
  kSteps,
  kPlanned,
  kTurns,
  kStops,
  kProblem,
  kCamera,
  kFields
};
constexpr std::array<json::Field, kFields> kWanted{{{"idx"},
                                                    {"scan"},
                                                    {"target"},
                                                    {"start_pano"},
                                                    {"end_panos", false},
                                                    {"nav_steps", false},
                                                    {"planner_nav_steps", false},
                                                    {"dialog_history", false},
                                                    {"stop_history", false},
                                                    {"problem", false},
                                                    {"nav_camera", false}}};
using Found = std::array<std::optional<Element>, kFields>;

enum OfPerson : std::size_t { kPerson, kWorker, kQuality, kAverage, kPersonFields };
constexpr std::array<json::Field, kPersonFields> kOfNavigator{{{"navigator", false},
                                                               {"navigator_mturk", false},
                                                               {"navigator_quality", false},
                                                               {"navigator_avg_quality", false}}};
constexpr std::array<json::Field, kPersonFields> kOfOracle{{{"oracle", false},
                                                            {"oracle_mturk", false},
                                                            {"oracle_quality", false},
                                                            {"oracle_avg_quality", false}}};

std::int64_t whole_number(Element element, const Path& path, Faults& faults,
                          std::string_view what) {
  const auto number = json::integer(element, path, faults);
  if (number && *number < 0) {
    faults.error(path, "negative-number",
                 fmt::format("{} is no {}; 0 and more are", *number, what));
    return 0;
  }
  return number.value_or(0);
}

std::string text_at(Element element, const Path& path, Faults& faults) {
  return std::string(json::string(element, path, faults).value_or(""));
}

// What may be null: a rating that was not given.
bool is_given(const std::optional<Element>& element) { return element && !element->is_null(); }

DialoguePerson read_person(Element element, const std::array<json::Field, kPersonFields>& names,
                           const Path& path, Faults& faults) {
  DialoguePerson person;
  std::array<std::optional<Element>, kPersonFields> found;
  if (!json::fields(element, names, found, path, faults)) return person;
  const auto number = [&](OfPerson field) -> std::optional<double> {
    if (!is_given(found[field])) return std::nullopt;
    return json::number(*found[field], Path(path, names[field].name), faults);
  };
  if (is_given(found[kPerson])) {
    person.id = json::integer(*found[kPerson], Path(path, names[kPerson].name), faults);
  }
  if (is_given(found[kWorker])) {
    person.worker = text_at(*found[kWorker], Path(path, names[kWorker].name), faults);
  }
  person.quality = number(kQuality);
  person.average_quality = number(kAverage);
  return person;
}

// A walk from the start on.
std::vector<std::string> read_steps(Element element, const std::string& start, const Path& path,
                                    Faults& faults) {
  const std::size_t errors = faults.errors();
  std::vector<std::string> steps = formats::read_path(element, path, faults);
  if (faults.errors() == errors && steps[0] != start) {
    faults.error(Path(path, 0), "other-start",
                 fmt::format("{:?}, not {:?}, the start", steps[0], start));
  }
  return steps;
}

void read_ends(Element element, const Path& path, Faults& faults, Dialogue& dialogue) {
  const std::size_t errors = faults.errors();
  dialogue.ends = json::strings(element, path, faults);
  if (dialogue.ends.empty() && faults.errors() == errors) {
    faults.error(path, "empty-region", "no viewpoint; one at least is expected");
  }
}

void check_place(std::size_t place, const Dialogue& dialogue, const Path& path, Faults& faults) {
  if (place < dialogue.steps.size() || dialogue.steps.empty()) return;
  faults.error(
      path, "bad-step",
      fmt::format("{}, not 0 to {}, a place in \"nav_steps\"", place, dialogue.steps.size() - 1));
}

void read_stops(Element element, const Path& path, Faults& faults, Dialogue& dialogue) {
  const auto list = json::array(element, path, faults);
  if (!list) return;
  for (const Element one : *list) {
    const Path place(path, dialogue.stops.size());
    const auto stop =
        static_cast<std::size_t>(whole_number(one, place, faults, "place in \"nav_steps\""));
    check_place(dialogue.stops.emplace_back(stop), dialogue, place, faults);
  }
}

// What test splits hide.
void read_walk(const Found& found, const Path& path, Faults& faults, Dialogue& dialogue) {
  constexpr std::array kTogether{kEnds, kSteps, kPlanned, kTurns};
  const auto* first =
      std::ranges::find_if(kTogether, [&found](Wanted field) { return found[field].has_value(); });
  if (first == kTogether.end()) return;
  bool all = true;
  for (const Wanted field : kTogether) {
    if (found[field]) continue;
    all = false;
    faults.error(
        path, "missing-field",
        fmt::format("has {:?}, but no field {:?}", kWanted[*first].name, kWanted[field].name));
  }
  if (!all) return;
  read_ends(*found[kEnds], Path(path, "end_panos"), faults, dialogue);
  dialogue.steps = read_steps(*found[kSteps], dialogue.start, Path(path, "nav_steps"), faults);
  dialogue.planned =
      read_steps(*found[kPlanned], dialogue.start, Path(path, "planner_nav_steps"), faults);
  const Path turns(path, "dialog_history");
  dialogue.turns = formats::read_turns(*found[kTurns], turns, faults);
  for (std::size_t k = 0; k < dialogue.turns.size(); ++k) {
    const Path turn(turns, k);
    check_place(static_cast<std::size_t>(std::max<std::int64_t>(dialogue.turns[k].nav_step, 0)),
                dialogue, Path(turn, "nav_idx"), faults);
  }
  if (found[kStops]) read_stops(*found[kStops], Path(path, "stop_history"), faults, dialogue);
}

Dialogue read_dialogue(Element element, const Path& path, Faults& faults) {
  Dialogue dialogue;
  Found found;
  if (!json::fields(element, kWanted, found, path, faults)) return dialogue;
  dialogue.id = whole_number(*found[kId], Path(path, "idx"), faults, "id");
  dialogue.scan = text_at(*found[kScan], Path(path, "scan"), faults);
  dialogue.target = text_at(*found[kTarget], Path(path, "target"), faults);
  dialogue.navigator = read_person(element, kOfNavigator, path, faults);
  dialogue.oracle = read_person(element, kOfOracle, path, faults);
  if (found[kProblem]) {
    dialogue.problem = whole_number(*found[kProblem], Path(path, "problem"), faults, "count");
  }
  if (found[kCamera]) dialogue.camera = simdjson::minify(*found[kCamera]);
  const auto start = json::string(*found[kStart], Path(path, "start_pano"), faults);
  if (!start) return dialogue;
  dialogue.start = *start;
  read_walk(found, path, faults, dialogue);
  return dialogue;
}

void add_person(const DialoguePerson& person, const std::array<json::Field, kPersonFields>& names,
                Json& fields) {
  const auto name = [&names](OfPerson field) { return std::string(names[field].name); };
  if (person.id) fields[name(kPerson)] = *person.id;
  if (!person.worker.empty()) fields[name(kWorker)] = person.worker;
  if (person.quality) fields[name(kQuality)] = *person.quality;
  if (person.average_quality) fields[name(kAverage)] = *person.average_quality;
}

Json json_of(const Dialogue& dialogue) {
  Json fields{{"idx", dialogue.id},
              {"scan", dialogue.scan},
              {"target", dialogue.target},
              {"start_pano", dialogue.start}};
  if (!dialogue.goal_hidden()) {
    fields["end_panos"] = dialogue.ends;
    fields["nav_steps"] = dialogue.steps;
    fields["planner_nav_steps"] = dialogue.planned;
    Json turns = Json::array();
    for (const DialogueTurn& turn : dialogue.turns) {
      turns.push_back({{"nav_idx", turn.nav_step}, {"role", turn.role}, {"message", turn.message}});
    }
    fields["dialog_history"] = std::move(turns);
    fields["stop_history"] = dialogue.stops;
  }
  if (!dialogue.camera.empty()) fields["nav_camera"] = Json::parse(dialogue.camera);
  add_person(dialogue.navigator, kOfNavigator, fields);
  add_person(dialogue.oracle, kOfOracle, fields);
  if (dialogue.problem) fields["problem"] = *dialogue.problem;
  return fields;
}

void check_numbers(const Dialogue& dialogue) {
  for (const DialoguePerson* person : {&dialogue.navigator, &dialogue.oracle}) {
    for (const auto& number : {person->quality, person->average_quality}) {
      if (!number || std::isfinite(*number)) continue;
      throw ArgumentError(fmt::format("dialogue {}: a quality of {}", dialogue.id, *number));
    }
  }
}

}  // namespace

std::vector<Dialogue> load_dialogues(const std::filesystem::path& file) {
  return parse_dialogues(read_text_file(file), file.string());
}

std::vector<Dialogue> parse_dialogues(std::string_view json, const std::string& file) {
  std::vector<Dialogue> dialogues;
  Faults faults(file);
  formats::Once once("repeated-id");
  formats::for_each_record(json, faults, [&](Element element, const Path& path) {
    const std::size_t errors = faults.errors();
    const std::size_t record = dialogues.size();
    const Dialogue& dialogue = dialogues.emplace_back(read_dialogue(element, path, faults));
    if (faults.errors() != errors) return;  // it may have no id
    once.check(fmt::to_string(dialogue.id), record, Path(path, "idx"), faults);
  });
  faults.throw_if_errors();
  return dialogues;
}

std::string to_json(const std::vector<Dialogue>& dialogues) {
  std::string text = "[";
  for (const Dialogue& dialogue : dialogues) {
    check_numbers(dialogue);
    try {
      text += text.size() > 1 ? ",\n" : "\n";
      text += json_of(dialogue).dump();
    } catch (const Json::exception& refused) {
      throw ArgumentError(fmt::format("dialogue {}: {}", dialogue.id, refused.what()));
    }
  }
  return text + "\n]\n";
}

}  // namespace enfilade::tasks
