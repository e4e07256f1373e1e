// EnvDrop's listener against its recordings.
#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/panoramic/panoramic_network.h"
#include "enfilade/neural/panoramic/panoramic_rollout.h"
#include "enfilade/neural/panoramic/panoramic_walk.h"
#include "tests/conformance/agents_golden.h"
#include "tests/conformance/synthetic.h"

namespace enfilade::tests {
namespace {

using namespace neural::panoramic;
using models::Feedback;
using nlohmann::json;

std::vector<double> numbers(const at::Tensor& tensor) {
  const at::Tensor flat = tensor.detach().to(at::kDouble).contiguous();
  return {flat.data_ptr<double>(), flat.data_ptr<double>() + flat.numel()};
}

std::span<const double> first(const std::vector<double>& values, std::size_t count) {
  return std::span(values).first(std::min(count, values.size()));
}

at::Tensor tensor_of(const features::TensorFile& file, const std::string& name) {
  const std::vector<double> values = golden_array(file, name);
  const auto* array = file.find(name);
  return at::tensor(values, at::kDouble).view(array->shape);
}

PanoramicNetwork network_of(const AgentsFolder& folder, const std::string& name, Subout subout) {
  const features::TensorFile file = folder.tensors(name);
  PanoramicConfig config;
  config.subout = subout;
  return {config_of(file, config), file};
}

// --- parts of the network ---

void check_encoding(const features::TensorFile& units, const std::string& name,
                    const Encoding& encoding, AgentsTally& tally) {
  const auto check = [&](const char* what, const at::Tensor& ours) {
    tally.near(name + what, golden_array(units, name + what), numbers(ours));
  };
  check("ctx", encoding.context);
  check("decoder_init", encoding.start);
  check("c_t", encoding.cell);
}

void check_case(const features::TensorFile& units, const std::string& name, PanoramicNetwork& max,
                PanoramicNetwork& tanh, AgentsTally& tally) {
  const at::NoGradGuard guard;
  WordBatch words;
  words.ids = tensor_of(units, name + "/in.ids").to(at::kLong);
  for (const double length : golden_array(units, name + "/in.lengths")) {
    words.lengths.push_back(static_cast<std::int64_t>(length));
  }
  const Encoding encoding = max.encode(words);
  check_encoding(units, name + "/out.max.", encoding, tally);
  check_encoding(units, name + "/out.tanh.", tanh.encode(words), tally);
  const auto input = [&](const char* what) { return tensor_of(units, name + what).to(at::kFloat); };
  StepInput in{input("/in.action"), input("/in.feature"), input("/in.cand_feat"), {}};
  in.closed = at::zeros({in.candidates.size(0), in.candidates.size(1)}, at::kBool);
  const StepOutput out = max.step(encoding, {encoding.start, encoding.cell}, in);
  const auto check = [&](const char* what, const at::Tensor& ours) {
    tally.near(name + what, golden_array(units, name + what), numbers(ours));
  };
  check("/inner.attended_view", out.attended_view);
  check("/inner.view_attention", out.view_attention);
  check("/inner.word_attention", out.word_attention);
  check("/out.h_1", out.hidden);
  check("/out.c_1", out.next.cell);
  check("/out.h_tilde", out.next.tilde);
  check("/out.logit", out.logits);
  check("/out.value", max.value(out.hidden));
}

void check_units(const AgentsFolder& folder, AgentsTally& tally) {
  tally.begin("envdrop_units.npz");
  const features::TensorFile units = folder.tensors("envdrop_units.npz");
  PanoramicNetwork max = network_of(folder, "envdrop.npz", Subout::kMax);
  PanoramicNetwork tanh = network_of(folder, "envdrop.npz", Subout::kTanh);
  constexpr std::string_view kMark = "/in.ids";
  for (const features::NamedArray& array : units.arrays()) {
    if (!array.name.ends_with(kMark)) continue;
    check_case(units, array.name.substr(0, array.name.size() - kMark.size()), max, tanh, tally);
  }
}

// Checkpoints load, and hold what the arrays say.
void check_weights(const AgentsFolder& folder, AgentsTally& tally) {
  tally.begin("envdrop.pt");
  const features::TensorFile arrays = folder.tensors("envdrop.npz");
  const PanoramicNetwork loaded = network_of(folder, "envdrop.pt", Subout::kMax);
  for (const auto& [name, values] : loaded.weights()) {
    tally.near(name, golden_array(arrays, name), numbers(values), 0);
  }
}

// --- episodes ---

struct GoldenEpisode {
  std::string id, scan;
  WalkStart start;
  std::vector<std::int64_t> words;
  const json* recorded = nullptr;
};

class Episodes {
 public:
  Episodes(const AgentsFolder& folder, const std::vector<json>& lines)
      : graphs_(folder.data().graphs()), cache_(graphs_) {
    for (std::size_t i = 1; i < lines.size(); ++i) add(lines[i]);
    images_ = [this](graph::Location at, std::uint32_t view, std::span<float> out) {
      const graph::NavGraph& graph = graphs_->graph(at.scan);
      synthetic_view(graph.scan(), graph.id(at.viewpoint), view, out);
    };
  }

