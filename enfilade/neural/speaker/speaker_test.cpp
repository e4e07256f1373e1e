#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <gmock/gmock.h>
#include <cmath>
#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/optimizer.h"
#include "enfilade/neural/speaker/speaker_network.h"
#include "enfilade/tasks/tokenizer.h"
#include "tests/support/graphs.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::speaker {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::int64_t kBegin = 19;  // <BOS>

SpeakerConfig tiny(bool bidirectional = true) {
  SpeakerConfig config;
  config.vocabulary = 20;
  config.word_embedding = 6;
  config.hidden = 8;
  config.image = 3;
  config.angle = 4;
  config.bidirectional = bidirectional;
  config.dropout = 0;
  config.feature_dropout = 0;
  return config;
}

double farthest(const at::Tensor& a, const at::Tensor& b) {
  return (a - b).abs().max().item<double>();
}

// Five viewpoints in a row to the north, 2 m apart, and one to the east of the first.
class SpeakerTest : public ::testing::Test {
 protected:
  static std::shared_ptr<const graph::GraphSet> made() {
    const std::vector<Vec3d> points{{0, 0, 1.5}, {0, 2, 1.5}, {0, 4, 1.5},
                                    {0, 6, 1.5}, {0, 8, 1.5}, {2, 0, 1.5}};
    const std::vector<std::pair<int, int>> edges{{0, 1}, {1, 2}, {2, 3}, {3, 4}, {0, 5}};
    std::vector<graph::NavGraph> graphs;
    graphs.emplace_back(graph::testing::connectivity("made", points, edges));
    return graph::GraphSet::of(std::move(graphs));
  }
  static void pictures(graph::Location at, std::uint32_t view, std::span<float> out) {
    for (std::size_t c = 0; c < out.size(); ++c) {
      out[c] =
          static_cast<float>(std::sin(static_cast<double>(at.viewpoint.at() * 100 + view * 3 + c)));
    }
  }
  static PathToDescribe path(const std::vector<std::size_t>& viewpoints, double heading = 0) {
    PathToDescribe written{ScanIndex(0), Radians(heading), {}};
    for (const std::size_t v : viewpoints) written.viewpoints.emplace_back(v);
    return written;
  }
  PathBatch see(const std::vector<PathToDescribe>& paths, const SpeakerConfig& config = tiny(),
                const ImageSource& images = pictures) {
    return see_paths(paths, config, images, panoramas_, *graphs_);
  }
  // Eight different paths and sentences.
  std::vector<PathToDescribe> eight() const {
    return {path({0, 1, 2}), path({0, 5}),    path({5, 0, 1}), path({4, 3, 2, 1}),
            path({2, 3, 4}), path({1, 0, 5}), path({3}),       path({4, 3})};
  }
  static std::vector<std::vector<std::int64_t>> sentences() {
    return {{kBegin, 3, 4, 5, 2},      {kBegin, 6, 2},     {kBegin, 7, 3, 2}, {kBegin, 8, 8, 9, 2},
            {kBegin, 10, 4, 11, 3, 2}, {kBegin, 12, 6, 2}, {kBegin, 13, 2},   {kBegin, 14, 15, 2}};
  }

  std::shared_ptr<const graph::GraphSet> graphs_ = made();
  agents::PanoramaCache panoramas_{graphs_};
};

TEST_F(SpeakerTest, SeesTheChosenCandidatesAndNothingAtTheStop) {
  const PathBatch batch = see({path({0, 1, 2}), path({0, 5})});
  EXPECT_THAT(batch.lengths, ElementsAre(3, 2));
  ASSERT_EQ(batch.views.sizes(), (at::IntArrayRef{2, 3, 36, 7}));
  // North is straight on, so sin 0 and cos 0 of the heading.
  EXPECT_NEAR(batch.actions[0][0][3].item<double>(), 0, 1e-6);
  EXPECT_NEAR(batch.actions[0][0][4].item<double>(), 1, 1e-6);
  EXPECT_NEAR(batch.actions[1][0][3].item<double>(), 1, 1e-6) << "east";
  EXPECT_GT(batch.actions[0][0].narrow(0, 0, 3).abs().sum().item<double>(), 0);
  EXPECT_EQ(batch.actions[0][2].abs().sum().item<double>(), 0) << "stop";
  EXPECT_EQ(batch.actions[1].narrow(0, 1, 2).abs().sum().item<double>(), 0);
  EXPECT_EQ(batch.views[1][2].abs().sum().item<double>(), 0) << "behind the end";
  EXPECT_NEAR(batch.views[0][1][5][0].item<double>(), std::sin(115.0), 1e-6);
}

