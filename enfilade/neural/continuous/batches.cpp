#include "enfilade/neural/continuous/batches.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <numeric>

#include "enfilade/core/check.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/continuous/episode_states.h"

namespace enfilade::neural::continuous {
namespace {

constexpr std::size_t kBatchesSorted = 16;

template <class T>
void append(std::vector<T>& all, std::span<const T> values, std::size_t step, std::size_t steps) {
  const std::size_t width = values.size() / steps;
  const std::span<const T> row = values.subspan(step * width, width);
  all.insert(all.end(), row.begin(), row.end());
}

}  // namespace

Place place_of(const models::Seq2SeqCeConfig& config, std::size_t batch, std::uint64_t update) {
  std::uint64_t left = update;
  for (std::size_t sets = 1;; ++sets) {
    EN_CHECK(sets <= config.sets);
    const std::uint64_t pass = (sets * config.set_walks + batch - 1) / batch;
    if (left < config.epochs * pass) {
      return {sets, static_cast<std::size_t>(left / pass), static_cast<std::size_t>(left % pass)};
    }
    left -= config.epochs * pass;
  }
}

std::vector<std::vector<std::size_t>> pass_over(std::span<const std::size_t> lengths,
                                                std::size_t batch, std::uint64_t seed,
                                                std::uint64_t pass) {
  constexpr char kName[] = "pass over walks";
  Rng rng(seed, stream_of(kName, sizeof kName - 1), pass);
  std::vector<std::size_t> order(lengths.size());
  std::iota(order.begin(), order.end(), 0);
  rng.shuffle(std::span(order));
  std::vector<std::vector<std::size_t>> batches;
  for (std::size_t first = 0; first < order.size(); first += kBatchesSorted * batch) {
    const std::span<std::size_t> part =
        std::span(order).subspan(first, std::min(kBatchesSorted * batch, order.size() - first));
    std::ranges::stable_sort(part, std::ranges::greater{},
                             [&](std::size_t walk) { return lengths[walk]; });
    for (std::size_t k = 0; k < part.size(); k += batch) {
      const auto one = part.subspan(k, std::min(batch, part.size() - k));
      batches.emplace_back(one.begin(), one.end());
    }
  }
  rng.shuffle(std::span(batches));
  return batches;
}

EpisodeBatch side_by_side(std::span<const EpisodeView> walks, const Sizes& sizes) {
  std::vector<std::uint16_t> pictures;
  std::vector<std::uint8_t> depth;
  std::vector<std::int64_t> previous, teacher;
  EpisodeBatch batch;
  for (const EpisodeView& walk : walks) batch.episodes.push_back(walk.episode);
  for (std::size_t t = 0; t < walks.front().steps(); ++t) {
    std::int64_t count = 0;
    for (const EpisodeView& walk : walks) {
      if (walk.steps() <= t) break;
      append(pictures, walk.pictures, t, walk.steps());
      append(depth, walk.depth, t, walk.steps());
      previous.push_back(walk.previous[t]);
      teacher.push_back(walk.teacher[t]);
      ++count;
    }
    batch.steps.counts.push_back(count);
  }
  const std::int64_t rows = std::ssize(teacher);
  batch.steps.pictures = picture_numbers(pictures, rows, sizes);
  batch.steps.depth = depth_numbers(depth, rows);
  batch.steps.previous = at::tensor(previous, at::kLong);
  batch.teacher = at::tensor(teacher, at::kLong);
  return batch;
}

}  // namespace enfilade::neural::continuous
