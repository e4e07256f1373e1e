#include "enfilade/neural/continuous/episode_file.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <numeric>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/continuous/gatherer.h"

namespace enfilade::neural::continuous {
namespace {

using features::DType;
using features::NamedArray;

// An array as the numbers that it has. \throws InvalidInput
template <class T>
std::span<const T> numbers(const features::TensorFile& file, const char* name, DType type,
                           std::int64_t rows, std::int64_t columns) {
  const NamedArray* const array = file.find(name);
  const std::vector<std::int64_t> shape =
      columns == 1 ? std::vector{rows} : std::vector{rows, columns};
  if (array == nullptr || array->type != type || array->shape != shape) {
    refuse(file.path().string(), name, "wrong-array",
           fmt::format("missing, or not of {} walks or steps with {} numbers of type {}", rows,
                       columns, enum_name(type)));
  }
  return {reinterpret_cast<const T*>(array->bytes.data()), array->elements()};
}

std::int64_t rows_of(const features::TensorFile& file, const char* name) {
  const NamedArray* const array = file.find(name);
  if (array == nullptr || array->shape.empty() || !file.metadata().contains("weights")) {
    refuse(file.path().string(), name, "missing-array", "not a file of recorded walks");
  }
  return array->shape[0];
}

template <class T>
void append(std::vector<T>& all, const std::vector<T>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

constexpr std::size_t kBatchesSorted = 16;

template <class T>
void append(std::vector<T>& all, std::span<const T> values, std::size_t step, std::size_t steps) {
  const std::size_t width = values.size() / steps;
  const std::span<const T> row = values.subspan(step * width, width);
  all.insert(all.end(), row.begin(), row.end());
}

}  // namespace

EpisodeView view_of(const RecordedEpisode& walk) {
  return {walk.episode, walk.seen.pictures, walk.seen.depth, walk.previous, walk.teacher};
}

EpisodeFile::EpisodeFile(const std::filesystem::path& path, std::size_t features)
    : file_(features::TensorFile::open(path)), features_(features) {
  const std::int64_t steps = rows_of(file_, "teacher"), walks = rows_of(file_, "episodes");
  if (features > 0) {
    pictures_ = numbers<std::uint16_t>(file_, "pictures", DType::kFloat16, steps,
                                       static_cast<std::int64_t>(features));
    depth_ = numbers<std::uint8_t>(file_, "depth", DType::kUint8, steps, kDepthSize);
  }
  previous_ = numbers<std::uint8_t>(file_, "previous", DType::kUint8, steps, 1);
  teacher_ = numbers<std::uint8_t>(file_, "teacher", DType::kUint8, steps, 1);
  episodes_ = numbers<std::int64_t>(file_, "episodes", DType::kInt64, walks, 1);
  first_.push_back(0);
  for (const std::int64_t n : numbers<std::int64_t>(file_, "steps", DType::kInt64, walks, 1)) {
    first_.push_back(first_.back() + static_cast<std::size_t>(n));
  }
  if (first_.back() != static_cast<std::size_t>(steps)) {
    refuse(path.string(), "steps", "wrong-sum",
           fmt::format("{} steps of walks, but there are {}", first_.back(), steps));
  }
}

EpisodeView EpisodeFile::walk(std::size_t i) const {
  const std::size_t first = first_[i], n = first_[i + 1] - first;
  EpisodeView view{static_cast<std::size_t>(episodes_[i]),
                   {},
                   {},
                   previous_.subspan(first, n),
                   teacher_.subspan(first, n)};
  if (features_ == 0) return view;
  view.pictures = pictures_.subspan(first * features_, n * features_);
  view.depth = depth_.subspan(first * kDepthSize, n * kDepthSize);
  return view;
}

void write_episodes(const std::filesystem::path& file, std::span<const RecordedEpisode> walks,
                    const std::string& weights) {
  RecordedEpisode all;
  std::vector<std::int64_t> episodes, steps;
  for (const RecordedEpisode& walk : walks) {
    append(all.seen.pictures, walk.seen.pictures);
    append(all.seen.depth, walk.seen.depth);
    append(all.previous, walk.previous);
    append(all.teacher, walk.teacher);
    episodes.push_back(static_cast<std::int64_t>(walk.episode));
    steps.push_back(std::ssize(walk.teacher));
  }
  const std::int64_t n = std::ssize(all.teacher), m = std::ssize(walks);
  std::vector<NamedArray> arrays;
  const auto add = [&](const char* name, DType type, std::vector<std::int64_t> shape,
                       const auto& values) {
    arrays.push_back({name, type, std::move(shape), std::as_bytes(std::span(values))});
  };
  if (!all.seen.pictures.empty()) {
    add("pictures", DType::kFloat16, {n, std::ssize(all.seen.pictures) / n}, all.seen.pictures);
    add("depth", DType::kUint8, {n, kDepthSize}, all.seen.depth);
  }
  add("previous", DType::kUint8, {n}, all.previous);
  add("teacher", DType::kUint8, {n}, all.teacher);
  add("episodes", DType::kInt64, {m}, episodes);
  add("steps", DType::kInt64, {m}, steps);
  features::write_safetensors(file, arrays, {{"weights", weights}});
}

UpdatePlace place_of(const models::Seq2SeqCeConfig& config, std::size_t batch,
                     std::uint64_t update) {
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

TrajectoryBatch side_by_side(std::span<const EpisodeView> walks, const Sizes& sizes) {
  std::vector<std::uint16_t> pictures;
  std::vector<std::uint8_t> depth;
  std::vector<std::int64_t> previous, teacher;
  TrajectoryBatch batch;
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
