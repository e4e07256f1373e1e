// EnvDrop's training against its recordings: losses, gradients, two updates.
#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/optimizer.h"
#include "tests/conformance/envdrop_episodes.h"

namespace enfilade::tests {
namespace {

using namespace neural::panoramic;
using models::Feedback;
using nlohmann::json;

std::vector<double> of_gradient(const at::Tensor& gradient) {
  const at::Tensor wide = gradient.to(at::kDouble);
  return {std::sqrt(wide.square().sum().item<double>()), wide.sum().item<double>(),
          wide.abs().max().item<double>()};
}

std::vector<double> fingerprint(const at::Tensor& values) {
  const std::vector<double> all = numbers(values);
  double sum = 0, squares = 0;
  for (const double value : all) {
    sum += value;
    squares += value * value;
  }
  return {sum, std::sqrt(squares), all.front(), all.back()};
}

// One kind of training, from the recorded weights on.
class VariantCheck {
 public:
  VariantCheck(const AgentsFolder& folder, EnvdropEpisodes& episodes, const json& settings,
               std::string name, AgentsTally& tally)
      : folder_(folder),
        episodes_(episodes),
        settings_(settings),
        name_(std::move(name)),
        tally_(tally),
        network_(network_of(folder, "envdrop.npz", Subout::kMax)),
        optimizer_(options_of(settings)) {}

  void run(const json& variant) {
    const json& iterations = variant.at("iterations");
    for (std::size_t i = 0; i < iterations.size(); ++i) {
      iterate(iterations[i], fmt::format("{}.{}", name_, i));
    }
    for (const auto& [name, recorded] : variant.at("after_two_steps").items()) {
      tally_.near_json(fmt::format("{}.after.{}", name_, name), recorded,
                       fingerprint(network_.weight(name)));
    }
  }

  // Of the checkpoint that was saved then.
  void check_checkpoint(const std::string& file) {
    tally_.begin(file);
    const PanoramicNetwork saved = network_of(folder_, file, Subout::kMax);
    for (const auto& [name, values] : saved.weights()) {
      tally_.near_all(name, numbers(values), numbers(network_.weight(name)));
    }
  }

 private:
  static neural::core::OptimizerConfig options_of(const json& settings) {
    neural::core::OptimizerConfig options;
    options.kind = models::Optimizer::kRmsProp;
    options.rates.learning_rate = settings.at("lr").get<double>();
    options.rates.beta2 = settings.at("alpha").get<double>();
    options.rates.epsilon = settings.at("eps").get<double>();
    options.clip = settings.at("clip").get<double>();
    options.parts = {"encoder.", "decoder."};
    return options;
  }

  void iterate(const json& recorded, const std::string& name) {
    const json& rollouts = recorded.at("rollouts");
    at::Tensor loss = at::zeros({}, at::kFloat);
    for (std::size_t r = 0; r < rollouts.size(); ++r) {
      const auto weight =
          settings_.at(rollouts.size() > 1 ? "ml_weight" : "teacher_weight").get<double>();
      loss = loss + roll(rollouts[r], weight, fmt::format("{}.{}", name, r));
    }
    tally_.near(name + ".loss", golden_number(recorded.at("loss")), loss.item<double>());
    loss.backward();
    for (const auto& [part, norm] : recorded.at("norms").items()) {
      tally_.near(fmt::format("{}.norm.{}", name, part), golden_number(norm),
                  neural::core::gradient_norm(network_.weights(), part + "."));
    }
    for (const auto& [array, gradient] : recorded.at("gradients").items()) {
      const at::Tensor ours = network_.weight(array).grad();
      const std::string at = fmt::format("{}.gradient.{}", name, array);
      tally_.equal(at, gradient.is_null(), !ours.defined());
      if (ours.defined() && !gradient.is_null()) tally_.near_json(at, gradient, of_gradient(ours));
    }
    optimizer_.update(network_.weights());
  }

