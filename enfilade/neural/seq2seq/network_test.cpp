#include "enfilade/neural/seq2seq/seq2seq.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/scripted_environment.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::seq2seq {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using tests::made_tokens;
using tests::Script;
using tests::ScriptedEnvironment;
using tests::TemporaryFolder;

constexpr std::size_t kEpisodes = 6;

models::NetworkConfig small_config() {
  models::NetworkConfig config;
  config.vocabulary = 13;
  config.max_words = 9;
  config.word_embedding = 8;
  config.hidden = 24;
  config.action_embedding = 4;
  config.features = 20;
  return config;
}

RolloutOptions options_of(models::Feedback feedback) {
  RolloutOptions options;
  options.feedback = feedback;
  options.max_steps = 5;
  return options;
}

std::span<const float> floats(const Network::State& state, const std::string& name) {
  for (const features::NamedArray& array : state.arrays) {
    if (array.name != name) continue;
    return {reinterpret_cast<const float*>(array.bytes.data()),  // NOLINT: bytes of floats
            array.elements()};
  }
  ADD_FAILURE() << "no array " << name;
  return {};
}

/// A network, instructions and an environment that fit.
struct Fixture {
  explicit Fixture(const models::NetworkConfig& config = small_config(), Script script = {})
      : tokens(made_tokens(kEpisodes, config.max_words, config.vocabulary)),
        environment(complete(script, config)),
        network(config, 7) {}

  static Script complete(Script script, const models::NetworkConfig& config) {
    script.episodes = kEpisodes;
    script.dimensions = config.features;
    return script;
  }
  InstructionBatch batch() const { return {tokens, kEpisodes}; }
  RolloutResult rollout(const RolloutOptions& options, const StepObserver& observer = {}) {
    environment.begin();
    return network.rollout(batch(), environment, options, observer);
  }
  RolloutResult learn(const RolloutOptions& options) {
    environment.begin();
    return network.rollout_with_gradients(batch(), environment, options);
  }

  std::vector<std::uint32_t> tokens;
  ScriptedEnvironment environment;
  Network network;
};

bool equal(const Network::State& a, const Network::State& b) {
  if (a.arrays.size() != b.arrays.size()) return false;
  for (std::size_t i = 0; i < a.arrays.size(); ++i) {
    if (a.arrays[i].name != b.arrays[i].name || a.storage[i] != b.storage[i]) return false;
  }
  return true;
}

TEST(Network, NamesAndShapesAreTheReleasedCodes) {
  models::NetworkConfig config = small_config();
  const Network::State state = Network(config, 1).weights();
  std::vector<std::string> found;
  for (const features::NamedArray& array : state.arrays) {
    std::string shape;
    for (const auto n : array.shape) shape += " " + std::to_string(n);
    found.push_back(array.name + shape);
  }
  EXPECT_THAT(found, ::testing::ElementsAre(
                         "encoder.embedding.weight 13 8", "encoder.lstm.weight_ih_l0 96 8",
                         "encoder.lstm.weight_hh_l0 96 24", "encoder.lstm.bias_ih_l0 96",
                         "encoder.lstm.bias_hh_l0 96", "encoder.encoder2decoder.weight 24 24",
                         "encoder.encoder2decoder.bias 24", "decoder.embedding.weight 8 4",
                         "decoder.lstm.weight_ih 96 24", "decoder.lstm.weight_hh 96 24",
                         "decoder.lstm.bias_ih 96", "decoder.lstm.bias_hh 96",
                         "decoder.attention_layer.linear_in.weight 24 24",
                         "decoder.attention_layer.linear_out.weight 24 48",
                         "decoder.decoder2action.weight 6 24", "decoder.decoder2action.bias 6"));
}

// 6,000 normal numbers: their deviation is 1 within 0.01 (1 sigma), their largest about 3.7.
TEST(Network, InitialWeightsAreDistributedAsPyTorchs) {
  models::NetworkConfig config = small_config();
  config.vocabulary = 750;
  const Network::State state = Network(config, 1).weights();
  const auto words = floats(state, "encoder.embedding.weight");
  double squares = 0;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i < config.word_embedding) {
      EXPECT_EQ(words[i], 0) << "PAD";
    }
    squares += double{words[i]} * double{words[i]};
  }
  EXPECT_NEAR(squares / static_cast<double>(words.size()), 1, 0.06);
  // Uniform: at most the bound, and of hundreds of numbers some are within 5 % of it.
  const auto expect_bound = [&](const char* name, double bound) {
    double most = 0;
    for (const float x : floats(state, name)) most = std::max(most, std::abs(double{x}));
    EXPECT_LE(most, bound) << name;
    EXPECT_GE(most, 0.95 * bound) << name;
  };
  expect_bound("encoder.lstm.weight_ih_l0", 1 / std::sqrt(24.0));
  expect_bound("decoder.lstm.bias_hh", 1 / std::sqrt(24.0));
  expect_bound("decoder.attention_layer.linear_out.weight", 1 / std::sqrt(48.0));
  expect_bound("decoder.decoder2action.weight", 1 / std::sqrt(24.0));
}