  const GoldenEpisode& at(const std::string& id) const { return episodes_.at(id); }
  const std::map<std::string, GoldenEpisode>& all() const { return episodes_; }
  const graph::NavGraph& graph_of(const GoldenEpisode& e) const {
    return graphs_->graph(e.start.location.scan);
  }
  const ImageSource& images() const { return images_; }

  std::vector<PanoramicWalk> walks(const std::vector<std::string>& ids) {
    std::vector<PanoramicWalk> walks;
    for (const std::string& id : ids) walks.emplace_back(cache_, *graphs_, at(id).start);
    return walks;
  }
  WordBatch words(const std::vector<std::string>& ids) const {
    std::vector<std::vector<std::int64_t>> sentences;
    for (const std::string& id : ids) sentences.push_back(at(id).words);
    return batch_words(sentences);
  }

 private:
  void add(const json& recorded) {
    GoldenEpisode e;
    e.id = recorded.at("instr_id");
    e.scan = recorded.at("scan");
    const json& path = recorded.at("gt_path");
    e.start.location = graphs_->locate(e.scan, path.front().get<std::string>());
    e.start.heading = Radians(recorded.at("start_heading").get<double>());
    e.start.goal = graphs_->locate(e.scan, path.back().get<std::string>()).viewpoint;
    e.words = recorded.at("token_ids").get<std::vector<std::int64_t>>();
    e.recorded = &recorded;
    episodes_.emplace(e.id, std::move(e));
  }

  std::shared_ptr<const graph::GraphSet> graphs_;
  agents::PanoramaCache cache_;
  std::map<std::string, GoldenEpisode> episodes_;
  ImageSource images_;
};

json point_of(const graph::NavGraph& graph, const tasks::TrajectoryPoint& point) {
  return {graph.id(point.viewpoint), point.heading.value, point.elevation.value};
}

// Ids must be equal; angles may differ in the last bits.
void check_points(const std::string& name, const json& recorded, const graph::NavGraph& graph,
                  std::span<const tasks::TrajectoryPoint> ours, AgentsTally& tally) {
  constexpr double kAngle = 1e-9;
  tally.equal(name + ".size", recorded.size(), ours.size());
  for (std::size_t i = 0; i < std::min(recorded.size(), ours.size()); ++i) {
    const json point = point_of(graph, ours[i]);
    const std::string at = fmt::format("{}[{}]", name, i);
    tally.equal(at, recorded[i][0], point[0]);
    tally.near(at + ".heading", golden_number(recorded[i][1]), point[1].get<double>(), kAngle);
    tally.near(at + ".elevation", golden_number(recorded[i][2]), point[2].get<double>(), kAngle);
  }
}

// A row of a step of a rollout, before the move.
class RowCheck {
 public:
  RowCheck(const PanoramicStep& step, std::size_t row, const graph::NavGraph& graph,
           std::string name, AgentsTally& tally)
      : step_(step),
        row_(row),
        walk_(step.walks[row]),
        graph_(graph),
        name_(std::move(name)),
        tally_(tally) {}