  at::Tensor roll(const json& recorded, double weight, const std::string& name) {
    const auto ids = recorded.at("episodes").get<std::vector<std::string>>();
    const bool teacher = recorded.at("feedback") == "teacher";
    PanoramicRolloutOptions options;
    options.feedback = teacher ? Feedback::kTeacher : Feedback::kSample;
    options.draw = Draw::kLikeliest;
    options.imitate = teacher;
    options.reinforce = !teacher;
    options.discount = settings_.at("gamma").get<double>();
    std::vector<PanoramicEpisode> walks = episodes_.walks(ids);
    std::vector<std::size_t> steps(ids.size(), 0);
    const RolloutLosses losses =
        roll_out(network_, episodes_.words(ids), walks, episodes_.images(), options,
                 [&](const PanoramicStep& step) {
                   for (std::size_t i = 0; i < ids.size(); ++i) {
                     if (step.walks[i].ended()) continue;
                     const json& rows = recorded.at("steps").at(i);
                     if (steps[i]++ >= rows.size()) continue;  // counted below
                     EnvdropRow(step, i, episodes_.graph_of(episodes_.at(ids[i])),
                                fmt::format("{}.{}.{}", name, ids[i], step.step), tally_)
                         .check_choice(rows[step.step]);
                   }
                 });
    for (std::size_t i = 0; i < ids.size(); ++i) {
      tally_.equal(fmt::format("{}.{}.steps", name, ids[i]), recorded.at("steps")[i].size(),
                   steps[i]);
    }
    if (!teacher) check_rewards(recorded, losses, walks, name);
    const at::Tensor loss = teacher ? losses.imitation * weight : losses.reinforcement;
    tally_.near(name + ".loss", golden_number(recorded.at("loss")), loss.item<double>());
    return loss;
  }

  void check_rewards(const json& recorded, const RolloutLosses& losses,
                     const std::vector<PanoramicEpisode>& walks, const std::string& name) {
    tally_.equal(name + ".active", recorded.at("active"), losses.active);
    const json& active = recorded.at("active");
    for (std::size_t t = 0; t < std::min(active.size(), losses.steps); ++t) {
      for (std::size_t i = 0; i < walks.size(); ++i) {
        if (active[t][i] == 0) continue;
        const auto check = [&](const char* what, const std::vector<std::vector<double>>& ours) {
          tally_.near(fmt::format("{}.{}[{}][{}]", name, what, t, i),
                      golden_number(recorded.at(what)[t][i]), ours[t][i]);
        };
        check("rewards", losses.rewards);
        check("returns", losses.returns);
        check("values", losses.values);
      }
    }
    for (std::size_t i = 0; i < walks.size(); ++i) {
      if (walks[i].ended()) continue;
      tally_.near(fmt::format("{}.last_values[{}]", name, i),
                  golden_number(recorded.at("last_values")[i]), losses.last_values[i]);
    }
  }

  const AgentsFolder& folder_;
  EnvdropEpisodes& episodes_;
  const json& settings_;
  std::string name_;
  AgentsTally& tally_;
  PanoramicNetwork network_;
  neural::core::WeightOptimizer optimizer_;
};

}  // namespace

void check_envdrop_training(const AgentsFolder& folder, AgentsTally& tally) {
  constexpr const char* kAfter = "envdrop_after_two_steps.pt";
  const std::vector<json> lines = folder.json_lines("envdrop_episodes.jsonl.gz");
  EnvdropEpisodes episodes(folder.data(), lines);
  const json recorded = folder.json("envdrop_training.json.gz");
  tally.begin("envdrop_training.json.gz");
  for (const auto& [name, variant] : recorded.at("variants").items()) {
    VariantCheck check(folder, episodes, recorded, name, tally);
    check.run(variant);
    if (name == "a2c" && folder.has(kAfter)) {
      check.check_checkpoint(kAfter);
      tally.begin("envdrop_training.json.gz");
    }
  }
}

}  // namespace enfilade::tests
