#include "enfilade/neural/core/gradient_sum.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <c10/core/StreamGuard.h>
#include <c10/core/impl/VirtualGuardImpl.h>
#include <fmt/format.h>
#include <torch/csrc/autograd/function.h>
#include <torch/csrc/autograd/function_hook.h>
#include <torch/csrc/autograd/variable.h>
#include <bit>
#include <numeric>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/neural/core/packing.h"

namespace enfilade::neural::core {
namespace {

// Adds up in the tree, one behind the other: a sum of 2^k values is joined with the one before it
// if that is of as many.
template <class Join>
void join_pairs(std::size_t added, const Join& join) {
  for (std::size_t n = added; n % 2 == 0; n /= 2) join();
}

}  // namespace

BatchParts share_parts(std::size_t parts, const Ranks& ranks) {
  const auto size = static_cast<std::size_t>(ranks.size());
  const auto rank = static_cast<std::size_t>(ranks.rank());
  if (parts == 0) return {size, rank, 1, false};
  if (parts % size != 0 || (size > 1 && !std::has_single_bit(parts / size))) {
    std::string allowed = "1";
    for (std::size_t n = 2; n <= parts; ++n) {
      if (parts % n == 0 && std::has_single_bit(parts / n)) allowed += fmt::format(", {}", n);
    }
    throw ArgumentError(
        fmt::format("parts: {}, in {} processes; this number of parts is shared by {} processes",
                    parts, size, allowed));
  }
  const std::size_t own = parts / size;
  return {parts, rank * own, own, true};
}

std::span<const std::size_t> part_of(std::span<const std::size_t> batch, std::size_t k,
                                     std::size_t n) {
  const std::size_t begin = k * batch.size() / n, end = (k + 1) * batch.size() / n;
  return batch.subspan(begin, end - begin);
}

void Handover::give(c10::Device device) {
  if (device.is_cpu()) return;
  if (!event_) event_.emplace(device.type());
  event_->record(c10::impl::VirtualGuardImpl(device.type()).getStream(device));
}

void Handover::take(c10::Device device) const {
  if (event_) event_->block(c10::impl::VirtualGuardImpl(device.type()).getStream(device));
}

GradientSum::GradientSum(Ranks& ranks, const BatchParts& parts, std::vector<std::int64_t> sizes,
                         c10::Device device, std::size_t bucket)
    : ranks_(ranks),
      parts_(parts),
      sizes_(std::move(sizes)),
      device_(device),
      bucket_bytes_(bucket) {
  sizes_.push_back(std::ssize(sizes_) + 1);
  notes_ = at::zeros({sizes_.back()}, at::kFloat);
  // Autograd comes to the weights that were used last first; the first batch shows the true order.
  std::vector<std::size_t> order(sizes_.size() - 1);
  std::iota(order.rbegin(), order.rend(), std::size_t{0});
  order.push_back(sizes_.size() - 1);
  lay_out(order);
  if (ranks_.alone()) return;
  if (!device_.is_cpu()) connect_cards(ranks_, device_);
  sender_ = std::thread([this] { communicate(); });
}

GradientSum::~GradientSum() {
  if (!sender_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  sender_.join();
}

void GradientSum::lay_out(const std::vector<std::size_t>& order) {
  const std::int64_t multiple = ranks_.size();
  begins_.assign(sizes_.size(), 0);
  bucket_of_.assign(sizes_.size(), 0);
  buckets_.clear();
  std::int64_t end = 0;
  const auto close = [&] {
    Bucket& bucket = buckets_.back();
    end = bucket.begin + (end - bucket.begin + multiple - 1) / multiple * multiple;
    bucket.length = end - bucket.begin;
  };
  for (const std::size_t weight : order) {
    const auto enough = static_cast<std::int64_t>(bucket_bytes_ / sizeof(float));
    if (buckets_.empty() || end - buckets_.back().begin >= enough) {
      if (!buckets_.empty()) close();
      buckets_.emplace_back().begin = end;
    }
    begins_[weight] = end;
    bucket_of_[weight] = buckets_.size() - 1;
    buckets_.back().weights.push_back(weight);
    end += sizes_[weight];
  }
  close();
  own_ = at::zeros({end}, at::TensorOptions(device_));
  total_ = ranks_.alone() ? own_ : at::zeros_like(own_);
  earlier_.clear();
  spare_.clear();
}

at::Tensor GradientSum::slice(const at::Tensor& flat, std::size_t weight) const {
  return flat.narrow(0, begins_[weight], sizes_[weight]);
}

void GradientSum::begin_part(double share) {
  const c10::NoGradGuard no_gradients;
  if (done_ == 0) {
    const std::lock_guard lock(mutex_);
    to_send_ = sent_buckets_ = 0;
  }
  share_ = share;
  notes_.zero_();
  own_.zero_();
  if (!in_last_part()) return;
  is_ready_.assign(sizes_.size(), 0);
  order_seen_.clear();
  for (Bucket& bucket : buckets_) bucket.missing = bucket.weights.size();
}

void GradientSum::put(std::size_t weight, const at::Tensor& gradient) {
  if (!gradient.defined()) return;
  const at::Tensor there = slice(own_, weight);
  there.copy_(gradient.detach().reshape({-1}));
  if (weight + 1 == sizes_.size()) return;
  if (share_ != 1) there.mul_(share_);
  notes_[static_cast<std::int64_t>(weight)] = 1;
}

void GradientSum::ready(std::size_t weight, const at::Tensor& gradient) {
  if (!in_last_part() || is_ready_.empty() || std::exchange(is_ready_[weight], 1) != 0) return;
  const c10::NoGradGuard no_gradients;
  if (weight + 1 < sizes_.size()) order_seen_.push_back(weight);
  put(weight, gradient);
  for (std::size_t k = earlier_.size(); k-- > 0;) {
    slice(own_, weight).add_(slice(earlier_[k], weight));
  }
  --buckets_[bucket_of_[weight]].missing;
  if (ranks_.alone()) return;
  std::size_t complete = to_send_;  // which this thread alone changes
  while (complete < buckets_.size() && buckets_[complete].missing == 0) {
    buckets_[complete++].complete.give(device_);
  }
  {
    const std::lock_guard lock(mutex_);
    if (complete == to_send_) return;
    to_send_ = complete;
  }
  changed_.notify_all();
}

void GradientSum::end_part(std::span<const at::Tensor> gradients, double loss) {
  EN_CHECK_EQ(gradients.size() + 1, sizes_.size());
  const c10::NoGradGuard no_gradients;
  const bool last = in_last_part();
  for (std::size_t k = 0; k < gradients.size(); ++k) {
    last ? ready(k, gradients[k]) : put(k, gradients[k]);
  }
  notes_[sizes_.back() - 1] = share_ * loss;
  if (last) {
    ready(gradients.size(), notes_);
    ++done_;
    is_ready_.clear();
    return;
  }
  put(gradients.size(), notes_);
  ++done_;
  join_pairs(done_, [this] {
    own_.add_(earlier_.back());
    spare_.push_back(std::move(earlier_.back()));
    earlier_.pop_back();
  });
  at::Tensor next;
  if (spare_.empty()) {
    next = at::zeros_like(own_);
  } else {
    next = std::move(spare_.back());
    spare_.pop_back();
  }
  earlier_.push_back(std::exchange(own_, std::move(next)));
  if (ranks_.alone()) total_ = own_;
}

// The tree over what the processes have: each has as many parts as the others.
void GradientSum::send(const Bucket& bucket) {
  const at::Tensor own = own_.narrow(0, bucket.begin, bucket.length);
  const at::Tensor total = total_.narrow(0, bucket.begin, bucket.length);
  if (!parts_.in_order) {
    total.copy_(own);
    return add_up(ranks_, total);
  }
  const at::Tensor received = exchange(ranks_, own).view({ranks_.size(), -1});
  std::vector<at::Tensor> sums;
  for (std::int64_t k = 0; k < ranks_.size(); ++k) {
    sums.push_back(received[k]);
    const auto join = [&sums] {
      const at::Tensor last = sums.back();
      sums.pop_back();
      sums.back().add_(last);
    };
    join_pairs(static_cast<std::size_t>(k + 1), join);
    while (k + 1 == ranks_.size() && sums.size() > 1) join();
  }
  collect(ranks_, sums.front(), total);
}

void GradientSum::communicate() {
  const c10::NoGradGuard no_gradients;
  // A stream of its own, as that of the gradients has the rest of them to compute.
  std::optional<c10::StreamGuard> stream;
  if (!device_.is_cpu()) {
    stream.emplace(c10::impl::VirtualGuardImpl(device_.type()).getStreamFromGlobalPool(device_));
  }
  for (;;) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopping_ || sent_buckets_ < to_send_; });
    if (stopping_) return;
    const Bucket& bucket = buckets_[sent_buckets_];
    lock.unlock();
    std::exception_ptr failure;
    try {
      bucket.complete.take(device_);
      send(bucket);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    ++sent_buckets_;
    if (failure) {
      failure_ = failure;
      stopping_ = true;
    }
    lock.unlock();
    changed_.notify_all();
  }
}

