#include "tests/conformance/duet_episodes.h"

#include <fmt/format.h>
#include <cmath>

#include "enfilade/core/gzip.h"
#include "enfilade/neural/core/torch_device.h"
#include "tests/conformance/synthetic.h"

namespace enfilade::tests {

using namespace neural::duet;
using nlohmann::json;

void NamedSurroundings::views(const graph::NavGraph& graph, ViewpointIndex viewpoint,
                              std::span<float> out) {
  const std::size_t columns = out.size() / 36;
  for (std::uint32_t view = 0; view < 36; ++view) {
    synthetic_view(graph.scan(), graph.id(viewpoint), view, out.subspan(view * columns, columns));
  }
}

std::vector<features::ObjectView> NamedSurroundings::objects(const graph::NavGraph& graph,
                                                             ViewpointIndex viewpoint) {
  const double f = 240 / std::tan(kPi / 6);
  std::vector<features::ObjectView> seen;
  for (const auto& object : data_.objects().at(graph.scan(), graph.id(viewpoint))) {
    if (!object.visible()) continue;
    std::size_t largest = 0;
    const auto area = [&](std::size_t i) { return object.boxes[i][2] * object.boxes[i][3]; };
    for (std::size_t i = 1; i < object.boxes.size(); ++i) {
      if (area(i) > area(largest)) largest = i;
    }
    const auto [x, y, w, h] = object.boxes[largest];
    const std::uint32_t view = object.views[largest];
    seen.push_back({std::to_string(object.id),
                    Radians(view % 12 * (kPi / 6) + std::atan((x + w / 2.0 - 320) / f)),
                    Radians((view / 12 - 1.0) * (kPi / 6) + std::atan((240 - y - h / 2.0) / f)),
                    static_cast<double>(w), static_cast<double>(h)});
  }
  return seen;
}

void NamedSurroundings::object(const graph::NavGraph& graph, ViewpointIndex viewpoint,
                               std::size_t i, std::span<float> out) {
  synthetic_object(graph.scan(), graph.id(viewpoint), objects(graph, viewpoint)[i].id, out);
}

RolloutEpisode duet_episode(const json& record, const graph::GraphSet& graphs) {
  RolloutEpisode episode;
  episode.id = record["instr_id"].get<std::string>();
  episode.scan = graphs.at(record["scan"].get<std::string>());
  const graph::NavGraph& graph = graphs.graph(episode.scan);
  for (const json& viewpoint : record["gt_path"]) {
    episode.reference.push_back(*graph.find(viewpoint.get<std::string>()));
  }
  episode.start = episode.reference.front();
  episode.start_view = record["start_view"].get<std::uint32_t>();
  episode.words = record["token_ids"].get<std::vector<std::int64_t>>();
  if (record.contains("gt_obj_id")) episode.object = record["gt_obj_id"].get<std::string>();
  return episode;
}

TrainingEpisodes::TrainingEpisodes(const std::vector<json>& records, const dataset::Dataset& data) {
  const graph::GraphSet& graphs = *data.graphs();
  for (const json& record : records) {
    if (!record.contains("instr_id")) continue;
    RolloutEpisode episode = duet_episode(record, graphs);
    episodes_.emplace(episode.id, std::move(episode));
  }
  for (const char* split : {"train", "val_seen", "val_unseen"}) {
    const auto file = data.folder() / "reverie/v2" / fmt::format("REVERIE_{}.json", split);
    if (std::filesystem::exists(file)) add(json::parse(read_text_file(file)), graphs);
  }
}

std::vector<RolloutEpisode> TrainingEpisodes::batch(const json& ids) const {
  std::vector<RolloutEpisode> list;
  for (const json& id : ids) list.push_back(episodes_.at(id.get<std::string>()));
  return list;
}

void TrainingEpisodes::add(const json& items, const graph::GraphSet& graphs) {
  for (const json& item : items) {
    for (std::size_t n = 0; n < item["instructions"].size(); ++n) {
      json record = item;
      const std::string object =
          item["objId"].is_string() ? item["objId"].get<std::string>() : item["objId"].dump();
      const std::string path =
          item["path_id"].is_string() ? item["path_id"].get<std::string>() : item["path_id"].dump();
      record["instr_id"] = fmt::format("{}_{}_{}", path, object, n);
      if (episodes_.contains(record["instr_id"].get<std::string>())) continue;
      record["gt_path"] = item["path"];
      record["gt_obj_id"] = object;
      record["token_ids"] = synthetic_words(item["instructions"][n].get<std::string>());
      record["start_view"] = agents::level_view(Radians(item["heading"].get<double>()));
      RolloutEpisode episode = duet_episode(record, graphs);
      episodes_.emplace(episode.id, std::move(episode));
    }
  }
}

DuetNetwork duet_network(const AgentsFolder& folder, const std::string& task) {
  const features::TensorFile weights = folder.tensors("duet_" + task + ".pt");
  DuetConfig config = infer_config(weights, 4);
  config.max_words = 100;
  return DuetNetwork(config, weights, neural::core::open_agents_device(folder.device()));
}

}  // namespace enfilade::tests