  // What training and evaluation have in common.
  void choice(const json& recorded) {
    const std::size_t slots = walk_.stop() + 1, chosen = step_.choices[row_];
    tally_.equal(name_ + ".viewpoint", recorded.at("viewpoint"),
                 graph_.id(walk_.location().viewpoint));
    tally_.near(name_ + ".distance", golden_number(recorded.at("distance")), walk_.distance());
    const std::vector<double> logits = numbers(row(step_.output.logits));
    tally_.near(name_ + ".logits", recorded.at("logits"), first(logits, slots));
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

  // What evaluation alone has.
  void pose(const json& recorded) {
    constexpr double kAngle = 1e-6;
    tally_.equal(name_ + ".view_index", recorded.at("view_index"), walk_.view());
    tally_.near(name_ + ".heading", golden_number(recorded.at("heading")), walk_.heading().value);
    tally_.near(name_ + ".elevation", golden_number(recorded.at("elevation")),
                walk_.elevation().value);
    const std::vector<double> own = numbers(row(step_.input.action));
    tally_.near(name_ + ".input_angle", recorded.at("input_angle"), first(own, 4), kAngle);
    const json& candidates = recorded.at("candidates");
    tally_.equal(name_ + ".candidates", candidates.size(), walk_.stop());
    const std::int64_t image = step_.input.candidates.size(2) - step_.input.action.size(1);
    for (std::size_t k = 0; k < std::min(candidates.size(), walk_.stop()); ++k) {
      const sim::Candidate& ours = walk_.candidates()[k];
      const std::string at = fmt::format("{}.candidates[{}]", name_, k);
      tally_.equal(at, json({candidates[k][0], candidates[k][1], candidates[k][2]}),
                   json({graph_.id(ours.viewpoint), ours.view, ours.index}));
      tally_.near(at + ".heading", golden_number(candidates[k][3]), ours.heading.value, kAngle);
      tally_.near(at + ".elevation", golden_number(candidates[k][4]), ours.elevation.value, kAngle);
      const at::Tensor angle = row(step_.input.candidates)[std::int64_t(k)].narrow(0, image, 4);
      const std::vector<double> angles = numbers(angle);
      tally_.near(at + ".angles", recorded.at("candidate_angles")[k], angles, kAngle);
    }
  }

 private:
  at::Tensor row(const at::Tensor& all) const { return all[static_cast<std::int64_t>(row_)]; }

  const PanoramicStep& step_;
  std::size_t row_;
  const PanoramicWalk& walk_;
  const graph::NavGraph& graph_;
  std::string name_;
  AgentsTally& tally_;
};

// Inner values of the episodes that have them.
void check_inner(const features::TensorFile& tensors, const std::string& name,
                 const StepOutput& out, std::size_t row, std::size_t words, AgentsTally& tally) {
  if (tensors.find(name + ".h_1") == nullptr) return;
  const auto at = static_cast<std::int64_t>(row);
  const auto check = [&](const char* what, const at::Tensor& ours) {
    const std::vector<double> values = numbers(ours[at]);
    const bool sentence = std::string_view(what) == ".word_attention";
    tally.near(name + what, golden_array(tensors, name + what),
               first(values, sentence ? words : values.size()));
  };
  check(".attended_view", out.attended_view);
  check(".view_attention", out.view_attention);
  check(".word_attention", out.word_attention);
  check(".h_1", out.hidden);
  check(".c_1", out.next.cell);
  check(".h_tilde", out.next.tilde);
}

void check_sentences(const features::TensorFile& tensors, const Episodes& episodes,
                     const std::vector<std::string>& ids, PanoramicNetwork& network,
                     AgentsTally& tally) {
  const at::NoGradGuard guard;
  const Encoding encoding = network.encode(episodes.words(ids));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (tensors.find(ids[i] + ".ctx") == nullptr) continue;
    const auto at = static_cast<std::int64_t>(i);
    const auto words = static_cast<std::int64_t>(episodes.at(ids[i]).words.size());
    tally.near(ids[i] + ".ctx", golden_array(tensors, ids[i] + ".ctx"),
               numbers(encoding.context[at].narrow(0, 0, words)));
    tally.near(ids[i] + ".decoder_init", golden_array(tensors, ids[i] + ".decoder_init"),
               numbers(encoding.start[at]));
    tally.near(ids[i] + ".c_t", golden_array(tensors, ids[i] + ".c_t"), numbers(encoding.cell[at]));
  }
}

// The network's episodes in evaluation: batches, then each alone.
class EpisodeCheck {
 public:
  EpisodeCheck(const AgentsFolder& folder, AgentsTally& tally)
      : folder_(folder),
        tally_(tally),
        lines_(folder.json_lines("envdrop_episodes.jsonl.gz")),
        episodes_(folder, lines_),
        network_(network_of(folder, "envdrop.npz", Subout::kMax)) {}

  void run() {
    const at::NoGradGuard guard;
    tally_.begin("envdrop_episodes.jsonl.gz");
    std::map<std::size_t, std::map<std::size_t, std::string>> batches;
    for (const auto& [id, e] : episodes_.all()) {
      batches[e.recorded->at("batch")][e.recorded->at("row")] = id;
    }
    for (const auto& [number, rows] : batches) {
      std::vector<std::string> ids;
      for (const auto& [row, id] : rows) ids.push_back(id);
      tally_.equal(fmt::format("batch {}", number),
                   lines_[0].at("batches_in_order_of_rows").at(number), ids);
      batch(ids);
      batches_.push_back(ids);
    }
    for (const auto& [id, e] : episodes_.all()) alone(e);
    if (folder_.has("envdrop_tensors.npz")) inner();
    if (folder_.has("envdrop_results.json")) results();
    words();
  }

