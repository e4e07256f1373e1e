#include "enfilade/models/decisions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <ranges>
#include <tuple>

#include "enfilade/core/check.h"
#include "enfilade/core/detail/json.h"
#include "enfilade/core/numbers.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::models {

namespace {

using json::Element;
using json::Faults;
using json::Path;

// A number from 0 to 1; 0 after a fault. \param code of a fault: "bad-weight"
double read_share(Element element, const Path& path, const char* code, Faults& faults) {
  constexpr double kMost = 1.001;  // a softmax in single precision may sum to a little more than 1
  const auto value = json::number(element, path, faults);
  if (value && !(*value >= 0 && *value <= kMost)) {
    faults.error(path, code, fmt::format("{}, not from 0 to 1", *value));
  }
  return value.value_or(0);
}

// A list of such numbers, one per word.
std::vector<double> read_attention(Element element, std::size_t words, const Path& path,
                                   const char* code, Faults& faults) {
  std::vector<double> weights;
  const auto list = json::array(element, path, faults);
  if (!list) return weights;
  if (list->size() != words) {
    faults.error(path, "attention-size",
                 fmt::format("{} weights, not {}, the number of words", list->size(), words));
  }
  for (const Element one : *list) {
    weights.push_back(read_share(one, Path(path, weights.size()), code, faults));
  }
  return weights;
}

// --- attention ---

AttentionStep read_step(Element element, std::size_t words, const Path& path, Faults& faults) {
  enum { kAction, kAttention, kViewpoint, kHeading, kElevation, kFields };
  constexpr std::array<json::Field, kFields> kWanted{
      {{"action"}, {"attention"}, {"viewpoint"}, {"heading"}, {"elevation"}}};
  std::array<std::optional<Element>, kFields> found;
  AttentionStep step;
  if (!json::fields(element, kWanted, found, path, faults)) return step;
  step.action = json::string(*found[kAction], Path(path, "action"), faults).value_or("");
  step.attention =
      read_attention(*found[kAttention], words, Path(path, "attention"), "bad-weight", faults);
  step.viewpoint = json::id(*found[kViewpoint], Path(path, "viewpoint"), faults).value_or("");
  step.heading = json::angle(*found[kHeading], Path(path, "heading"), faults).value_or(0);
  step.elevation = json::angle(*found[kElevation], Path(path, "elevation"), faults).value_or(0);
  return step;
}

EpisodeAttention read_episode(Element element, const Path& path, Faults& faults) {
  constexpr std::array<json::Field, 2> kWanted{{{"words"}, {"steps"}}};
  std::array<std::optional<Element>, 2> found;
  EpisodeAttention episode;
  if (!json::fields(element, kWanted, found, path, faults)) return episode;
  const Path steps_path(path, "steps");
  episode.words = json::strings(*found[0], Path(path, "words"), faults);
  const auto steps = json::array(*found[1], steps_path, faults);
  if (!steps || !found[0]->is_array()) return episode;
  for (const Element step : *steps) {
    const Path step_path(steps_path, episode.steps.size());
    episode.steps.push_back(read_step(step, episode.words.size(), step_path, faults));
  }
  return episode;
}

// --- decisions ---

double read_probability(Element element, const Path& path, Faults& faults) {
  return read_share(element, path, "bad-probability", faults);
}

std::optional<double> read_probability(const std::optional<Element>& element, const Path& path,
                                       Faults& faults) {
  if (!element) return std::nullopt;
  return read_probability(*element, path, faults);
}

// Calls read(element, its path) for each of a list.
template <class Read>
void each(Element element, const Path& path, Faults& faults, const Read& read) {
  const auto list = json::array(element, path, faults);
  if (!list) return;
  std::size_t i = 0;
  for (const Element one : *list) read(one, Path(path, i++));
}

Choice read_choice(Element element, const Path& path, Faults& faults) {
  enum { kViewpoint, kProbability, kMap, kView, kFields };
  constexpr std::array<json::Field, kFields> kWanted{
      {{"viewpoint"}, {"probability"}, {"map", false}, {"view", false}}};
  std::array<std::optional<Element>, kFields> found;
  Choice choice;
  if (!json::fields(element, kWanted, found, path, faults)) return choice;
  if (!found[kViewpoint]->is_null()) {
    choice.viewpoint = json::id(*found[kViewpoint], Path(path, "viewpoint"), faults).value_or("?");
  }
  choice.probability = read_probability(*found[kProbability], Path(path, "probability"), faults);
  choice.map = read_probability(found[kMap], Path(path, "map"), faults);
  choice.view = read_probability(found[kView], Path(path, "view"), faults);
  return choice;
}

MapNode read_node(Element element, const Path& path, Faults& faults) {
  enum { kViewpoint, kVisited, kStop, kFields };
  constexpr std::array<json::Field, kFields> kWanted{{{"viewpoint"}, {"visited"}, {"stop", false}}};
  std::array<std::optional<Element>, kFields> found;
  MapNode node;
  if (!json::fields(element, kWanted, found, path, faults)) return node;
  node.viewpoint = json::id(*found[kViewpoint], Path(path, "viewpoint"), faults).value_or("");
  node.visited = json::boolean(*found[kVisited], Path(path, "visited"), faults).value_or(false);
  node.stop = read_probability(found[kStop], Path(path, "stop"), faults);
  return node;
}

void read_choices(Element element, Element chosen, const Path& path, Faults& faults,
                  DecisionStep& step) {
  const Path choices(path, "choices"), chosen_path(path, "chosen");
  each(element, choices, faults, [&](Element one, const Path& place) {
    step.choices.push_back(read_choice(one, place, faults));
  });
  if (element.is_array() && step.choices.empty()) {
    faults.error(choices, "no-choice", "an empty list, not at least one choice");
  }
  const auto index = json::integer(chosen, chosen_path, faults);
  if (!index || step.choices.empty()) return;
  if (*index < 0 || static_cast<std::size_t>(*index) >= step.choices.size()) {
    faults.error(
        chosen_path, "bad-choice",
        fmt::format("{}, not from 0 to {}, the last of choices", *index, step.choices.size() - 1));
  } else {
    step.chosen = static_cast<std::size_t>(*index);
  }
}

DecisionStep read_decision(Element element, std::size_t words, const Path& path, Faults& faults) {
  enum {
    kViewpoint,
    kHeading,
    kElevation,
    kChoices,
    kChosen,
    kAttention,
    kWay,
    kMapShare,
    kNodes,
    kObject,
    kFields
  };
  constexpr std::array<json::Field, kFields> kWanted{{{"viewpoint"},
                                                      {"heading"},
                                                      {"elevation"},
                                                      {"choices"},
                                                      {"chosen"},
                                                      {"attention", false},
                                                      {"way", false},
                                                      {"map_share", false},
                                                      {"nodes", false},
                                                      {"object", false}}};
  std::array<std::optional<Element>, kFields> found;
  DecisionStep step;
  if (!json::fields(element, kWanted, found, path, faults)) return step;
  step.viewpoint = json::id(*found[kViewpoint], Path(path, "viewpoint"), faults).value_or("");
  step.heading = json::angle(*found[kHeading], Path(path, "heading"), faults).value_or(0);
  step.elevation = json::angle(*found[kElevation], Path(path, "elevation"), faults).value_or(0);
  read_choices(*found[kChoices], *found[kChosen], path, faults, step);
  if (found[kAttention]) {
    step.attention = read_attention(*found[kAttention], words, Path(path, "attention"),
                                    "bad-probability", faults);
  }
  if (found[kWay]) step.way = json::ids(*found[kWay], Path(path, "way"), faults);
  step.map_share = read_probability(found[kMapShare], Path(path, "map_share"), faults);
  if (found[kNodes]) {
    each(*found[kNodes], Path(path, "nodes"), faults, [&](Element one, const Path& place) {
      step.nodes.push_back(read_node(one, place, faults));
    });
  }
  if (found[kObject]) {
    const Element object = *found[kObject];
    // Numbers may be below 0.
    std::string_view number;
    if (object.get(number) == simdjson::SUCCESS && parse_number<std::int64_t>(number)) {
      step.object = number;
    } else {
      step.object = json::id(object, Path(path, "object"), faults).value_or("");
    }
  }
  return step;
}

EpisodeDecisions read_decisions(Element element, const Path& path, Faults& faults) {
  constexpr std::array<json::Field, 3> kWanted{{{"agent"}, {"words"}, {"steps"}}};
  std::array<std::optional<Element>, 3> found;
  EpisodeDecisions episode;
  if (!json::fields(element, kWanted, found, path, faults)) return episode;
  episode.agent = json::string(*found[0], Path(path, "agent"), faults).value_or("");
  episode.words = json::strings(*found[1], Path(path, "words"), faults);
  if (!found[1]->is_array()) return episode;
  each(*found[2], Path(path, "steps"), faults, [&](Element one, const Path& place) {
    episode.steps.push_back(read_decision(one, episode.words.size(), place, faults));
  });
  return episode;
}

// --- files ---

// All episodes of a file, by instruction id.
template <class Episode>
std::map<std::string, Episode> read_all(const json::Document& document,
                                        Episode (*read)(Element, const Path&, Faults&)) {
  Faults faults(document.name());
  std::map<std::string, Episode> file;
  const Path root;
  if (const auto episodes = json::object(document.root(), root, faults)) {
    for (const auto& [id, episode] : *episodes) {
      const Path path(root, id);
      if (std::string fault = fault_of_id(id, kLongestInstructionId); !fault.empty()) {
        faults.error(path, "bad-id", std::move(fault));
        continue;
      }
      file.insert_or_assign(std::string(id), read(episode, path, faults));
    }
  }
  faults.throw_if_errors();
  return file;
}

// Whether the first episode says which agent it is of.
bool has_decisions(const json::Document& document) {
  simdjson::dom::object episodes;
  if (document.root().get(episodes) != simdjson::SUCCESS) return false;
  const auto first = episodes.begin();
  if (first == episodes.end()) return false;
  simdjson::dom::object episode;
  if (first.value().get(episode) != simdjson::SUCCESS) return false;
  return episode.at_key("agent").error() == simdjson::SUCCESS;
}

RecordedSplit read_either(const json::Document& document) {
  if (has_decisions(document)) return read_all(document, read_decisions);
  return read_all(document, read_episode);
}

// A number between 0 and 1 in at most six characters.
std::string short_number(double value) {
  return fmt::format("{:g}", std::round(value * 1e4) / 1e4 + 0.0);
}

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

template <class List, class Text>
void append_list(std::string& json, const char* name, const List& list, const Text& text) {
  json += fmt::format(R"(,"{}":[{}])", name, fmt::join(list | std::views::transform(text), ","));
}

std::string choice_json(const Choice& choice) {
  std::string json = fmt::format(R"({{"viewpoint":{},"probability":{})",
                                 choice.viewpoint.empty() ? "null" : quoted(choice.viewpoint),
                                 short_number(choice.probability));
  if (choice.map) json += fmt::format(R"(,"map":{})", short_number(*choice.map));
  if (choice.view) json += fmt::format(R"(,"view":{})", short_number(*choice.view));
  return json + '}';
}

std::string node_json(const MapNode& node) {
  std::string json =
      fmt::format(R"({{"viewpoint":{},"visited":{})", quoted(node.viewpoint), node.visited);
  if (node.stop) json += fmt::format(R"(,"stop":{})", short_number(*node.stop));
  return json + '}';
}

std::string attention_step_json(const AttentionStep& step) {
  return fmt::format(R"({{"action":"{}","attention":[{:.4f}],"viewpoint":{},"heading":{:.6g},)"
                     R"("elevation":{:.6g}}})",
                     step.action, fmt::join(step.attention, ","), quoted(step.viewpoint),
                     step.heading, step.elevation + 0.0);  // no -0
}

std::string decision_json(const DecisionStep& step) {
  std::string json =
      fmt::format(R"({{"viewpoint":{},"heading":{:.6g},"elevation":{:.6g})", quoted(step.viewpoint),
                  step.heading + 0.0, step.elevation + 0.0);  // no -0
  if (!step.attention.empty()) append_list(json, "attention", step.attention, short_number);
  append_list(json, "choices", step.choices, choice_json);
  json += fmt::format(R"(,"chosen":{})", step.chosen);
  if (!step.way.empty()) append_list(json, "way", step.way, quoted);
  if (step.map_share) json += fmt::format(R"(,"map_share":{})", short_number(*step.map_share));
  if (!step.nodes.empty()) append_list(json, "nodes", step.nodes, node_json);
  if (!step.object.empty()) json += fmt::format(R"(,"object":{})", quoted(step.object));
  return json + '}';
}

// The text of a file. \param head  appends an episode's fields before its steps
template <class Episode, class Head, class Step>
std::string text_of(std::span<const std::pair<std::string, Episode>> episodes, const Head& head,
                    const Step& step) {
  std::string json = "{";
  for (const auto& [id, episode] : episodes) {
    json += fmt::format("{}\n{}:{{", json.size() > 1 ? "," : "", quoted(id));
    head(json, episode);
    append_list(json, "steps", episode.steps, step);
    json += '}';
  }
  return json + "\n}\n";
}

}  // namespace

