// DUET against its recordings: greedy episodes of R2R and REVERIE, and checkpoints.
#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/conformance/agents_golden.h"
#include "tests/conformance/duet_episodes.h"

namespace enfilade::tests {
namespace {

using namespace neural::duet;
using nlohmann::json;

// Of a row of a batch.
std::vector<double> part(const at::Tensor& values, std::int64_t row, std::int64_t begin,
                         std::int64_t length) {
  const at::Tensor cut = values[row].narrow(0, begin, length).contiguous().view({-1});
  return numbers(cut);
}

json ids_of(const graph::NavGraph& graph, std::span<const ViewpointIndex> viewpoints) {
  json ids = json::array();
  for (const ViewpointIndex viewpoint : viewpoints) ids.push_back(graph.id(viewpoint));
  return ids;
}

json trajectory_of(const EpisodeRollout& walk, const graph::NavGraph& graph) {
  json list = json::array();
  for (const auto& step : walk.path) list.push_back(ids_of(graph, step));
  return list;
}

// One agent's part of a step beside the recorded one.
class StepCheck {
 public:
  StepCheck(std::string where, const json& record, const StepRow& row, const StepOfAll& step,
            std::int64_t i, const graph::NavGraph& graph, AgentsTally& tally)
      : where_(std::move(where)),
        record_(record),
        row_(row),
        in_(*step.input),
        out_(*step.output),
        panorama_(step.panorama->values),
        i_(i),
        g_(static_cast<std::int64_t>(row.nodes.size()) + 1),
        c_(static_cast<std::int64_t>(row.candidates.size())),
        graph_(graph),
        tally_(tally) {}

  void check() {
    check_place();
    check_map();
    check_logits();
    equal("choice", row_.choice);
    tally_.equal(where_ + "expert", record_["expert"]["spl"], row_.label);
    equal("go_to", row_.goes_to ? json(graph_.id(*row_.goes_to)) : json());
  }

  // Of the episodes that have them.
  void check_embeddings(const features::TensorFile& tensors, const std::string& name) {
    if (tensors.find(name + ".pano_embeds") == nullptr) return;
    const auto tokens = static_cast<std::int64_t>(row_.views + row_.objects.size());
    const auto check = [&](const char* what, const at::Tensor& values, std::int64_t length) {
      tally_.near_all(name + what, golden_array(tensors, name + what), part(values, i_, 0, length));
    };
    check(".pano_embeds", panorama_, tokens);
    check(".gmap_img_embeds", in_.nodes, g_);
    check(".gmap_embeds", out_.nodes, g_);
    check(".vp_embeds", out_.tokens, tokens + 1);
  }

 private:
  void equal(const char* name, const json& ours) {
    tally_.equal(where_ + name, record_[name], ours);
  }
  void near(const char* name, const json& recorded, const at::Tensor& values, std::int64_t begin,
            std::int64_t length, double tolerance = AgentsTally::kTolerance) {
    tally_.near_json(where_ + name, recorded, part(values, i_, begin, length), tolerance);
  }

  void check_place() {
    equal("viewpoint", graph_.id(row_.pose.viewpoint));
    equal("view_index", row_.pose.view);
    json candidates = json::array(), recorded = json::array();
    for (const sim::Candidate& candidate : row_.candidates) {
      candidates.push_back({graph_.id(candidate.viewpoint), candidate.view});
    }
    for (const json& one : record_["candidates"]) recorded.push_back({one[0], one[1]});
    tally_.equal(where_ + "candidates", recorded, candidates);
    equal("token_count", row_.views);
  }

  void check_map() {
    json nodes = json::array(), visited = json::array();
    for (const auto node : row_.nodes) {
      nodes.push_back(graph_.id(row_.map->viewpoint(node)));
      visited.push_back(row_.map->visited(node) ? 1 : 0);
    }
    equal("nodes", nodes);
    equal("visited", visited);
    equal("step_ids", part(in_.steps, i_, 0, g_));
    json positions = json::array(), near_ones = json::array();
    for (const json& one : record_["gmap_pos_fts"]) {
      positions.insert(positions.end(), one.begin(), one.end());
    }
    const json& start = record_["start_pos_fts"];
    for (const json& one : record_["cand_pos_fts"]) {
      near_ones.insert(near_ones.end(), start.begin(), start.end());
      near_ones.insert(near_ones.end(), one.begin(), one.end());
    }
    constexpr double kFeatures = 1e-6;  // sine and cosine of another library
    near("gmap_pos_fts", positions, in_.node_positions, 0, g_, kFeatures);
    near("cand_pos_fts", near_ones, in_.token_positions, 1, c_, kFeatures);
    std::vector<double> distances;
    const at::Tensor pairs = in_.distances[i_];
    for (std::int64_t a = 1; a < g_; ++a) {
      for (std::int64_t b = a + 1; b < g_; ++b) distances.push_back(pairs[a][b].item<float>());
    }
    constexpr double kMetres = 1e-5;
    tally_.near_json(where_ + "pair_distances", record_["pair_distances"], distances, kMetres);
  }