 private:
  void batch(const std::vector<std::string>& ids) {
    std::vector<PanoramicWalk> walks = episodes_.walks(ids);
    roll_out(network_, episodes_.words(ids), walks, episodes_.images(), {},
             [&](const PanoramicStep& step) {
               for (std::size_t i = 0; i < ids.size(); ++i) {
                 if (!step.walks[i].ended()) check_row(step, i, ids[i]);
               }
             });
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const GoldenEpisode& e = episodes_.at(ids[i]);
      tally_.equal(e.id + ".stopped", e.recorded->at("stopped"), walks[i].ended());
      tally_.near(e.id + ".end_distance", golden_number(e.recorded->at("end_distance")),
                  walks[i].distance());
      check_points(e.id + ".trajectory", e.recorded->at("trajectory"), episodes_.graph_of(e),
                   walks[i].trajectory(), tally_);
      walked_[e.id] = walks[i].trajectory();
    }
  }

  void check_row(const PanoramicStep& step, std::size_t row, const std::string& id) {
    const GoldenEpisode& e = episodes_.at(id);
    const std::string name = fmt::format("{}.{}", id, step.step);
    const json& steps = e.recorded->at("steps");
    if (step.step >= steps.size()) {
      tally_.equal(name, "no such step", "a step");
      return;
    }
    RowCheck check(step, row, episodes_.graph_of(e), name, tally_);
    check.pose(steps[step.step]);
    check.choice(steps[step.step]);
  }

  void alone(const GoldenEpisode& e) {
    std::vector<PanoramicWalk> walks = episodes_.walks({e.id});
    const json& recorded = e.recorded->at("alone");
    std::vector<std::string> viewpoints;
    roll_out(network_, episodes_.words({e.id}), walks, episodes_.images(), {},
             [&](const PanoramicStep& step) {
               if (step.step == 0) {
                 tally_.near(e.id + ".alone", recorded.at("first_logits"),
                             numbers(step.output.logits));
               }
               viewpoints.push_back(episodes_.graph_of(e).id(step.walks[0].location().viewpoint));
             });
    tally_.equal(e.id + ".alone.viewpoints", recorded.at("viewpoints"), viewpoints);
  }

  void inner() {
    tally_.begin("envdrop_tensors.npz");
    const features::TensorFile tensors = folder_.tensors("envdrop_tensors.npz");
    for (const std::vector<std::string>& ids : batches_) {
      check_sentences(tensors, episodes_, ids, network_, tally_);
      std::vector<PanoramicWalk> walks = episodes_.walks(ids);
      roll_out(network_, episodes_.words(ids), walks, episodes_.images(), {},
               [&](const PanoramicStep& step) {
                 for (std::size_t i = 0; i < ids.size(); ++i) {
                   if (step.walks[i].ended()) continue;
                   check_inner(tensors, fmt::format("{}.{}", ids[i], step.step), step.output, i,
                               episodes_.at(ids[i]).words.size(), tally_);
                 }
               });
    }
  }

  void results() {
    tally_.begin("envdrop_results.json");
    for (const json& result : folder_.json("envdrop_results.json")) {
      const std::string id = result.at("instr_id");
      check_points(id, result.at("trajectory"), episodes_.graph_of(episodes_.at(id)), walked_[id],
                   tally_);
    }
  }

  // The ids of words, from the data set's texts, where it has them.
  void words() {
    const std::filesystem::path file = folder_.data().folder() / "vocab" / "train_vocab.txt";
    if (!std::filesystem::exists(file)) return;
    tally_.begin("envdrop_episodes.jsonl.gz (words)");
    const tasks::Vocabulary vocabulary = tasks::Vocabulary::load(file);
    for (const std::string& split : folder_.data().splits()) {
      for (const tasks::Episode& e : folder_.data().episodes(split).episodes) {
        const auto found = episodes_.all().find(e.instruction_id);
        if (found == episodes_.all().end()) continue;
        tally_.equal(e.instruction_id + ".token_ids", found->second.words,
                     encode_words(vocabulary, e.text));
      }
    }
  }

  const AgentsFolder& folder_;
  AgentsTally& tally_;
  std::vector<json> lines_;
  Episodes episodes_;
  PanoramicNetwork network_;
  std::vector<std::vector<std::string>> batches_;
  std::map<std::string, std::vector<tasks::TrajectoryPoint>> walked_;
};

}  // namespace

void check_envdrop(const AgentsFolder& folder, AgentsTally& tally) {
  if (!folder.has("envdrop.npz")) return;
  if (folder.has("envdrop.pt")) check_weights(folder, tally);
  if (folder.has("envdrop_units.npz")) check_units(folder, tally);
  if (folder.has("envdrop_episodes.jsonl.gz")) EpisodeCheck(folder, tally).run();
}

}  // namespace enfilade::tests
