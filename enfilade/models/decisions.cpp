#include "enfilade/models/decisions.h"

#include <fmt/format.h>
#include <array>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "enfilade/core/detail/json.h"
#include "enfilade/models/detail/shares_json.h"

namespace enfilade::models {
namespace {

using json::Element;
using json::Faults;
using json::Path;

double read_probability(Element element, const Path& path, Faults& faults) {
  return detail::read_share(element, path, "bad-probability", faults);
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
    const Path place(path, "viewpoint");
    choice.viewpoint = json::string(*found[kViewpoint], place, faults).value_or("?");
    if (choice.viewpoint.empty()) {
      faults.error(place, "no-viewpoint", "an empty name, not a viewpoint's or null (stop)");
    }
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
  node.viewpoint = json::string(*found[kViewpoint], Path(path, "viewpoint"), faults).value_or("");
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
  step.viewpoint = json::string(*found[kViewpoint], Path(path, "viewpoint"), faults).value_or("");
  step.heading = json::number(*found[kHeading], Path(path, "heading"), faults).value_or(0);
  step.elevation = json::number(*found[kElevation], Path(path, "elevation"), faults).value_or(0);
  read_choices(*found[kChoices], *found[kChosen], path, faults, step);
  if (found[kAttention]) {
    step.attention = detail::read_attention(*found[kAttention], words, Path(path, "attention"),
                                            "bad-probability", faults);
  }
  if (found[kWay]) step.way = json::strings(*found[kWay], Path(path, "way"), faults);
  step.map_share = read_probability(found[kMapShare], Path(path, "map_share"), faults);
  if (found[kNodes]) {
    each(*found[kNodes], Path(path, "nodes"), faults, [&](Element one, const Path& place) {
      step.nodes.push_back(read_node(one, place, faults));
    });
  }
  if (found[kObject]) {
    step.object = json::string(*found[kObject], Path(path, "object"), faults).value_or("");
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

DecisionFile read_all(const json::Document& document) {
  Faults faults(document.name());
  DecisionFile file;
  const Path root;
  if (const auto episodes = json::object(document.root(), root, faults)) {
    for (const auto& [id, episode] : *episodes) {
      file.insert_or_assign(std::string(id), read_decisions(episode, Path(root, id), faults));
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

// A number between 0 and 1 in at most six characters.
std::string short_number(double value) {
  return fmt::format("{:g}", std::round(value * 1e4) / 1e4 + 0.0);
}

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

template <class List, class Text>
void append_list(std::string& json, const char* name, const List& list, const Text& text) {
  json += fmt::format(",\"{}\":[", name);
  bool first = true;
  for (const auto& one : list) {
    if (!first) json += ',';
    first = false;
    json += text(one);
  }
  json += ']';
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

void append_step(std::string& json, const DecisionStep& step) {
  json += fmt::format(R"({{"viewpoint":{},"heading":{:.6g},"elevation":{:.6g})",
                      quoted(step.viewpoint), step.heading + 0.0, step.elevation + 0.0);  // no -0
  if (!step.attention.empty()) append_list(json, "attention", step.attention, short_number);
  append_list(json, "choices", step.choices, choice_json);
  json += fmt::format(R"(,"chosen":{})", step.chosen);
  if (!step.way.empty()) append_list(json, "way", step.way, quoted);
  if (step.map_share) json += fmt::format(R"(,"map_share":{})", short_number(*step.map_share));
  if (!step.nodes.empty()) append_list(json, "nodes", step.nodes, node_json);
  if (!step.object.empty()) json += fmt::format(R"(,"object":{})", quoted(step.object));
  json += '}';
}

}  // namespace

DecisionFile load_decisions(const std::filesystem::path& file) {
  return read_all(json::Document::load(file));
}

DecisionFile parse_decisions(std::string_view json, const std::string& file) {
  return read_all(json::Document::parse(json, file));
}

RecordedSplit load_recorded_split(const std::filesystem::path& file) {
  {
    const json::Document document = json::Document::load(file);
    if (has_decisions(document)) return read_all(document);
  }
  return load_attention(file);
}

RecordedSplit parse_recorded_split(std::string_view json, const std::string& file) {
  {
    const json::Document document = json::Document::parse(json, file);
    if (has_decisions(document)) return read_all(document);
  }
  return parse_attention(json, file);
}

std::string decisions_json(std::span<const std::pair<std::string, EpisodeDecisions>> episodes) {
  std::string json = "{";
  for (const auto& [id, episode] : episodes) {
    json += fmt::format("{}\n{}:{{\"agent\":{}", json.size() > 1 ? "," : "", quoted(id),
                        quoted(episode.agent));
    append_list(json, "words", episode.words, quoted);
    json += ",\"steps\":[";
    for (std::size_t step = 0; step < episode.steps.size(); ++step) {
      if (step > 0) json += ',';
      append_step(json, episode.steps[step]);
    }
    json += "]}";
  }
  return json + "\n}\n";
}

}  // namespace enfilade::models
