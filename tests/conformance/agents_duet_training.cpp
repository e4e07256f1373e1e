// DUET's training: labels, losses, gradients and steps of the recorded iterations.
#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <vector>

#include "enfilade/neural/core/optimizer.h"
#include "enfilade/neural/duet/duet_split.h"
#include "tests/conformance/agents_golden.h"
#include "tests/conformance/duet_episodes.h"

namespace enfilade::tests {
namespace {

using namespace neural::duet;
using nlohmann::json;

DuetRolloutOptions options_of(const std::string& task, const std::string& variant,
                              const json& feedback) {
  DuetRolloutOptions options;
  options.draw_best = true;
  options.explore = 0;
  options.three_losses = variant == "three_losses";
  options.expert = variant == "ndtw_sample" ? Expert::kNdtw : Expert::kSpl;
  options.feedback = feedback == "teacher"  ? RolloutFeedback::kTeacher
                     : feedback == "sample" ? RolloutFeedback::kSample
                     : feedback == "argmax" ? RolloutFeedback::kGreedy
                                            : RolloutFeedback::kExplore;
  if (feedback == "teacher" && task == "r2r") options.expert = Expert::kReference;
  return options;
}

// Those whose gradient is zero but for rounding, and so differ from code to code.
bool is_noise(const std::string& name) {
  for (const char* end :
       {"key.bias", "in_proj_bias", "sprel_linear.bias", "global_sap_head.net.2.bias",
        "global_sap_head.net.3.bias", "og_head.net.2.bias", "og_head.net.3.bias"}) {
    if (name.ends_with(end)) return true;
  }
  return false;
}

// On an annotated path every present viewpoint but the first has one visited neighbour, so a number
// added to all local logits is added to every fused logit: no gradient either.
bool is_noise_of_imitation(const std::string& name) {
  return name.ends_with("local_sap_head.net.2.bias") || name.ends_with("local_sap_head.net.3.bias");
}

void check_step(const json& record, const StepOfAll& step, bool teacher,
                const std::vector<RolloutEpisode>& batch, const graph::GraphSet& graphs,
                const std::string& where, AgentsTally& tally) {
  for (const StepRow& row : step.rows) {
    const std::size_t k = row.episode;
    const graph::NavGraph& graph = graphs.graph(batch[k].scan);
    const auto equal = [&](const char* name, const json& ours) {
      tally.equal(fmt::format("{} {}.{} {}", where, batch[k].id, step.step, name), record[name][k],
                  ours);
    };
    equal("viewpoints", graph.id(row.pose.viewpoint));
    equal("fused_targets", row.label);
    if (record.contains("local_targets")) equal("local_targets", row.local_label);
    if (record.contains("object_targets")) equal("object_targets", row.object_label);
    if (!teacher) equal("choices", row.choice);
    equal("go_to", row.goes_to ? json(graph.id(*row.goes_to)) : json());
  }
}

bool is_noise(const std::string& name, const std::string& variant) {
  return is_noise(name) || (variant == "imitation" && is_noise_of_imitation(name));
}

// Norms: of single precision, summed in another order.
constexpr double kNorm = 1e-3, kNothing = 1e-5;

void check_gradients(const json& recorded, const DuetNetwork& network, const std::string& variant,
                     AgentsTally& tally) {
  for (const auto& [name, weight] : network.weights()) {
    if (is_noise(name, variant) || !recorded.contains(name)) continue;
    const at::Tensor& gradient = weight.grad();
    if (recorded[name].is_null()) {
      tally.equal(variant + " gradient " + name, true, !gradient.defined());
      continue;
    }
    const auto length = recorded[name][0].get<double>();
    const double ours =
        gradient.defined() ? gradient.to(at::kDouble).norm().item<double>() : std::nan("");
    tally.near(variant + " gradient " + name, length, ours,
               (kNorm * length + kNothing) / std::max(1.0, length));
  }
}

// The recorded iterations of one variant.
class VariantCheck {
 public:
  VariantCheck(const AgentsFolder& folder, std::string task, std::string variant,
               const TrainingEpisodes& known, AgentsTally& tally)
      : task_(std::move(task)),
        variant_(std::move(variant)),
        known_(known),
        network_(duet_network(folder, task_)),
        surroundings_(folder.data()),
        graphs_(folder.data().graphs()),
        runner_(graphs_, surroundings_),
        tally_(tally) {}