TEST_F(SpeakerTest, RefusesPathsThatCannotBeWalked) {
  EXPECT_THAT(tests::refusal<ArgumentError>([&] {
                see({path({0, 1}), path({0, 2})});
              }),
              HasSubstr("paths[1]: viewpoint 1 is no neighbour"));
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { see({path({})}); }),
              HasSubstr("paths[0]: no viewpoint"));
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { see({}); }), HasSubstr("none"));
}

TEST_F(SpeakerTest, APathReadsTheSameInAnyBatch) {
  const c10::NoGradGuard guard;
  for (const bool bidirectional : {true, false}) {
    SpeakerNetwork network(tiny(bidirectional), 1);
    const PathEncoding alone = network.encode(see({path({0, 5})}));
    const PathEncoding both = network.encode(see({path({0, 5}), path({0, 1, 2, 3})}));
    EXPECT_LT(farthest(both.context[0].narrow(0, 0, 2), alone.context[0]), 1e-6);
    EXPECT_EQ(both.context[0].narrow(0, 2, 2).abs().sum().item<double>(), 0);
    EXPECT_TRUE(both.mask[0][2].item<bool>());
    EXPECT_FALSE(both.mask[1].any().item<bool>());
  }
}

at::Tensor gate(const at::Tensor& gates, std::int64_t k) { return gates.narrow(1, 8 * k, 8); }

// An LSTM's first hidden state, by its equations.
at::Tensor first_state(const SpeakerNetwork& network, const std::string& name,
                       const at::Tensor& x) {
  const at::Tensor gates =
      at::linear(x, network.weight(name + ".weight_ih_l0"), network.weight(name + ".bias_ih_l0")) +
      network.weight(name + ".bias_hh_l0");
  return at::sigmoid(gate(gates, 3)) *
         at::tanh(at::sigmoid(gate(gates, 0)) * at::tanh(gate(gates, 2)));
}

TEST_F(SpeakerTest, OneStepAndOneWordAreWhatTheEquationsSay) {
  const c10::NoGradGuard guard;
  SpeakerNetwork network(tiny(false), 3);
  const PathBatch batch = see({path({3})});
  const at::Tensor read = first_state(network, "encoder.lstm", batch.actions[0]);
  const at::Tensor views = batch.views[0][0];
  const at::Tensor scores = at::mv(
      views, at::linear(read, network.weight("encoder.attention_layer.linear_in.weight"))[0]);
  const at::Tensor attended = at::mv(views.t(), at::softmax(scores, 0)).unsqueeze(0);
  const at::Tensor seen = at::tanh(at::linear(
      at::cat({attended, read}, 1), network.weight("encoder.attention_layer.linear_out.weight")));
  const at::Tensor context = first_state(network, "encoder.post_lstm", seen);
  const PathEncoding encoding = network.encode(batch);
  EXPECT_LT(farthest(encoding.context[0], context), 1e-6);
  // One step to attend to, so its share is 1.
  const at::Tensor word = network.weight("decoder.embedding.weight")[5].unsqueeze(0);
  const at::Tensor said = first_state(network, "decoder.lstm", word);
  const at::Tensor tilde = at::tanh(at::linear(
      at::cat({context, said}, 1), network.weight("decoder.attention_layer.linear_out.weight")));
  const at::Tensor expected = at::linear(tilde, network.weight("decoder.projection.weight"),
                                         network.weight("decoder.projection.bias"));
  SpeakerState state = network.begin(1);
  const at::Tensor logits = network.decode(encoding, at::full({1, 1}, 5, at::kLong), state);
  EXPECT_LT(farthest(logits[0], expected), 1e-6);
}