GradientSum::Sums GradientSum::finish() {
  EN_CHECK_EQ(done_, parts_.count);
  done_ = 0;
  if (!ranks_.alone()) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopping_ || sent_buckets_ == buckets_.size(); });
    if (failure_) std::rethrow_exception(failure_);
  }
  for (at::Tensor& one : earlier_) spare_.push_back(std::move(one));
  earlier_.clear();
  Sums sums;
  const at::Tensor notes = slice(total_, sizes_.size() - 1).cpu();
  for (std::size_t k = 0; k + 1 < sizes_.size(); ++k) {
    const bool any = notes.data_ptr<float>()[k] > 0;
    sums.gradients.push_back(any ? slice(total_, k) : at::Tensor());
  }
  sums.loss = double{notes.data_ptr<float>()[sizes_.size() - 1]};
  if (!ranks_.alone() && !order_known_) {
    for (at::Tensor& sum : sums.gradients) {
      if (sum.defined()) sum = sum.clone();  // the memory is laid out anew
    }
    learn_order();
  }
  return sums;
}

// What rank 0 has seen, for all.
void GradientSum::learn_order() {
  order_known_ = true;
  ValuePacker packer;
  packer.add(order_seen_);
  const std::vector<std::string> seen = ranks_.gather(packer.take());
  auto order = Unpacker(seen.front()).get<std::vector<std::size_t>>();
  order.push_back(sizes_.size() - 1);
  lay_out(order);
}

