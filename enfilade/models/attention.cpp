#include "enfilade/models/attention.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <array>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "enfilade/core/detail/json.h"
#include "enfilade/models/detail/shares_json.h"

namespace enfilade::models {
namespace {

using json::Element;
using json::Faults;
using json::Path;

AttentionStep read_step(Element element, std::size_t words, const Path& path, Faults& faults) {
  enum { kAction, kAttention, kViewpoint, kHeading, kElevation, kFields };
  constexpr std::array<json::Field, kFields> kWanted{
      {{"action"}, {"attention"}, {"viewpoint"}, {"heading"}, {"elevation"}}};
  std::array<std::optional<Element>, kFields> found;
  AttentionStep step;
  if (!json::fields(element, kWanted, found, path, faults)) return step;
  step.action = json::string(*found[kAction], Path(path, "action"), faults).value_or("");
  step.attention = detail::read_attention(*found[kAttention], words, Path(path, "attention"),
                                          "bad-weight", faults);
  step.viewpoint = json::string(*found[kViewpoint], Path(path, "viewpoint"), faults).value_or("");
  step.heading = json::number(*found[kHeading], Path(path, "heading"), faults).value_or(0);
  step.elevation = json::number(*found[kElevation], Path(path, "elevation"), faults).value_or(0);
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

AttentionFile read(const json::Document& document) {
  Faults faults(document.name());
  AttentionFile file;
  const Path root;
  if (const auto episodes = json::object(document.root(), root, faults)) {
    for (const auto& [id, episode] : *episodes) {
      file.insert_or_assign(std::string(id), read_episode(episode, Path(root, id), faults));
    }
  }
  faults.throw_if_errors();
  return file;
}

void append(std::string& json, const AttentionStep& step) {
  fmt::format_to(std::back_inserter(json),
                 R"({{"action":"{}","attention":[{:.4f}],"viewpoint":{},"heading":{:.6g},)"
                 R"("elevation":{:.6g}}})",
                 step.action, fmt::join(step.attention, ","), nlohmann::json(step.viewpoint).dump(),
                 step.heading, step.elevation + 0.0);  // no -0
}

}  // namespace

AttentionFile load_attention(const std::filesystem::path& file) {
  return read(json::Document::load(file));
}

AttentionFile parse_attention(std::string_view json, const std::string& file) {
  return read(json::Document::parse(json, file));
}

std::string attention_json(std::span<const std::pair<std::string, EpisodeAttention>> episodes) {
  std::string json = "{";
  for (const auto& [id, episode] : episodes) {
    json += fmt::format("{}\n{}:{{\"words\":{},\"steps\":[", json.size() > 1 ? "," : "",
                        nlohmann::json(id).dump(), nlohmann::json(episode.words).dump());
    for (std::size_t step = 0; step < episode.steps.size(); ++step) {
      if (step > 0) json += ',';
      append(json, episode.steps[step]);
    }
    json += "]}";
  }
  return json + "\n}\n";
}

}  // namespace enfilade::models
