#include "enfilade/neural/seq2seq/seq2seq_agent.h"

#include <algorithm>
#include <utility>

namespace enfilade::neural::seq2seq {

void Seq2SeqAgent::enter(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) {
  split_.emplace(prepare(episodes, model_.vocabulary, model_.config.training.network.max_words,
                         usable_features(model_.config, features)));
}

std::vector<tasks::Trajectory> Seq2SeqAgent::walk(const SplitRollout& options,
                                                  const Progress& progress) {
  GreedyRollout walk = rollout_greedily(
      model_.network, *split_,
      {options.batch_size, model_.config.training.max_steps, options.ranks}, progress);
  if (!options.results.empty() && (options.ranks == nullptr || options.ranks->is_first())) {
    write_rollout(options.results, options.attention, walk, *split_, model_.vocabulary);
  }
  return std::move(walk.trajectories);
}

void Seq2SeqAgent::start(std::span<const agents::Observation> batch) {
  const std::size_t words = model_.config.training.network.max_words;
  std::vector<std::uint32_t> tokens;
  tokens.reserve(batch.size() * words);
  scans_.clear();
  for (const agents::Observation& seen : batch) {
    const auto row = model_.vocabulary.encode(seen.episode->text, words);
    tokens.insert(tokens.end(), row.begin(), row.end());
    if (features() != nullptr) scans_.push_back(features()->scan(seen.graph->scan()));
  }
  seen_.resize(batch.size() * model_.config.training.network.features);
  forward_open_.resize(batch.size());
  actions_.resize(batch.size());
  model_.network.begin({tokens, batch.size()}, model_.config.training.max_steps);
}

void Seq2SeqAgent::act(std::span<const agents::Observation> batch,
                       std::span<agents::Decision> decisions) {
  // Stops the agents that have not chosen `end` yet: all episodes began at the same time.
  if (!batch.empty() && batch[0].step >= model_.config.training.max_steps) {
    std::ranges::fill(decisions, agents::Decision::stop_here());
    return;
  }
  for (std::size_t i = 0; i < batch.size(); ++i) {
    forward_open_[i] = batch[i].navigable.size() > 1 ? 1 : 0;
    if (features() == nullptr) continue;
    const std::size_t n = features()->dimensions();
    features()->copy(scans_[i], batch[i].viewpoint, batch[i].view_index,
                     std::span(seen_).subspan(i * n, n));
  }
  model_.network.act(seen_, forward_open_, actions_);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const auto count = static_cast<std::uint32_t>(batch[i].navigable.size());
    decisions[i] = to_decision(static_cast<SixAction>(actions_[i]), count);
  }
}

}  // namespace enfilade::neural::seq2seq
