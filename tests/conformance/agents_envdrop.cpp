// EnvDrop's listener against its recordings.
#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/panoramic/panoramic_episode.h"
#include "enfilade/neural/panoramic/panoramic_network.h"
#include "tests/conformance/agents_golden.h"
#include "tests/conformance/envdrop_episodes.h"

namespace enfilade::tests {
namespace {

using namespace neural::panoramic;
using models::Feedback;
using nlohmann::json;

// --- parts of the network ---

at::Tensor tensor_of(const features::TensorFile& file, const std::string& name) {
  const std::vector<double> values = golden_array(file, name);
  const auto* array = file.find(name);
  return at::tensor(values, at::kDouble).view(array->shape);
}

void check_encoding(const features::TensorFile& units, const std::string& name,
                    const Encoding& encoding, AgentsTally& tally) {
  const auto check = [&](const char* what, const at::Tensor& ours) {
    tally.near_all(name + what, golden_array(units, name + what), numbers(ours));
  };
  check("ctx", encoding.context);
  check("decoder_init", encoding.start);
  check("c_t", encoding.cell);
}

void check_case(const features::TensorFile& units, const std::string& name, PanoramicNetwork& max,
                PanoramicNetwork& tanh, AgentsTally& tally) {
  const c10::NoGradGuard guard;
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
    tally.near_all(name + what, golden_array(units, name + what), numbers(ours));
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
    tally.near_all(name, golden_array(arrays, name), numbers(values), 0);
  }
}

// --- episodes ---

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

// Inner values of the episodes that have them.
void check_inner(const features::TensorFile& tensors, const std::string& name,
                 const StepOutput& out, std::size_t row, std::size_t words, AgentsTally& tally) {
  if (tensors.find(name + ".h_1") == nullptr) return;
  const auto at = static_cast<std::int64_t>(row);
  const auto check = [&](const char* what, const at::Tensor& ours) {
    const std::vector<double> values = numbers(ours[at]);
    const bool sentence = std::string_view(what) == ".word_attention";
    tally.near_all(name + what, golden_array(tensors, name + what),
                   first(values, sentence ? words : values.size()));
  };
  check(".attended_view", out.attended_view);
  check(".view_attention", out.view_attention);
  check(".word_attention", out.word_attention);
  check(".h_1", out.hidden);
  check(".c_1", out.next.cell);
  check(".h_tilde", out.next.tilde);
}

void check_sentences(const features::TensorFile& tensors, const EnvdropEpisodes& episodes,
                     const std::vector<std::string>& ids, PanoramicNetwork& network,
                     AgentsTally& tally) {
  const c10::NoGradGuard guard;
  const Encoding encoding = network.encode(episodes.words(ids));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (tensors.find(ids[i] + ".ctx") == nullptr) continue;
    const auto at = static_cast<std::int64_t>(i);
    const auto words = static_cast<std::int64_t>(episodes.at(ids[i]).words.size());
    tally.near_all(ids[i] + ".ctx", golden_array(tensors, ids[i] + ".ctx"),
                   numbers(encoding.context[at].narrow(0, 0, words)));
    tally.near_all(ids[i] + ".decoder_init", golden_array(tensors, ids[i] + ".decoder_init"),
                   numbers(encoding.start[at]));
    tally.near_all(ids[i] + ".c_t", golden_array(tensors, ids[i] + ".c_t"),
                   numbers(encoding.cell[at]));
  }
}

// The network's episodes in evaluation: batches, then each alone.
class EpisodeCheck {
 public:
  EpisodeCheck(const AgentsFolder& folder, AgentsTally& tally)
      : folder_(folder),
        tally_(tally),
        lines_(folder.json_lines("envdrop_episodes.jsonl.gz")),
        episodes_(folder.data(), lines_),
        network_(network_of(folder, "envdrop.npz", Subout::kMax)) {}

