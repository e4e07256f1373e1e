#include "tests/conformance/envdrop_episodes.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/neural/core/torch_device.h"
#include "tests/conformance/synthetic.h"

namespace enfilade::tests {

using namespace neural::panoramic;
using nlohmann::json;

std::span<const double> first(const std::vector<double>& values, std::size_t count) {
  return std::span(values).first(std::min(count, values.size()));
}

PanoramicNetwork network_of(const AgentsFolder& folder, const std::string& name, Subout subout) {
  const features::TensorFile file = folder.tensors(name);
  PanoramicConfig config;
  config.subout = subout;
  return {config_of(file, config), file, neural::core::open_agents_device(folder.device())};
}

EnvdropEpisodes::EnvdropEpisodes(const dataset::Dataset& data, const std::vector<json>& lines)
    : graphs_(data.graphs()), panoramas_(graphs_) {
  for (std::size_t i = 1; i < lines.size(); ++i) add(lines[i]);
  images_ = [this](graph::Location at, std::uint32_t view, std::span<float> out) {
    const graph::NavGraph& graph = graphs_->graph(at.scan);
    synthetic_view(graph.scan(), graph.id(at.viewpoint), view, out);
  };
}

void EnvdropEpisodes::add(const json& recorded) {
  EnvdropEpisode e;
  e.id = recorded.at("instr_id").get<std::string>();
  const auto scan = recorded.at("scan").get<std::string>();
  const json& path = recorded.at("gt_path");
  e.start.location = graphs_->locate(scan, path.front().get<std::string>());
  e.start.heading = Radians(recorded.at("start_heading").get<double>());
  e.start.goal = graphs_->locate(scan, path.back().get<std::string>()).viewpoint;
  e.words = recorded.at("token_ids").get<std::vector<std::int64_t>>();
  e.recorded = &recorded;
  episodes_.emplace(e.id, std::move(e));
}

const graph::NavGraph& EnvdropEpisodes::graph_of(const EnvdropEpisode& episode) const {
  return graphs_->graph(episode.start.location.scan);
}

std::vector<PanoramicEpisode> EnvdropEpisodes::walks(const std::vector<std::string>& ids) {
  std::vector<PanoramicEpisode> walks;
  for (const std::string& id : ids) walks.emplace_back(panoramas_, *graphs_, at(id).start);
  return walks;
}

WordBatch EnvdropEpisodes::words(const std::vector<std::string>& ids) const {
  std::vector<std::vector<std::int64_t>> sentences;
  for (const std::string& id : ids) sentences.push_back(at(id).words);
  return batch_words(sentences);
}

void EnvdropRow::check_choice(const json& recorded) {
  const std::size_t slots = walk_.stop() + 1, chosen = step_.choices[row_];
  tally_.equal(name_ + ".viewpoint", recorded.at("viewpoint"),
               graph_.id(walk_.location().viewpoint));
  tally_.near(name_ + ".distance", golden_number(recorded.at("distance")), walk_.distance());
  const std::vector<double> logits = numbers(row(step_.output.logits));
  tally_.near_json(name_ + ".logits", recorded.at("logits"), first(logits, slots));
  tally_.equal(name_ + ".action", recorded.at("action"), chosen);
  tally_.equal(name_ + ".teacher", recorded.at("teacher"), walk_.teacher());
  tally_.equal(
      name_ + ".go_to", recorded.at("go_to"),
      chosen >= walk_.stop() ? json() : json(graph_.id(walk_.candidates()[chosen].viewpoint)));
  const at::Tensor open = row(step_.output.logits).narrow(0, 0, std::int64_t(slots));
  const at::Tensor logs = at::log_softmax(open.detach().to(at::kDouble), 0);
  tally_.near(name_ + ".log_prob", golden_number(recorded.at("log_prob")),
              numbers(logs)[std::min(chosen, walk_.stop())]);
  tally_.near(name_ + ".entropy", golden_number(recorded.at("entropy")),
              numbers(-(logs.exp() * logs).sum())[0]);
}

void EnvdropRow::check_pose(const json& recorded) {
  constexpr double kAngle = 1e-6;
  tally_.equal(name_ + ".view_index", recorded.at("view_index"), walk_.view());
  tally_.near(name_ + ".heading", golden_number(recorded.at("heading")), walk_.heading().value);
  tally_.near(name_ + ".elevation", golden_number(recorded.at("elevation")),
              walk_.elevation().value);
  const std::vector<double> own = numbers(row(step_.input.action));
  tally_.near_json(name_ + ".input_angle", recorded.at("input_angle"), first(own, 4), kAngle);
  check_candidates(recorded);
}

void EnvdropRow::check_candidates(const json& recorded) {
  constexpr double kAngle = 1e-6;
  const json& candidates = recorded.at("candidates");
  tally_.equal(name_ + ".candidates", candidates.size(), walk_.stop());
  const std::int64_t image = step_.input.candidates.size(2) - step_.input.action.size(1);
  for (std::size_t k = 0; k < std::min(candidates.size(), walk_.stop()); ++k) {
    const sim::Candidate& ours = walk_.candidates()[k];
    const std::string at = fmt::format("{}.candidates[{}]", name_, k);
    tally_.equal(at, json({candidates[k][0], candidates[k][1], candidates[k][2]}),
                 json({graph_.id(ours.viewpoint), ours.view, ours.index}));
    tally_.near(at + ".heading", golden_number(candidates[k][3]),
                (ours.heading - walk_.heading()).value, kAngle);
    tally_.near(at + ".elevation", golden_number(candidates[k][4]), ours.elevation.value, kAngle);
    const at::Tensor angle = row(step_.input.candidates)[std::int64_t(k)].narrow(0, image, 4);
    const std::vector<double> angles = numbers(angle);
    tally_.near_json(at + ".angles", recorded.at("candidate_angles")[k], angles, kAngle);
  }
}

at::Tensor EnvdropRow::row(const at::Tensor& all) const {
  return all[static_cast<std::int64_t>(row_)];
}

}  // namespace enfilade::tests
