// The passes that were written by hand, against derivatives by differences in double precision, and
// the CPU's loops against plain ATen.
#include "enfilade/neural/seq2seq/seq2seq.h"

#include <c10/core/InferenceMode.h>
#include <gtest/gtest.h>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/support/scripted_environment.h"

namespace enfilade::neural::seq2seq {
namespace EN_UNIT {

using tests::made_tokens;
using tests::Script;
using tests::ScriptedEnvironment;

// No size is a multiple of a register's, nor equal to another.
models::NetworkConfig small_config() {
  models::NetworkConfig config;
  config.vocabulary = 11;
  config.max_words = 7;
  config.word_embedding = 5;
  config.hidden = 19;
  config.action_embedding = 3;
  config.features = 37;
  config.dropout = 0.3;
  return config;
}

constexpr std::size_t kEpisodes = 6, kSteps = 5;

struct Case {
  const char* name;
  models::NetworkConfig config = small_config();
  RolloutOptions options;
  bool ends = false;
};

std::vector<Case> cases() {
  std::vector<Case> all(6);
  for (Case& one : all) one.options.feedback = models::Feedback::kTeacher;
  all[0].name = "plain";
  all[1].name = "dropout";
  all[1].options.dropout = true;
  all[2].name = "sample";
  all[2].options.feedback = models::Feedback::kSample;
  all[2].options.dropout = true;
  all[2].config.dropout = 0.5;
  all[3].name = "ends";
  all[3].ends = true;
  all[4].name = "no vision";
  all[4].config.inputs.vision = false;
  all[5].name = "no language";
  all[5].config.inputs.language = false;
  return all;
}

struct Trial {
  Trial(const Case& which, at::ScalarType type, std::unique_ptr<NetworkKernels> kernels)
      : model(which.config, at::TensorOptions().dtype(type), std::move(kernels)),
        options(which.options),
        tokens(made_tokens(kEpisodes, which.config.max_words, which.config.vocabulary)),
        environment(Script{kEpisodes, which.config.features, kSteps, true, which.ends}) {
    options.max_steps = kSteps;
    model.parameters().initialise(3);
  }
  double loss(WithGradients with_gradients) {
    environment.begin();
    return model.rollout({tokens, kEpisodes}, environment, options, with_gradients).loss;
  }
  Parameters& parameters() { return model.parameters(); }