DecisionFile parse_decisions(std::string_view json, const std::string& file) {
  return read_all(json::Document::parse(json, file), read_decisions);
}

RecordedSplit load_recorded_split(const std::filesystem::path& file) {
  return read_either(json::Document::load(file));
}

RecordedSplit parse_recorded_split(std::string_view json, const std::string& file) {
  return read_either(json::Document::parse(json, file));
}

std::string attention_json(std::span<const std::pair<std::string, EpisodeAttention>> episodes) {
  const auto head = [](std::string& json, const EpisodeAttention& episode) {
    json += R"("words":)" + nlohmann::json(episode.words).dump();
  };
  return text_of(episodes, head, attention_step_json);
}

std::string decisions_json(std::span<const std::pair<std::string, EpisodeDecisions>> episodes) {
  const auto head = [](std::string& json, const EpisodeDecisions& episode) {
    json += R"("agent":)" + quoted(episode.agent);
    append_list(json, "words", episode.words, quoted);
  };
  return text_of(episodes, head, decision_json);
}

namespace {

std::optional<double> wider(const std::optional<float>& value) {
  return value ? std::optional<double>(*value) : std::nullopt;
}

DecisionStep with_names(const RecordedStep& step, const graph::NavGraph& graph) {
  DecisionStep named{.viewpoint = graph.id(step.viewpoint),
                     .heading = step.heading.value,
                     .elevation = step.elevation.value,
                     .attention = {step.attention.begin(), step.attention.end()},
                     .choices = {},
                     .chosen = step.chosen,
                     .way = {},
                     .map_share = wider(step.map_share),
                     .nodes = {},
                     .object = step.object};
  for (const RecordedChoice& choice : step.choices) {
    named.choices.push_back({choice.viewpoint ? graph.id(*choice.viewpoint) : std::string(),
                             choice.probability, wider(choice.map), wider(choice.view)});
  }
  for (const ViewpointIndex v : step.way) named.way.push_back(graph.id(v));
  for (const RecordedNode& node : step.nodes) {
    named.nodes.push_back({graph.id(node.viewpoint), node.visited, wider(node.stop)});
  }
  return named;
}

}  // namespace