TEST(Network, ForwardIsImpossibleWhereItIsClosed) {
  Fixture fixture;
  const auto& open = fixture.environment.forward_open();
  std::size_t closed = 0;
  const auto look = [&](const StepRecord& record) {
    for (std::size_t i = 0; i < kEpisodes; ++i) {
      const float logit = record.logits[i * kSixActionCount + 4];
      if (open[record.step * kEpisodes + i] != 0) {
        EXPECT_TRUE(std::isfinite(logit));
      } else {
        ++closed;
        EXPECT_EQ(logit, -std::numeric_limits<float>::infinity());
        EXPECT_NE(record.actions[i], 4);
      }
    }
  };
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RolloutOptions options = options_of(models::Feedback::kSample);
    options.seed = seed;
    fixture.rollout(options, look);
  }
  fixture.rollout(options_of(models::Feedback::kArgmax), look);
  EXPECT_GT(closed, 50);
}

TEST(Network, PaddingGetsNoAttentionAndWordsGetAllOfIt) {
  Fixture fixture;
  std::size_t longest = 0, padded = 0;
  for (std::size_t i = 0; i < kEpisodes; ++i) {
    for (std::size_t k = 0; k < 9; ++k) {
      if (fixture.tokens[i * 9 + k] != 0) longest = std::max(longest, k + 1);
    }
  }
  fixture.rollout(options_of(models::Feedback::kArgmax), [&](const StepRecord& record) {
    EXPECT_EQ(record.words, longest);
    for (std::size_t i = 0; i < kEpisodes; ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < record.words; ++k) {
        const float weight = record.attention[i * record.words + k];
        const bool word = fixture.tokens[i * 9 + k] != 0;
        EXPECT_EQ(weight > 0, word);
        padded += word ? 0U : 1U;
        sum += double{weight};
      }
      EXPECT_NEAR(sum, 1, 1e-6);  // float
    }
  });
  EXPECT_GT(padded, 0);
}

// A file of weights, all zero: every logit is 0, so the loss of a row is log 6, or log 5 where
// forward is closed.
TEST(Network, TheLossIsAMeanOverRowsThatCountAndASumOverSteps) {
  const TemporaryFolder folder("network");
  for (const bool ends : {false, true}) {
    Script script;
    script.ends = ends;
    Fixture fixture(small_config(), script);
    Network::State state = fixture.network.weights();
    for (auto& bytes : state.storage) std::memset(bytes.data(), 0, bytes.size());
    features::write_safetensors(folder.path() / "zero.safetensors", state.arrays);
    fixture.network.load_weights(features::TensorFile::open(folder.path() / "zero.safetensors"));
    double expected = 0;
    for (std::size_t step = 0; step < 5; ++step) {
      double sum = 0, counting = 0;
      for (std::size_t i = 0; i < kEpisodes; ++i) {
        if (fixture.environment.labels()[step * kEpisodes + i] == kIgnoreLabel) continue;
        sum += fixture.environment.forward_open()[step * kEpisodes + i] != 0 ? std::log(6)
                                                                             : std::log(5);
        ++counting;
      }
      expected += sum / counting;
    }
    const RolloutResult result = fixture.learn(options_of(models::Feedback::kTeacher));
    EXPECT_EQ(result.steps, 5);
    EXPECT_NEAR(result.loss, expected, 1e-12);
    EXPECT_NEAR(fixture.rollout(options_of(models::Feedback::kArgmax)).loss, expected, 1e-12);
  }
}

TEST(Network, TheTeachersActionsAreItsLabelsAndIgnoreForWhoIsOver) {
  Script script;
  script.ends = true;
  Fixture fixture(small_config(), script);
  fixture.rollout(options_of(models::Feedback::kTeacher));
  std::vector<std::int32_t> expected = fixture.environment.labels();
  for (std::int32_t& label : expected) label = label == kIgnoreLabel ? kIgnoreInput : label;
  EXPECT_EQ(fixture.environment.actions, expected);
}