TEST_F(SpeakerTest, WordsOneByOneGiveTheLogitsOfAllAtOnce) {
  const c10::NoGradGuard guard;
  SpeakerNetwork network(tiny(), 1);
  const PathEncoding encoding = network.encode(see({path({0, 1, 2}), path({0, 5})}));
  const at::Tensor words =
      pad_sentences(std::vector<std::vector<std::int64_t>>{{kBegin, 4, 5, 2}, {kBegin, 6, 2}});
  SpeakerState whole_state = network.begin(2), state = network.begin(2);
  const at::Tensor whole = network.decode(encoding, words, whole_state);
  for (std::int64_t t = 0; t < 4; ++t) {
    const at::Tensor one = network.decode(encoding, words.narrow(1, t, 1), state);
    EXPECT_LT(farthest(one.squeeze(1), whole.select(1, t)), 1e-6);
  }
  EXPECT_LT(farthest(state.hidden, whole_state.hidden), 1e-6);
}

TEST_F(SpeakerTest, LossIsTheMeanOverWordsWithoutPadding) {
  SpeakerNetwork network(tiny(), 1);
  const PathBatch batch = see({path({0, 1, 2}), path({0, 5})});
  const at::Tensor words =
      pad_sentences(std::vector<std::vector<std::int64_t>>{{kBegin, 4, 5, 2}, {kBegin, 6, 2}});
  const InstructionLoss loss = instruction_loss(network, batch, words);
  const c10::NoGradGuard guard;
  SpeakerState state = network.begin(2);
  const at::Tensor logs = at::log_softmax(network.decode(network.encode(batch), words, state), 2);
  const auto log = [&](std::int64_t i, std::int64_t t, std::int64_t id) {
    return logs[i][t][id].item<double>();
  };
  const double sum = -(log(0, 0, 4) + log(0, 1, 5) + log(0, 2, 2) + log(1, 0, 6) + log(1, 1, 2));
  EXPECT_EQ(loss.words, 5U);
  EXPECT_NEAR(loss.sum, sum, 1e-5);
  EXPECT_NEAR(loss.mean.item<double>(), sum / 5, 1e-5);
  EXPECT_LE(loss.correct, 5U);
}

TEST_F(SpeakerTest, GradientsAreThoseOfFiniteDifferences) {
  SpeakerNetwork network(tiny(), 7);
  const PathBatch batch = see({path({0, 5}), path({4, 3, 2, 1})});
  const at::Tensor words =
      pad_sentences(std::vector<std::vector<std::int64_t>>{{kBegin, 4, 5, 2}, {kBegin, 6, 2}});
  const auto loss = [&] { return instruction_loss(network, batch, words); };
  loss().mean.backward();
  constexpr double kStep = 1e-2;
  const c10::NoGradGuard guard;
  for (const auto& [name, weight] : network.weights()) {
    ASSERT_TRUE(weight.grad().defined()) << name;
    // The number with the largest gradient says most.
    const auto at = weight.grad().abs().view(-1).argmax().item<std::int64_t>();
    const at::Tensor flat = weight.detach().view(-1);
    const double before = flat[at].item<double>();
    flat[at] = before + kStep;
    const double above = loss().sum / 5;
    flat[at] = before - kStep;
    const double below = loss().sum / 5;
    flat[at] = before;
    EXPECT_NEAR(weight.grad().view(-1)[at].item<double>(), (above - below) / (2 * kStep), 1e-3)
        << name;
  }
  EXPECT_EQ(network.weight("decoder.embedding.weight").grad()[0].abs().sum().item<double>(), 0)
      << "padding";
}

models::TrainConfig adam(double rate) {
  models::TrainConfig config;
  config.optimizer = models::Optimizer::kAdam;
  config.adam.learning_rate = rate;
  config.adam.weight_decay = 0;
  return config;
}

TEST_F(SpeakerTest, LearnsEightPathsByHeart) {
  SpeakerConfig config = tiny();
  config.hidden = 32;
  SpeakerNetwork network(config, 1);
  core::WeightOptimizer optimizer(core::optimizer_of(adam(1e-2), {"encoder.", "decoder."}));
  const PathBatch batch = see(eight());
  const at::Tensor words = pad_sentences(sentences());
  double first = 0, last = 0;
  for (int i = 0; i < 200; ++i) {
    const InstructionLoss loss = instruction_loss(network, batch, words);
    loss.mean.backward();
    optimizer.update(network.weights());
    (i == 0 ? first : last) = loss.mean.item<double>();
  }
  EXPECT_GT(first, 2.5) << "about the logarithm of 20";
  EXPECT_LT(last, 0.1);
  DescribeOptions options;
  options.begin = kBegin;
  const auto written = describe(network, batch, options);
  const auto all = sentences();
  for (std::size_t i = 0; i < written.size(); ++i) {
    const auto& truth = all[i];
    EXPECT_EQ(written[i], std::vector<std::int64_t>(truth.begin() + 1, truth.end() - 1)) << i;
  }
}

