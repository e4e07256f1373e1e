#include "bench/products.h"

#include <gtest/gtest.h>

#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/seq2seq/seq2seq.h"
#include "tests/support/scripted_environment.h"

namespace enfilade::bench {
namespace EN_UNIT {

// Of sizes that can be counted by hand: no vision, one word an instruction (no language).
TEST(Products, ThoseOfANetworkAreRecorded) {
  constexpr std::size_t kEpisodes = 6;
  models::NetworkConfig config;
  config.vocabulary = 13;
  config.word_embedding = 8;
  config.action_embedding = 4;
  config.hidden = 24;
  config.features = 0;
  config.max_words = 9;
  config.inputs = {.language = false, .vision = false};
  neural::seq2seq::Network network(config, 7);
  tests::ScriptedEnvironment environment({.episodes = kEpisodes});
  const std::vector<std::uint32_t> tokens(kEpisodes * config.max_words, 5);
  neural::seq2seq::RolloutOptions options;
  options.feedback = models::Feedback::kArgmax;
  options.max_steps = 5;
  ProductLog log;
  {
    const ProductRecorder recorder(log);
    network.rollout({tokens, kEpisodes}, environment, options);
  }
  double found = 0;
  for (const Product& product : log) found += product.operations();
  // Word (8) and start; then at each of 5 steps action (4), cell, attention, output, logits.
  const double encoder = 8 * 96 + 24 * 24;
  const double step = 4 * 96 + 24 * 96 + 24 * 24 + 48 * 24 + 24 * 6;
  EXPECT_EQ(found, 2.0 * kEpisodes * (encoder + 5 * step));
  ProductTimer(log).run();
  EXPECT_EQ(log.size(), 2 + 5 * 5);  // those of the timer are not recorded
}

}  // namespace EN_UNIT
}  // namespace enfilade::bench