  Network model;
  RolloutOptions options;
  std::vector<std::uint32_t> tokens;
  ScriptedEnvironment environment;
};

double largest(const at::Tensor& x) { return x.abs().max().item<double>(); }

// Central differences err by about step^2 and rounding / step: 1e-10 and 1e-10 for losses near 10.
TEST(Seq2Seq, GradientsAreTheLossesDerivatives) {
  const c10::InferenceMode guard;
  for (const Case& which : cases()) {
    SCOPED_TRACE(which.name);
    // Another draw is another function: only the teacher's loss can be differentiated by steps.
    if (which.options.feedback != models::Feedback::kTeacher) continue;
    Trial run(which, at::kDouble, make_aten_kernels());
    run.loss(WithGradients::kYes);
    const at::Tensor gradients = run.parameters().flat_gradients.clone();
    Rng rng(5);
    for (const WeightInfo& info : run.parameters().infos()) {
      SCOPED_TRACE(info.name);
      for (int k = 0; k < 12; ++k) {
        const auto i = info.begin + static_cast<std::int64_t>(
                                        rng.below(static_cast<std::uint64_t>(info.elements)));
        double& weight = run.parameters().flat_weights.data_ptr<double>()[i];
        const double before = weight, step = 1e-5;
        weight = before + step;
        const double above = run.loss(WithGradients::kNo);
        weight = before - step;
        const double below = run.loss(WithGradients::kNo);
        weight = before;
        EXPECT_NEAR((above - below) / (2 * step), gradients.data_ptr<double>()[i], 2e-9);
      }
    }
  }
}

// Single precision rounds at 6e-8; sums of some hundred terms and 7 + 5 steps make it 1e-6.
TEST(Seq2Seq, TheCpusLoopsAgreeWithAtenInDoublePrecision) {
  const c10::InferenceMode guard;
  for (const Case& which : cases()) {
    SCOPED_TRACE(which.name);
    Trial exact(which, at::kDouble, make_aten_kernels());
    Trial fast(which, at::kFloat, make_cpu_kernels());
    const double loss = exact.loss(WithGradients::kYes);
    EXPECT_NEAR(fast.loss(WithGradients::kYes), loss, 1e-6 * loss);
    EXPECT_EQ(fast.environment.actions, exact.environment.actions);
    for (std::size_t i = 0; i < kWeights; ++i) {
      SCOPED_TRACE(exact.parameters().infos()[i].name);
      const at::Tensor expected = exact.parameters().view(exact.parameters().flat_gradients, i);
      const at::Tensor found = fast.parameters().view(fast.parameters().flat_gradients, i);
      EXPECT_LE(largest(found - expected), 5e-6 * largest(expected) + 1e-9);
    }
  }
}

TEST(Seq2Seq, TheCpusAdamAgreesWithAtenInDoublePrecision) {
  const c10::InferenceMode guard;
  Trial exact(cases()[1], at::kDouble, make_aten_kernels());
  Trial fast(cases()[1], at::kFloat, make_cpu_kernels());
  models::AdamConfig config;
  config.learning_rate = 0.01;
  for (std::uint64_t i = 0; i < 3; ++i) {
    fast.options.stream = exact.options.stream = i;
    fast.loss(WithGradients::kYes);
    // The first steps are by the gradients' signs, so the same rounding has to be in both.
    exact.parameters().flat_gradients.copy_(fast.parameters().flat_gradients);
    fast.model.update(config);
    exact.model.update(config);
  }
  // Weights of up to 3 round at 1.8e-7, three times; the steps themselves are 0.01.
  EXPECT_LE(largest(exact.parameters().flat_weights - fast.parameters().flat_weights), 1e-6);
  EXPECT_GE(largest(exact.parameters().first), 1e-3);
}

// All steps at once or one after the other, with memory for all or for one: the same sums. BLAS may
// add them in another order.
TEST(Seq2Seq, ARolloutWithoutGradientsHasTheSameLoss) {
  const c10::InferenceMode guard;
  for (const Case& which : cases()) {
    SCOPED_TRACE(which.name);
    Trial run(which, at::kFloat, make_cpu_kernels());
    const double loss = run.loss(WithGradients::kYes);
    EXPECT_NEAR(run.loss(WithGradients::kNo), loss, 1e-6 * loss);
    run.environment.begin();
    std::size_t steps = 0;
    const double observed =
        run.model
            .rollout({run.tokens, kEpisodes}, run.environment, run.options, WithGradients::kNo,
                     [&](const StepRecord& record) { steps += record.step == steps ? 1U : 0U; })
            .loss;
    EXPECT_NEAR(observed, loss, 1e-6 * loss);
    EXPECT_EQ(steps, kSteps);
  }
}

TEST(Seq2Seq, UndefinedMemoryPastAnInstructionsEndIsNotRead) {
  const c10::InferenceMode guard;
  const auto kernels = {make_cpu_kernels, make_aten_kernels};
  for (const auto& make : kernels) {
    const auto options = at::TensorOptions().dtype(at::kFloat);
    const std::vector<std::int64_t> lengths{3, 1};
    at::Tensor words = at::full({2, 4, 5}, NAN, options);
    words[0].narrow(0, 0, 3).normal_();
    words[1].narrow(0, 0, 1).normal_();
    const at::Tensor query = at::randn({2, 2, 5}, options), mixed = at::empty({2, 2, 5}, options);
    const at::Tensor weights = at::empty({2, 2, 4}, options);
    make()->attend({words, lengths}, query, weights, mixed);
    EXPECT_TRUE(mixed.isfinite().all().item<bool>());
    EXPECT_EQ(largest(weights.narrow(2, 3, 1)), 0);
    EXPECT_LE(largest(weights.sum(2) - 1), 1e-6);
    EXPECT_LE(largest(mixed.select(1, 1) - words[1][0]), 1e-6);  // its only word
    const at::Tensor query_gradient = at::empty({2, 2, 5}, options);
    make()->attend_backward({words, lengths}, query, weights, mixed, query_gradient,
                            at::empty({2, 4, 5}, options));
    EXPECT_TRUE(query_gradient.isfinite().all().item<bool>());
  }
}

TEST(Seq2Seq, NotANumberIsNotHiddenByTheCpusLoops) {
  const c10::InferenceMode guard;
  for (const float bad : {NAN, -NAN}) {
    Trial run(cases()[0], at::kFloat, make_cpu_kernels());
    run.environment.features()[40] = bad;
    EXPECT_TRUE(std::isnan(run.loss(WithGradients::kYes)));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::seq2seq