TEST_F(SpeakerTest, DrawnWordsFollowSeedAndStream) {
  SpeakerNetwork network(tiny(), 1);
  const PathBatch batch = see(eight());
  DescribeOptions options;
  options.begin = kBegin;
  options.choice = WordChoice::kDrawn;
  options.most_words = 12;
  const auto written = describe(network, batch, options);
  EXPECT_EQ(written, describe(network, batch, options));
  options.seed = 2;
  EXPECT_NE(written, describe(network, batch, options));
  options.seed = 1;
  options.streams = {7, 6, 5, 4, 3, 2, 1, 0};
  EXPECT_NE(written, describe(network, batch, options));
  std::set<std::int64_t> said;
  for (const auto& sentence : written) {
    EXPECT_LE(sentence.size(), 12U);
    said.insert(sentence.begin(), sentence.end());
  }
  for (const std::int64_t never : {std::int64_t{0}, std::int64_t{1}, kBegin}) {
    EXPECT_FALSE(said.contains(never)) << never;
  }
  options.streams = {1};
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { describe(network, batch, options); }),
              HasSubstr("streams: 1 for 8 paths"));
  options.begin = 20;
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { describe(network, batch, options); }),
              HasSubstr("begin: id 20, not from 3 to 19"));
}

TEST_F(SpeakerTest, DropoutFollowsItsSeedAndSparesDirections) {
  const c10::NoGradGuard guard;
  SpeakerConfig config = tiny();
  config.feature_dropout = 0.5;
  SpeakerNetwork network(config, 1);
  PathBatch batch = see({path({0, 1, 2})});
  const auto context = [&](std::optional<std::uint64_t> seed) {
    network.set_dropout(seed);
    return network.encode(batch).context;
  };
  const at::Tensor plain = context(std::nullopt);
  EXPECT_TRUE(context(5).equal(context(5)));
  EXPECT_FALSE(context(5).equal(plain));
  batch.dropped = FeaturesDropped::kBefore;
  EXPECT_TRUE(context(5).equal(plain)) << "pictures are left as they are, nothing else is dropped";
}

TEST_F(SpeakerTest, EnvironmentsLackTheSameColumnsEverywhere) {
  SpeakerConfig config = tiny();
  config.image = 40;
  EnvironmentalDropoutOptions options;
  options.rate = 0.5;
  const ImageSource ones = [](graph::Location, std::uint32_t, std::span<float> out) {
    std::ranges::fill(out, 1.0F);
  };
  const PathBatch batch =
      see({path({0, 1, 2}), path({4, 3, 2})}, config, drop_environment(ones, options));
  const std::vector<float> factors = column_factors(options, 40);
  const at::Tensor expected = at::tensor(factors);
  EXPECT_EQ(farthest(batch.views.narrow(3, 0, 40), expected.expand({2, 3, 36, 40})), 0);
  EXPECT_EQ(farthest(batch.actions.narrow(2, 0, 40).narrow(1, 0, 2), expected.expand({2, 2, 40})),
            0);
  EXPECT_THAT(factors, Each(::testing::AnyOf(0.0F, 2.0F)));
  EXPECT_EQ(std::set<float>(factors.begin(), factors.end()).size(), 2U);
  EXPECT_EQ(factors, column_factors(options, 40));
  options.stream = 9;
  EXPECT_NE(factors, column_factors(options, 40));
  options.rate = 1;
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { drop_environment(ones, options); }),
              HasSubstr("environmental dropout: 1, not in [0, 1)"));
}