  void check(const json& about, double rate) {
    // The published code's option for the decay is not connected, so its decay is PyTorch's own.
    neural::core::OptimizerConfig adam;
    adam.rates.learning_rate = rate;
    adam.rates.weight_decay = 0.01;
    neural::core::WeightOptimizer optimizer(adam);
    for (const json& iteration : about["iterations"]) check_iteration(iteration, optimizer);
    for (const auto& [name, weight] : network_.weights()) {
      if (is_noise(name, variant_)) continue;
      const auto length = about["after_two_steps"][name][1].get<double>();
      constexpr double kWeights = 1e-4;
      tally_.near(variant_ + " after two steps " + name, length,
                  weight.detach().to(at::kDouble).norm().item<double>(),
                  (kWeights * length + kNothing) / std::max(1.0, length));
    }
  }

 private:
  void check_iteration(const json& iteration, neural::core::WeightOptimizer& optimizer) {
    const json& rollouts = iteration["rollouts"];
    std::vector<std::vector<RolloutEpisode>> batches;
    std::vector<WeightedRollout> walks;
    for (const json& rollout : rollouts) batches.push_back(known_.batch(rollout["episodes"]));
    for (std::size_t i = 0; i < batches.size(); ++i) {
      walks.push_back({batches[i], options_of(task_, variant_, rollouts[i]["feedback"]),
                       rollouts[i]["weight"].get<double>()});
    }
    std::size_t which = 0, last = 0;
    neural::core::clear_gradients(network_.weights());
    const auto losses = rollout_for_loss(network_, runner_, walks, [&](const StepOfAll& walked) {
      if (walked.step < last) ++which;
      last = walked.step;
      const json& steps = rollouts[which]["steps"];
      if (walked.step >= steps.size()) {
        tally_.equal(variant_ + " steps", steps.size(), walked.step + 1);
      } else {
        check_step(steps[walked.step], walked, rollouts[which]["feedback"] == "teacher",
                   batches[which], *graphs_, variant_, tally_);
      }
    });
    const double loss = losses.sum.defined() ? neural::core::follow_back(losses.sum) : 0;
    tally_.near(variant_ + " loss", iteration["loss"].get<double>(), loss);
    if (iteration.contains("gradients") && iteration["gradients"].is_object()) {
      check_gradients(iteration["gradients"], network_, variant_, tally_);
    }
    const auto norm = iteration["total_norm"].get<double>();
    tally_.near(variant_ + " total_norm", norm, optimizer.update(network_.weights()), kNorm);
  }

  std::string task_, variant_;
  const TrainingEpisodes& known_;
  DuetNetwork network_;
  NamedSurroundings surroundings_;
  std::shared_ptr<const graph::GraphSet> graphs_;
  RolloutRunner runner_;
  AgentsTally& tally_;
};

}  // namespace

void check_duet_training(const AgentsFolder& folder, const std::string& task, AgentsTally& tally) {
  const std::string name = "duet_" + task + "_training.json.gz";
  const json record = folder.json(name);
  const TrainingEpisodes known(folder.json_lines("duet_" + task + "_episodes.jsonl.gz"),
                               folder.data());
  tally.begin(name);
  for (const auto& [variant, about] : record["variants"].items()) {
    VariantCheck(folder, task, variant, known, tally).check(about, record["lr"].get<double>());
  }
}

}  // namespace enfilade::tests
