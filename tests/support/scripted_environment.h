/// \file  Episodes for the network alone: what they show was drawn beforehand.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/seq2seq/network.h"

namespace enfilade::tests {

struct Script {
  std::size_t episodes = 4;
  std::size_t dimensions = 0;
  std::size_t steps = 5;  ///< drawn; a rollout may take fewer
  bool has_teacher = true;
  /// Episode i counts no more from its step i + 1 on, and all are over when the last one's is.
  bool ends = false;
};

/// Shows the same to every rollout, whatever the actions, so that a loss is a smooth function of
/// the weights; keeps the actions. begin() again before each rollout.
class ScriptedEnvironment final : public neural::seq2seq::Environment {
 public:
  explicit ScriptedEnvironment(const Script& script, std::uint64_t seed = 1) : script_(script) {
    const std::size_t rows = script.steps * script.episodes;
    Rng rng(seed);
    for (std::size_t i = 0; i < rows; ++i) {
      const std::size_t step = i / script.episodes, episode = i % script.episodes;
      open_.push_back(rng.uniform() < 0.75 ? 1 : 0);
      auto label = static_cast<std::int32_t>(rng.below(neural::seq2seq::kSixActionCount));
      if (label == kForward && open_.back() == 0) label = 0;
      labels_.push_back(script.ends && step > episode ? neural::seq2seq::kIgnoreLabel : label);
      for (std::size_t k = 0; k < script.dimensions; ++k) {
        features_.push_back(static_cast<float>(rng.uniform() * 2 - 0.5));
      }
    }
    ended_.resize(script.episodes);
    begin();
  }

  void begin() {
    step_ = 0;
    actions.clear();
    std::ranges::fill(ended_, std::uint8_t{0});
  }

  std::size_t size() const override { return script_.episodes; }
  std::size_t dimensions() const override { return script_.dimensions; }
  bool has_teacher() const override { return script_.has_teacher; }
  void observe(const neural::seq2seq::EnvironmentView& out) override {
    const std::size_t n = script_.episodes, begin = step_ * n, width = script_.dimensions;
    std::ranges::copy(std::span(features_).subspan(begin * width, n * width), out.features.begin());
    std::ranges::copy(std::span(open_).subspan(begin, n), out.forward_open.begin());
    if (out.labels.empty()) return;
    std::ranges::copy(std::span(labels_).subspan(begin, n), out.labels.begin());
  }
  bool step(std::span<const std::int32_t> taken) override {
    actions.insert(actions.end(), taken.begin(), taken.end());
    ++step_;
    if (!script_.ends) return step_ < script_.steps;
    for (std::size_t i = 0; i < ended_.size(); ++i) ended_[i] = step_ > i ? 1 : 0;
    return std::ranges::find(ended_, std::uint8_t{0}) != ended_.end();
  }
  std::span<const std::uint8_t> ended() const override { return ended_; }

  std::vector<std::int32_t>& labels() { return labels_; }      ///< (steps, n)
  std::vector<std::uint8_t>& forward_open() { return open_; }  ///< (steps, n)
  std::vector<float>& features() { return features_; }         ///< (steps, n, dimensions)
  std::vector<std::int32_t> actions;                           ///< (steps so far, n)

 private:
  static constexpr auto kForward = static_cast<std::int32_t>(neural::seq2seq::SixAction::kForward);

  Script script_;
  std::size_t step_ = 0;
  std::vector<std::uint8_t> open_, ended_;
  std::vector<std::int32_t> labels_;
  std::vector<float> features_;
};

/// n instructions of 1 to `longest` words, the rest PAD; word ids from 2 on, so <EOS> is one.
inline std::vector<std::uint32_t> made_tokens(std::size_t n, std::size_t max_words,
                                              std::size_t vocabulary, std::uint64_t seed = 1) {
  Rng rng(seed);
  std::vector<std::uint32_t> tokens(n * max_words);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t length = 1 + rng.below(max_words);
    for (std::size_t k = 0; k < length; ++k) {
      tokens[i * max_words + k] = static_cast<std::uint32_t>(2 + rng.below(vocabulary - 2));
    }
  }
  return tokens;
}

}  // namespace enfilade::tests