TEST(EnvironmentalDropout, DropsItsShare) {
  EnvironmentalDropoutOptions options;
  options.rate = 0.3;
  const std::vector<float> factors = column_factors(options, 10'000);
  const auto kept = std::ranges::count_if(factors, [](float f) { return f > 0; });
  EXPECT_NEAR(static_cast<double>(kept) / 10'000, 0.7, 0.03) << "seven standard deviations";
  EXPECT_NEAR(std::accumulate(factors.begin(), factors.end(), 0.0) / 10'000, 1, 0.03);
}

TEST(SpeakerNetwork, ReadsAFileOrTellsWhatIsWrong) {
  const tests::TemporaryFolder folder("speaker");
  const auto file = folder.path() / "speaker.safetensors";
  const SpeakerNetwork network(tiny(), 4);
  core::Weights weights = network.weights();
  // What released checkpoints have beside.
  weights.emplace("decoder.baseline_projection.0.weight", at::zeros({128, 8}));
  features::write_safetensors(file, core::as_arrays(weights));
  const auto read = features::TensorFile::open(file);
  SpeakerConfig config = tiny();
  const SpeakerNetwork loaded(config, read);
  for (const auto& [name, values] : network.weights()) {
    EXPECT_TRUE(values.equal(loaded.weight(name))) << name;
  }
  config.hidden = 10;
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { SpeakerNetwork(config, read); }),
              AllOf(HasSubstr("encoder.lstm.weight_hh_l0"), HasSubstr("[20, 5] is expected")));
}

TEST(SpeakerNetwork, RefusesWhatDoesNotFit) {
  SpeakerNetwork network(tiny(), 1);
  PathBatch batch{at::zeros({1, 2, 7}), at::zeros({1, 2, 36, 7}), {2}};
  EXPECT_EQ(network.encode(batch).context.size(2), 8);
  batch.lengths = {3};
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { network.encode(batch); }),
              HasSubstr("a length of 3, not from 1 to 2"));
  batch.lengths = {2, 2};
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { network.encode(batch); }),
              HasSubstr("not of equally many paths"));
  batch.lengths = {2};
  SpeakerState state = network.begin(1);
  const PathEncoding encoding = network.encode(batch);
  EXPECT_THAT(tests::refusal<ArgumentError>([&] {
                network.decode(encoding, at::full({1, 1}, 20, at::kLong), state);
              }),
              HasSubstr("id 20, not from 0 to 19"));
  SpeakerConfig config = tiny();
  config.hidden = 7;
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { validate(config); }), HasSubstr("hidden: 7"));
  config = tiny();
  config.dropout = 1;
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { validate(config); }), HasSubstr("dropout"));
}

std::vector<std::string> words_of(const std::string& text) { return tasks::tokenize(text); }

// Worked out by hand.
TEST(Bleu, IsTheMeanOfMatchesTimesBrevity) {
  const std::vector<Generated> same{
      {words_of("go to the door"), {words_of("go to the door"), words_of("leave")}}};
  EXPECT_NEAR(bleu_4(same), 1, 1e-12);
  // 1-grams 4 of 5, 2-grams 3 of 4, 3-grams 2 of 3, 4-grams 1 of 2; longer than the shortest
  // reference.
  const std::vector<Generated> longer{
      {words_of("go to the door now"), {words_of("please go to the door"), words_of("go to it")}}};
  EXPECT_NEAR(bleu_4(longer), std::pow(4.0 / 5 * 3 / 4 * 2 / 3 * 1 / 2, 0.25), 1e-12);
  // All match; 4 words instead of 5.
  const std::vector<Generated> shorter{
      {words_of("go to the door"), {words_of("go to the door now")}}};
  EXPECT_NEAR(bleu_4(shorter), std::exp(1 - 5.0 / 4), 1e-12);
  // "the" is in the reference once: 1 of 4; no 2-gram matches.
  const std::vector<Generated> repeated{
      {words_of("the the the the"), {words_of("go to the door")}}};
  EXPECT_EQ(bleu_4(repeated), 0);
  EXPECT_EQ(bleu_4({}), 0);
  const std::vector<Generated> silent{{{}, {words_of("go")}}};
  EXPECT_EQ(bleu_4(silent), 0);
}

TEST(JoinWords, IsTakenApartIntoTheSameWords) {
  const std::vector<std::vector<std::string>> all{
      {"walk", "past", "the", "table", ",", "then", "stop", "."},
      {"turn", "left", "...", "go", "(", "slowly", ")", "."},
      {"don", "'", "t", "stop", ",", ",", "."},
      {"."},
      {}};
  for (const auto& words : all) EXPECT_EQ(tasks::tokenize(join_words(words)), words);
  EXPECT_EQ(join_words(all[0]), "walk past the table, then stop.");
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::speaker