TEST(Network, ARolloutStopsWhenAllAreOver) {
  Script script;
  script.ends = true;
  script.steps = 9;
  Fixture fixture(small_config(), script);
  RolloutOptions options = options_of(models::Feedback::kTeacher);
  options.max_steps = 9;
  EXPECT_EQ(fixture.rollout(options).steps, kEpisodes);  // the last one's ends after its 6th
  EXPECT_EQ(fixture.learn(options).steps, kEpisodes);
  options.feedback = models::Feedback::kSample;
  EXPECT_EQ(fixture.learn(options).steps, kEpisodes);
}

// Shares of 6,000 draws err by 0.0065 at most (1 sigma).
TEST(Network, ActionsAreDrawnFromTheSoftmax) {
  Fixture fixture;
  std::vector<double> expected(kSixActionCount), found(kSixActionCount);
  for (std::uint64_t stream = 0; stream < 1000; ++stream) {
    RolloutOptions options = options_of(models::Feedback::kSample);
    options.stream = stream;
    options.max_steps = 1;
    fixture.rollout(options, [&](const StepRecord& record) {
      for (std::size_t i = 0; i < kEpisodes; ++i) {
        double sum = 0;
        for (std::size_t a = 0; a < 6; ++a) sum += std::exp(double{record.logits[i * 6 + a]});
        for (std::size_t a = 0; a < 6; ++a) {
          expected[a] += std::exp(double{record.logits[i * 6 + a]}) / sum / 6000;
        }
        found[static_cast<std::size_t>(record.actions[i])] += 1.0 / 6000;
      }
    });
  }
  for (std::size_t a = 0; a < 6; ++a) EXPECT_NEAR(found[a], expected[a], 0.025) << a;
}

TEST(Network, EqualSeedsAndStreamsGiveEqualNumbersAndOthersDoNot) {
  RolloutOptions options = options_of(models::Feedback::kSample);
  options.dropout = true;
  Fixture a, b;
  const double loss = a.learn(options).loss;
  EXPECT_EQ(b.learn(options).loss, loss);
  EXPECT_TRUE(equal(a.network.gradients(), b.network.gradients()));
  EXPECT_EQ(a.environment.actions, b.environment.actions);
  options.stream = 1;
  EXPECT_NE(b.learn(options).loss, loss);
  options.stream = 0;
  EXPECT_EQ(b.learn(options).loss, loss);  // nothing of the rollout between is left
  EXPECT_TRUE(equal(a.network.gradients(), b.network.gradients()));
}

// Loops of our own give the same at any number of threads; OpenBLAS splits some sums differently,
// so gradients differ in their last digits (up to 1e-6 of the largest was seen at the paper's
// sizes). With one number of threads they are the same to the bit, on a second run too.
TEST(Network, ThreadsChangeNoMoreThanTheBlasDoes) {
  models::NetworkConfig config = small_config();
  config.hidden = 160;
  config.features = 300;
  RolloutOptions options = options_of(models::Feedback::kTeacher);
  options.dropout = true;
  const auto gradients = [&](int threads) {
    set_threads(threads);
    Fixture fixture(config);
    fixture.learn(options);
    return fixture.network.gradients();
  };
  const Network::State one = gradients(1), two = gradients(2);
  EXPECT_TRUE(equal(gradients(1), one));
  EXPECT_TRUE(equal(gradients(2), two));
  set_threads(0);
  for (const features::NamedArray& array : one.arrays) {
    const auto a = floats(one, array.name), b = floats(two, array.name);
    double most = 0, difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      most = std::max(most, std::abs(double{a[i]}));
      difference = std::max(difference, std::abs(double{a[i]} - double{b[i]}));
    }
    EXPECT_LE(difference, 2e-6 * most) << array.name;
  }
}

TEST(Network, LearnsItsTeachersLabels) {
  Fixture fixture;
  RolloutOptions options = options_of(models::Feedback::kTeacher);
  const double before = fixture.rollout(options).loss;
  models::AdamConfig adam;
  adam.learning_rate = 0.01;
  for (std::uint64_t i = 0; i < 60; ++i) {
    options.dropout = true;
    options.stream = i;
    fixture.learn(options);
    fixture.network.update(adam);
  }
  EXPECT_EQ(fixture.network.updates(), 60);
  options.dropout = false;
  EXPECT_LT(fixture.rollout(options).loss, before / 3);
}