std::vector<float> probabilities(std::span<const float> logits) {
  std::vector<float> result(logits.size());
  if (logits.empty()) return result;
  const float most = *std::ranges::max_element(logits);
  double sum = 0;
  for (std::size_t i = 0; i < logits.size(); ++i) {
    result[i] = std::exp(logits[i] - most);
    sum += static_cast<double>(result[i]);
  }
  for (float& one : result) one = static_cast<float>(static_cast<double>(one) / sum);
  return result;
}

DecisionRecorder::DecisionRecorder(AgentKind agent, std::size_t episodes)
    : agent_(agent), recorded_(episodes) {}

void DecisionRecorder::read(std::size_t episode, std::vector<std::string> words) {
  EN_CHECK_LT(episode, recorded_.size());
  recorded_[episode] = {std::move(words), {}};
}

void DecisionRecorder::add(std::size_t episode, RecordedStep step) {
  EN_CHECK_LT(episode, recorded_.size());
  RecordedSteps& to = recorded_[episode];
  EN_CHECK_LT(step.chosen, step.choices.size());
  if (!step.attention.empty()) EN_CHECK_EQ(step.attention.size(), to.words.size());
  to.steps.push_back(std::move(step));
}

EpisodeDecisions DecisionRecorder::episode(std::size_t episode,
                                           const tasks::EpisodeSet& episodes) const {
  EN_CHECK_LT(episode, recorded_.size());
  const graph::NavGraph& graph = episodes.graph_of(episodes.episodes[episode]);
  EpisodeDecisions named{std::string(to_string(agent_)), recorded_[episode].words, {}};
  for (const RecordedStep& step : recorded_[episode].steps) {
    named.steps.push_back(with_names(step, graph));
  }
  return named;
}