  void check_logits() {
    near("fuse_weight", json::array({record_["fuse_weight"]}), out_.fuse_weight, 0, 1);
    near("global_scores", record_["global_scores"], out_.global_scores, 0, g_);
    near("local_scores", record_["local_scores"], out_.local_scores, 0, c_ + 1);
    near("global_logits", record_["global_logits"], out_.global_logits, 0, g_);
    near("local_logits", record_["local_logits"], out_.local_logits, 0, c_ + 1);
    near("fused_logits", record_["fused_logits"], out_.fused_logits, 0, g_);
    if (!record_.contains("object_logits")) return;
    near("object_logits", record_["object_logits"], out_.object_logits,
         static_cast<std::int64_t>(row_.views) + 1, static_cast<std::int64_t>(row_.objects.size()));
    equal("object_target", row_.object_label);
  }

  std::string where_;
  const json& record_;
  const StepRow& row_;
  const NavigationInput& in_;
  const NavigationOutput& out_;
  const at::Tensor& panorama_;
  std::int64_t i_, g_, c_;
  const graph::NavGraph& graph_;
  AgentsTally& tally_;
};

// Evaluation of one task.
class EpisodeCheck {
 public:
  EpisodeCheck(const AgentsFolder& folder, const std::string& task, AgentsTally& tally)
      : name_("duet_" + task),
        records_(folder.json_lines(name_ + "_episodes.jsonl.gz")),
        network_(duet_network(folder, task)),
        tensors_(folder.tensors(name_ + "_tensors.npz")),
        surroundings_(folder.data()),
        graphs_(folder.data().graphs()),
        runner_(graphs_, surroundings_),
        tally_(tally) {}

  // \return the results, as they are submitted
  json check() {
    const c10::NoGradGuard no_gradients;
    json results = json::array();
    constexpr std::size_t kBatch = 8;
    for (std::size_t begin = 1; begin < records_.size(); begin += kBatch) {
      check_batch(begin, std::min(begin + kBatch, records_.size()), results);
    }
    return results;
  }

 private:
  void check_batch(std::size_t begin, std::size_t end, json& results) {
    std::vector<RolloutEpisode> batch;
    for (std::size_t k = begin; k < end; ++k) batch.push_back(duet_episode(records_[k], *graphs_));
    DuetRolloutOptions options;
    options.expert = Expert::kSpl;
    std::vector<std::size_t> steps(batch.size());
    const Rollout rollout = runner_.run(network_, batch, options, [&](const StepOfAll& step) {
      for (std::size_t i = 0; i < step.rows.size(); ++i) {
        const StepRow& row = step.rows[i];
        const RolloutEpisode& episode = batch[row.episode];
        ++steps[row.episode];
        const json& recorded = records_[begin + row.episode]["steps"];
        if (step.step >= recorded.size()) continue;  // counted below
        tally_.begin(name_ + "_episodes.jsonl.gz");
        const std::string name = fmt::format("{}.{}", episode.id, step.step);
        StepCheck one(name + " ", recorded[step.step], row, step, static_cast<std::int64_t>(i),
                      graphs_->graph(episode.scan), tally_);
        one.check();
        tally_.begin(name_ + "_tensors.npz");
        one.check_embeddings(tensors_, name);
      }
    });
    for (std::size_t k = 0; k < batch.size(); ++k) {
      tally_.begin(name_ + "_episodes.jsonl.gz");
      const json& record = records_[begin + k];
      tally_.equal(batch[k].id + " steps", record["steps"].size(), steps[k]);
      results.push_back(check_walk(record, batch[k], rollout.episodes[k]));
      check_text(batch[k]);
    }
  }