// A step changes every weight by the learning rate, but where the gradient is 0 and so is the
// weight: PAD's embedding. Without vision the features' columns only decay.
TEST(Network, WeightsThatAreNotUsedDecay) {
  for (const std::size_t features : {20U, 0U}) {
    models::NetworkConfig config = small_config();
    config.inputs.vision = false;
    config.features = features;
    Fixture fixture(config);
    const Network::State before = fixture.network.weights();
    fixture.learn(options_of(models::Feedback::kTeacher));
    fixture.network.update({});
    const Network::State after = fixture.network.weights();
    const auto words = floats(after, "encoder.embedding.weight");
    for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(words[i], 0);
    const auto w0 = floats(before, "decoder.lstm.weight_ih");
    const auto w1 = floats(after, "decoder.lstm.weight_ih");
    const auto gradient = fixture.network.gradients();
    const auto g = floats(gradient, "decoder.lstm.weight_ih");
    for (std::size_t i = 0; i < w0.size(); ++i) {
      if (i % (4 + features) < 4) continue;
      EXPECT_EQ(g[i], 0);
      // Adam's first step: the rate, but for epsilon beside 5e-4 times the weight.
      const double step = 1e-4 * 5e-4 * double{w0[i]} / (5e-4 * std::abs(double{w0[i]}) + 1e-8);
      EXPECT_NEAR(w1[i], double{w0[i]} - step, 5e-8);
    }
  }
}

TEST(Network, WithoutVisionFeaturesMakeNoDifference) {
  models::NetworkConfig config = small_config();
  config.inputs.vision = false;
  Fixture fixture(config);
  const double loss = fixture.learn(options_of(models::Feedback::kTeacher)).loss;
  for (float& x : fixture.environment.features()) x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(fixture.learn(options_of(models::Feedback::kTeacher)).loss, loss);
}

TEST(Network, WithoutLanguageInstructionsMakeNoDifference) {
  models::NetworkConfig config = small_config();
  config.inputs.language = false;
  Fixture fixture(config);
  const double loss = fixture.learn(options_of(models::Feedback::kTeacher)).loss;
  const Network::State gradients = fixture.network.gradients();
  // Only <EOS> is read, so of the others no embedding has a gradient.
  const auto words = floats(gradients, "encoder.embedding.weight");
  for (std::size_t i = 0; i < words.size(); ++i) EXPECT_EQ(words[i] != 0, i / 8 == 2);
  fixture.tokens = made_tokens(kEpisodes, 9, 13, 99);
  EXPECT_EQ(fixture.learn(options_of(models::Feedback::kTeacher)).loss, loss);
  fixture.rollout(options_of(models::Feedback::kArgmax),
                  [](const StepRecord& record) { EXPECT_EQ(record.words, 1); });
}

TEST(Network, AnEmptyBatchIsNoWork) {
  Network network(small_config(), 1);
  Script script;
  script.episodes = 0;
  script.dimensions = 20;
  ScriptedEnvironment environment(script);
  EXPECT_EQ(network.rollout({}, environment, {}).steps, 0);
  const RolloutResult result = network.rollout_with_gradients({}, environment, {});
  EXPECT_EQ(result.loss, 0);
  const Network::State gradients = network.gradients();
  for (const float g : floats(gradients, "decoder.lstm.weight_hh")) EXPECT_EQ(g, 0);
}

template <class Call>
void expect_refusal(const Call& call, const char* message) {
  EXPECT_THAT(call, ThrowsMessage<ArgumentError>(HasSubstr(message)));
}

TEST(Network, RefusesSizesThatDoNotFit) {
  Fixture fixture;
  const RolloutOptions options = options_of(models::Feedback::kArgmax);
  const auto with_tokens = [&](std::vector<std::uint32_t> tokens, std::size_t n) {
    return [&fixture, &options, tokens = std::move(tokens), n] {
      fixture.environment.begin();
      fixture.network.rollout({tokens, n}, fixture.environment, options);
    };
  };
  std::vector<std::uint32_t> tokens = fixture.tokens;
  expect_refusal(with_tokens(tokens, 5), "5 instructions for an environment of 6 episodes");
  tokens.pop_back();
  expect_refusal(with_tokens(tokens, 6), "53 ids for 6 instructions of 9 words");
  tokens = fixture.tokens;
  tokens[std::size_t{2} * 9] = 13;
  expect_refusal(with_tokens(tokens, 6), "instruction 2, word 0: id 13");
  tokens[std::size_t{2} * 9] = 0;
  expect_refusal(with_tokens(tokens, 6), "instruction 2 begins with PAD");
  Script script;
  script.episodes = kEpisodes;
  script.dimensions = 21;
  ScriptedEnvironment wide(script);
  expect_refusal([&] { fixture.network.rollout(fixture.batch(), wide, options); },
                 "features of 21 numbers, the network 20");
  RolloutOptions none = options;
  none.max_steps = 0;
  expect_refusal([&] { fixture.rollout(none); }, "max_steps: 0");
}