std::string DecisionRecorder::text(const tasks::EpisodeSet& episodes,
                                   const std::vector<tasks::Trajectory>& trajectories,
                                   std::size_t count) const {
  EN_CHECK_EQ(episodes.episodes.size(), recorded_.size());
  std::vector<std::pair<std::string, EpisodeDecisions>> shown;
  for (const std::size_t i : shown_episodes(trajectories, episodes, count)) {
    shown.emplace_back(episodes.episodes[i].instruction_id, episode(i, episodes));
  }
  return decisions_json(shown);
}

std::set<std::size_t> shown_episodes(const std::vector<tasks::Trajectory>& trajectories,
                                     const tasks::EpisodeSet& episodes, std::size_t count) {
  const std::size_t total = trajectories.size();
  std::set<std::size_t> shown;
  for (std::size_t i = 0; i < std::min(count, total); ++i) shown.insert(i);
  if (goals_hidden(episodes)) return shown;
  const auto metrics = score_trajectories(trajectories, episodes, {}, 0);
  std::vector<std::size_t> sorted(total);
  std::iota(sorted.begin(), sorted.end(), std::size_t{0});
  const auto take_first = [&](const auto& key) {
    std::ranges::stable_sort(sorted, std::ranges::greater{}, key);
    shown.insert(sorted.begin(),
                 sorted.begin() + std::min<std::ptrdiff_t>(std::ssize(sorted),
                                                           static_cast<std::ptrdiff_t>(count / 3)));
  };
  take_first([&](std::size_t i) {
    return std::tuple(std::round(20 * metrics[i].spl), metrics[i].shortest);
  });
  take_first([&](std::size_t i) { return metrics[i].nav_error; });
  return shown;
}

}  // namespace enfilade::models
