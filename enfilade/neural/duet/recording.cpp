#include "enfilade/neural/duet/recording.h"

#include <ATen/ATen.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

namespace enfilade::neural::duet {
namespace {

std::vector<float> row_of(const at::Tensor& values, std::size_t row) {
  const at::Tensor one = values.select(0, static_cast<std::int64_t>(row))
                             .to(at::kCPU, at::kFloat)
                             .contiguous()
                             .view({-1});
  const float* data = one.data_ptr<float>();
  return {data, data + one.numel()};
}

// The probabilities of the viewpoint's branch, by rows of the map; none for what is not to be seen.
std::vector<std::optional<float>> local_probabilities(const StepOfAll& step, std::size_t row,
                                                      std::size_t nodes) {
  const std::vector<float> logits = row_of(step.output->local_logits, row);
  const std::vector<float> shares = models::probabilities(logits);
  const at::Tensor places = step.input->node_of_token.select(0, static_cast<std::int64_t>(row))
                                .to(at::kCPU, at::kLong)
                                .contiguous();
  const std::int64_t* of_token = places.data_ptr<std::int64_t>();
  std::vector<std::optional<float>> by_node(nodes);
  by_node[0] = shares[0];
  for (std::size_t token = 1; token < shares.size(); ++token) {
    const auto node = of_token[token];
    if (node < 1 || static_cast<std::size_t>(node) >= nodes || !std::isfinite(logits[token])) {
      continue;
    }
    auto& share = by_node[static_cast<std::size_t>(node)];
    share = share.value_or(0) + shares[token];
  }
  return by_node;
}

std::string likeliest_object(const StepOfAll& step, std::size_t row) {
  const StepRow& seen = step.rows[row];
  if (!step.output->object_logits.defined() || seen.objects.empty()) return {};
  const std::vector<float> logits = row_of(step.output->object_logits, row);
  const auto best = std::ranges::max_element(logits) - logits.begin();
  const std::ptrdiff_t object = best - 1 - static_cast<std::ptrdiff_t>(seen.views);
  if (object < 0 || object >= std::ssize(seen.objects)) return {};
  return seen.objects[static_cast<std::size_t>(object)].id;
}

}  // namespace

DuetRecording::DuetRecording(const DuetSplit& split)
    : recorder_(models::AgentKind::kDuet, split.episodes().episodes.size()) {
  for (std::size_t i = 0; i < split.episodes().episodes.size(); ++i) {
    std::vector<std::string> text;
    for (const std::int64_t id : split.episode(i).words) text.push_back(split.words().word(id));
    recorder_.read(i, std::move(text));
  }
}

StepWatcher DuetRecording::observer(std::span<const std::size_t> episodes) {
  return [this, episodes](const StepOfAll& step) {
    for (std::size_t row = 0; row < step.rows.size(); ++row) {
      add(step, row, episodes[step.rows[row].episode]);
    }
  };
}

void DuetRecording::add(const StepOfAll& step, std::size_t row, std::size_t episode) {
  const StepRow& seen = step.rows[row];
  const TopologicalMap& map = *seen.map;
  const std::vector<float> fused = row_of(step.output->fused_logits, row);
  const std::vector<float> common = models::probabilities(fused);
  const std::vector<float> global = models::probabilities(row_of(step.output->global_logits, row));
  const auto local = local_probabilities(step, row, common.size());
  std::map<ViewpointIndex, float>& stops = stops_[episode];
  stops[seen.pose.viewpoint] = common[0];

  models::RecordedStep recorded{seen.pose.viewpoint, seen.pose.heading(), seen.pose.elevation()};
  recorded.map_share = row_of(step.output->fuse_weight, row).at(0);
  recorded.choices.push_back({std::nullopt, common[0], global[0], local[0]});
  for (std::size_t i = 0; i < seen.nodes.size(); ++i) {
    const ViewpointIndex there = map.viewpoint(seen.nodes[i]);
    const bool visited = map.visited(seen.nodes[i]);
    const auto stop = stops.find(there);
    recorded.nodes.push_back(
        {there, visited,
         visited && stop != stops.end() ? std::optional(stop->second) : std::nullopt});
    if (!std::isfinite(fused[i + 1])) continue;
    if (seen.goes_to == there) recorded.chosen = recorded.choices.size();
    recorded.choices.push_back({there, common[i + 1], global[i + 1], local[i + 1]});
  }
  if (seen.goes_to) {
    map.path(*map.find(seen.pose.viewpoint), *map.find(*seen.goes_to), recorded.way);
  }
  recorded.object = likeliest_object(step, row);
  recorder_.add(episode, std::move(recorded));
}

}  // namespace enfilade::neural::duet