TEST(Network, RefusesWhatNeedsATeacherWithoutOne) {
  Script script;
  script.has_teacher = false;
  Fixture fixture(small_config(), script);
  EXPECT_EQ(fixture.rollout(options_of(models::Feedback::kArgmax)).loss, 0);
  expect_refusal([&] { fixture.rollout(options_of(models::Feedback::kTeacher)); }, "no teacher");
  expect_refusal([&] { fixture.learn(options_of(models::Feedback::kSample)); }, "no teacher");
}

TEST(Network, RefusesLabelsThatAreNone) {
  Fixture fixture;
  fixture.environment.labels()[3] = 6;
  expect_refusal([&] { fixture.learn(options_of(models::Feedback::kSample)); },
                 "label 6 of episode 3");
  fixture.environment.labels()[3] = 4;
  fixture.environment.forward_open()[3] = 0;
  expect_refusal([&] { fixture.learn(options_of(models::Feedback::kSample)); },
                 "label forward of episode 3, where forward is closed");
}

TEST(Network, RefusesConfigsThatMakeNoNetwork) {
  const auto with = [](auto change) {
    return [change] {
      models::NetworkConfig config = small_config();
      change(config);
      Network network(config, 1);
    };
  };
  expect_refusal(with([](auto& c) { c.vocabulary = 2; }), "vocabulary: 2, at least 3");
  expect_refusal(with([](auto& c) { c.hidden = 0; }), "hidden: 0");
  expect_refusal(with([](auto& c) { c.features = 0; }), "features: 0");
  expect_refusal(with([](auto& c) { c.dropout = 1; }), "dropout: 1");
  EXPECT_THROW(Network(small_config(), 1, "teapot"), Error);
}

TEST(Network, AGradientThatIsNotFiniteChangesNothing) {
  Fixture fixture;
  fixture.learn(options_of(models::Feedback::kTeacher));
  fixture.network.update({});
  const Network::State before = fixture.network.training_state();
  fixture.environment.features()[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isnan(fixture.learn(options_of(models::Feedback::kTeacher)).loss));
  EXPECT_THAT([&] { fixture.network.update({}); },
              ThrowsMessage<Error>(HasSubstr("gradient of encoder.")));
  EXPECT_TRUE(equal(fixture.network.training_state(), before));
  EXPECT_EQ(fixture.network.updates(), 1);
}

TEST(Network, GoesOnFromASavedTrainingStateToTheBit) {
  const TemporaryFolder folder("network");
  const auto file = folder.path() / "state.safetensors";
  RolloutOptions options = options_of(models::Feedback::kSample);
  options.dropout = true;
  Fixture a, b;
  const auto train = [&](Fixture& fixture, std::uint64_t from, std::uint64_t to) {
    for (options.stream = from; options.stream < to; ++options.stream) {
      fixture.learn(options);
      fixture.network.update({});
    }
  };
  train(a, 0, 3);
  features::write_safetensors(file, a.network.training_state().arrays);
  train(a, 3, 5);
  b.network.parameters().initialise(99);
  b.network.load_training_state(features::TensorFile::open(file));
  EXPECT_EQ(b.network.updates(), 3);
  train(b, 3, 5);
  EXPECT_TRUE(equal(a.network.training_state(), b.network.training_state()));
}

TEST(Network, NamesAllThatIsWrongWithAFile) {
  const TemporaryFolder folder("network");
  const auto file = folder.path() / "weights.safetensors";
  Fixture fixture;
  const Network::State before = fixture.network.weights();
  Network::State state = fixture.network.weights();
  state.arrays[0].name = "embedding";
  state.arrays[1].shape = {8, 96};
  features::write_safetensors(file, state.arrays);
  EXPECT_THAT([&] { fixture.network.load_weights(features::TensorFile::open(file)); },
              ThrowsMessage<InvalidInput>(::testing::AllOf(
                  HasSubstr("encoder.embedding.weight"), HasSubstr("embedding"),
                  HasSubstr("encoder.lstm.weight_ih_l0: is F32 [8, 96], not F32 [96, 8]"))));
  EXPECT_TRUE(equal(fixture.network.weights(), before));
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::seq2seq