  void run() {
    const c10::NoGradGuard guard;
    tally_.begin("envdrop_episodes.jsonl.gz");
    std::map<std::size_t, std::map<std::size_t, std::string>> batches;
    for (const auto& [id, e] : episodes_.all()) {
      batches[e.recorded->at("batch").get<std::size_t>()]
             [e.recorded->at("row").get<std::size_t>()] = id;
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
    std::vector<PanoramicEpisode> walks = episodes_.walks(ids);
    roll_out(network_, episodes_.words(ids), walks, episodes_.images(), {},
             [&](const PanoramicStep& step) {
               for (std::size_t i = 0; i < ids.size(); ++i) {
                 if (!step.walks[i].ended()) check_row(step, i, ids[i]);
               }
             });
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const EnvdropEpisode& e = episodes_.at(ids[i]);
      tally_.equal(e.id + ".stopped", e.recorded->at("stopped"), walks[i].ended());
      tally_.near(e.id + ".end_distance", golden_number(e.recorded->at("end_distance")),
                  walks[i].distance());
      check_points(e.id + ".trajectory", e.recorded->at("trajectory"), episodes_.graph_of(e),
                   walks[i].trajectory(), tally_);
      walked_[e.id] = walks[i].trajectory();
    }
  }

  void check_row(const PanoramicStep& step, std::size_t row, const std::string& id) {
    const EnvdropEpisode& e = episodes_.at(id);
    const std::string name = fmt::format("{}.{}", id, step.step);
    const json& steps = e.recorded->at("steps");
    if (step.step >= steps.size()) {
      tally_.equal(name, "no such step", "a step");
      return;
    }
    EnvdropRow check(step, row, episodes_.graph_of(e), name, tally_);
    check.check_pose(steps[step.step]);
    check.check_choice(steps[step.step]);
  }

  void alone(const EnvdropEpisode& e) {
    std::vector<PanoramicEpisode> walks = episodes_.walks({e.id});
    const json& recorded = e.recorded->at("alone");
    std::vector<std::string> viewpoints;
    roll_out(network_, episodes_.words({e.id}), walks, episodes_.images(), {},
             [&](const PanoramicStep& step) {
               if (step.step == 0) {
                 tally_.near_json(e.id + ".alone", recorded.at("first_logits"),
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
      std::vector<PanoramicEpisode> walks = episodes_.walks(ids);
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
      const auto id = result.at("instr_id").get<std::string>();
      check_points(id, result.at("trajectory"), episodes_.graph_of(episodes_.at(id)), walked_[id],
                   tally_);
    }
  }

  // The ids of words, from the data set's texts, where it has them.
  void words() {
    const std::filesystem::path file = folder_.data().folder() / "vocab" / "train_vocab.txt";
    if (!std::filesystem::exists(file)) return;
    tally_.begin("envdrop_episodes.jsonl.gz (words)");
    constexpr std::size_t kMostWords = 80;  // as the recorded run's
    const models::InstructionWords vocabulary(tasks::Vocabulary::load(file));
    for (const std::string& split : folder_.data().splits(tasks::benchmark(tasks::Task::kR2r))) {
      for (const tasks::Episode& e : folder_.data().episodes(split).episodes) {
        const auto found = episodes_.all().find(e.instruction_id);
        if (found == episodes_.all().end()) continue;
        tally_.equal(e.instruction_id + ".token_ids", found->second.words,
                     vocabulary.encode(e.text, kMostWords));
      }
    }
  }

  const AgentsFolder& folder_;
  AgentsTally& tally_;
  std::vector<json> lines_;
  EnvdropEpisodes episodes_;
  PanoramicNetwork network_;
  std::vector<std::vector<std::string>> batches_;
  std::map<std::string, std::vector<tasks::TrajectoryPoint>> walked_;
};

}  // namespace

void check_envdrop(const AgentsFolder& folder, AgentsTally& tally) {
  if (!folder.has("envdrop.npz")) return;
  tally.begin("envdrop.npz");
  tally.equal("arrays", folder.tensors("envdrop.npz").arrays().size(),
              network_of(folder, "envdrop.npz", Subout::kMax).weights().size());
  if (folder.has("envdrop.pt")) check_weights(folder, tally);
  if (folder.has("envdrop_units.npz")) check_units(folder, tally);
  if (!folder.has("envdrop_episodes.jsonl.gz")) return;
  EpisodeCheck(folder, tally).run();
  if (folder.has("envdrop_training.json.gz")) check_envdrop_training(folder, tally);
}

}  // namespace enfilade::tests