  json check_walk(const json& record, const RolloutEpisode& episode, const EpisodeRollout& walk) {
    const graph::NavGraph& graph = graphs_->graph(episode.scan);
    json result{{"instr_id", episode.id}, {"trajectory", trajectory_of(walk, graph)}};
    tally_.equal(episode.id + " trajectory", record["trajectory"], result["trajectory"]);
    tally_.equal(episode.id + " stop_node", record["stop_node"], graph.id(walk.stop));
    tally_.equal(episode.id + " stop_probs", record["stop_probs"].size(),
                 walk.stop_probabilities.size());
    for (const auto& [viewpoint, probability] : walk.stop_probabilities) {
      const std::string& id = graph.id(viewpoint);
      tally_.near(episode.id + " stop_probs " + id, record["stop_probs"].value(id, std::nan("")),
                  probability);
    }
    if (record.contains("pred_objid")) {
      result["pred_objid"] = walk.object.empty() ? json() : json(walk.object);
      tally_.equal(episode.id + " pred_objid", record["pred_objid"], result["pred_objid"]);
    }
    return result;
  }

  void check_text(const RolloutEpisode& episode) {
    const std::string name = episode.id + ".txt_embeds";
    if (tensors_.find(name) == nullptr) return;
    tally_.begin(name_ + "_tensors.npz");
    const at::Tensor ids = at::tensor(at::ArrayRef<std::int64_t>(episode.words)).unsqueeze(0);
    const Tokens text = network_.encode_text(ids, at::tensor(ids.size(1)).view({1}));
    tally_.near_all(name, golden_array(tensors_, name), numbers(text.values));
  }

  std::string name_;
  std::vector<json> records_;
  DuetNetwork network_;
  features::TensorFile tensors_;
  NamedSurroundings surroundings_;
  std::shared_ptr<const graph::GraphSet> graphs_;
  RolloutRunner runner_;
  AgentsTally& tally_;
};

void check_episodes(const AgentsFolder& folder, const std::string& task, AgentsTally& tally) {
  const json ours = EpisodeCheck(folder, task, tally).check();
  const std::string name = "duet_" + task + "_results.json";
  if (!folder.has(name)) return;
  tally.begin(name);
  json recorded = folder.json(name);
  tally.equal("episodes", recorded.size(), ours.size());
  for (const json& result : ours) {
    const auto id = result["instr_id"].get<std::string>();
    const auto found = std::ranges::find_if(
        recorded, [&](const json& one) { return one["instr_id"] == result["instr_id"]; });
    tally.equal(id, found == recorded.end() ? json() : *found, result);
  }
}

// A checkpoint gives what plain arrays of the same names hold.
void check_weights(const AgentsFolder& folder, const std::string& task, AgentsTally& tally) {
  tally.begin("duet_" + task + ".pt");
  const features::TensorFile arrays = folder.tensors("duet_" + task + ".npz");
  const DuetNetwork network = duet_network(folder, task);
  for (const auto& [name, values] : network.weights()) {
    tally.near_all(name, golden_array(arrays, name), numbers(values), 0);
  }
}

// A checkpoint with all that a released one has: another prefix, a critic, an optimiser's state.
void check_reader(const AgentsFolder& folder, AgentsTally& tally) {
  tally.begin("duet_reader.pt");
  const features::TensorFile file = folder.tensors("duet_reader.pt");
  const DuetNetwork network(infer_config(file, 4), file);
  const json recorded = folder.json("duet_reader.json")["vln_bert"];
  tally.equal("arrays", recorded.size(), network.weights().size());
  for (const auto& [name, values] : network.weights()) {
    const at::Tensor all = values.detach().to(at::kDouble).view({-1});
    const json row = recorded.value("module." + name, json::array());
    const std::vector<double> ours{all.sum().item<double>(), all.norm().item<double>(),
                                   all[0].item<double>(), all[-1].item<double>()};
    constexpr double kSums = 1e-6;
    tally.near_json(name, row.size() == 5 ? json(row.begin() + 1, row.end()) : row, ours, kSums);
  }
}

}  // namespace

void check_duet(const AgentsFolder& folder, AgentsTally& tally) {
  if (folder.has("duet_units.npz")) check_duet_units(folder, tally);
  if (folder.has("duet_reader.pt")) check_reader(folder, tally);
  for (const std::string task : {"r2r", "reverie"}) {
    if (!folder.has("duet_" + task + ".pt")) continue;
    if (folder.has("duet_" + task + ".npz")) check_weights(folder, task, tally);
    if (folder.has("duet_" + task + "_episodes.jsonl.gz")) check_episodes(folder, task, tally);
    if (folder.has("duet_" + task + "_training.json.gz")) check_duet_training(folder, task, tally);
  }
}

}  // namespace enfilade::tests