namespace {

// A hook for each leaf's node of autograd, which comes after all that add to the gradient.
struct Hook : torch::autograd::FunctionPostHook {
  Hook(GradientSum& to, std::size_t number, at::Tensor of)
      : sum(&to), weight(number), leaf(std::move(of)) {}
  torch::autograd::variable_list operator()(
      const torch::autograd::variable_list& outputs,
      const torch::autograd::variable_list& /*inputs*/) override {
    sum->ready(weight, leaf.grad());
    return outputs;
  }
  GradientSum* sum;
  std::size_t weight;
  at::Tensor leaf;
};

}  // namespace

ReadyWatch::ReadyWatch(const Weights& weights, GradientSum& sum) {
  std::size_t number = 0;
  for (const auto& [name, weight] : weights) {
    const auto node = torch::autograd::impl::grad_accumulator(weight);
    const std::uintptr_t key = node->add_post_hook(std::make_unique<Hook>(sum, number++, weight));
    undo_.emplace_back([node, key] { node->del_post_hook(key); });
  }
}

ReadyWatch::~ReadyWatch() {
  for (const auto& one : undo_) one();
}

PartedLearning::PartedLearning(Ranks& ranks, std::size_t parts, const Weights& weights,
                               WeightOptimizer& optimizer)
    : weights_(weights), optimizer_(optimizer) {
  const BatchParts shared = share_parts(parts, ranks);
  if (shared.parts == 1) return;
  std::vector<std::int64_t> sizes;
  for (const auto& [name, weight] : weights) sizes.push_back(weight.numel());
  sum_.emplace(ranks, shared, std::move(sizes), weights.begin()->second.device());
  if (!ranks.alone()) watch_.emplace(weights, *sum_);
}

double PartedLearning::learn(std::span<const std::size_t> batch, std::uint64_t iteration,
                             const LossOf& loss_of) {
  const auto follow = [&](const BatchPart& part) {
    const at::Tensor loss = loss_of(part);
    return loss.defined() ? follow_back(loss) : 0;
  };
  if (!sum_) {
    const double value = follow({batch, iteration});
    optimizer_.update(weights_);  // where nothing was learnt the rate has one step less to go
    return value;
  }
  const BatchParts& own = sum_->parts();
  for (std::size_t k = own.first; k < own.first + own.count; ++k) {
    const auto episodes = part_of(batch, k, own.parts);
    sum_->begin_part(static_cast<double>(episodes.size()) / static_cast<double>(batch.size()));
    const double loss = episodes.empty() ? 0 : follow({episodes, iteration * own.parts + k});
    std::vector<at::Tensor> gradients;
    for (const auto& [name, weight] : weights_) gradients.push_back(weight.grad());
    sum_->end_part(gradients, loss);
    clear_gradients(weights_);
  }
  const GradientSum::Sums sums = sum_->finish();
  std::size_t k = 0;
  for (const auto& [name, weight] : weights_) {
    const at::Tensor& sum = sums.gradients[k++];
    if (!sum.defined()) continue;
    at::Tensor(weight).mutable_grad() = sum.view(weight.sizes());
  }
  optimizer_.update(weights_);
  return sums.loss;
}

}  // namespace enfilade::neural::core
