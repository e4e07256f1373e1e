#include "enfilade/neural/core/batches.h"

#include "enfilade/core/check.h"
#include "enfilade/core/rng.h"
#include "enfilade/models/decisions.h"

namespace enfilade::neural::core {

EpisodeOrder::EpisodeOrder(std::size_t episodes, std::size_t batch_size, std::uint64_t seed)
    : seed_(seed), order_(episodes), batch_(batch_size) {
  EN_CHECK(episodes > 0);
  EN_CHECK(batch_size > 0);
  shuffle(0);
}

std::span<const std::size_t> EpisodeOrder::batch(std::uint64_t iteration) {
  const std::uint64_t first = iteration * batch_.size();
  for (std::size_t i = 0; i < batch_.size(); ++i) {
    const std::uint64_t pass = (first + i) / order_.size();
    if (pass != pass_) shuffle(pass);
    batch_[i] = order_[(first + i) % order_.size()];
  }
  return batch_;
}

void EpisodeOrder::shuffle(std::uint64_t pass) {
  pass_ = pass;
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  Rng(seed_, pass).shuffle(std::span(order_));
}

namespace {

// What goes over, in this order.
void for_fields(auto& trajectory, const auto& visit) {
  visit(trajectory.episode);
  visit(trajectory.points);
  visit(trajectory.actions);
  visit(trajectory.turning_point);
  visit(trajectory.object);
  visit(trajectory.point);
}

}  // namespace

std::string packed_trajectories(std::span<const tasks::Trajectory> trajectories) {
  ValuePacker packer;
  for (const tasks::Trajectory& one : trajectories) {
    for_fields(one, [&](const auto& field) { packer.add(field); });
  }
  return packer.take();
}

std::vector<tasks::Trajectory> unpacked_trajectories(std::span<const std::string> batches) {
  std::vector<tasks::Trajectory> trajectories;
  for (const std::string& batch : batches) {
    for (Unpacker unpacker(batch); !unpacker.done();) {
      for_fields(trajectories.emplace_back(), [&](auto& field) { unpacker.read(field); });
    }
  }
  return trajectories;
}

void write_decisions(Ranks& ranks, const SplitRollout& options,
                     const models::DecisionRecorder& recorder, const tasks::EpisodeSet& episodes,
                     const std::vector<tasks::Trajectory>& trajectories) {
  if (ranks.alone()) {
    return options.write(options.attention, recorder.text(episodes, trajectories));
  }
  const auto shown =
      models::shown_episodes(trajectories, episodes, models::DecisionRecorder::kShown);
  std::vector<std::pair<std::string, models::EpisodeDecisions>> own, all;
  for (const std::size_t i : shown) {
    const std::size_t batch = i / options.batch_size;
    if (static_cast<int>(batch % static_cast<std::size_t>(ranks.size())) != ranks.rank()) continue;
    own.emplace_back(episodes.episodes[i].instruction_id, recorder.episode(i, episodes));
  }
  // The text rounds what it has; read and written again it stays the same.
  models::DecisionFile found;
  for (const std::string& text : ranks.gather(models::decisions_json(own))) {
    if (ranks.is_first()) found.merge(models::parse_decisions(text, "decisions of another rank"));
  }
  if (!ranks.is_first()) return;
  for (const std::size_t i : shown) {
    const std::string& name = episodes.episodes[i].instruction_id;
    all.emplace_back(name, std::move(found.at(name)));
  }
  options.write(options.attention, models::decisions_json(all));
}

}  // namespace enfilade::neural::core
