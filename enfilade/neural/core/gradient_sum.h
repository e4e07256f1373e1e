/// \file  The gradient of a batch whose parts are computed one after the other, or by several
/// processes.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <c10/core/Event.h>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "enfilade/neural/core/optimizer.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/ranks.h"

namespace enfilade::neural::core {

/// The parts of a batch, and those of them that this process computes.
struct BatchParts {
  std::size_t parts = 1;
  std::size_t first = 0, count = 1;  ///< own ones: [first, first + count)
  bool in_order = true;              ///< sums do not depend on the number of processes
};
/// \param parts of TrainConfig: 0: as many as processes, whose sums are added as they come
/// \throws ArgumentError naming the numbers of processes that can share these parts
BatchParts share_parts(std::size_t parts, const Ranks& ranks);

/// The episodes of part k of n: as many as of the others, or one less.
std::span<const std::size_t> part_of(std::span<const std::size_t> batch, std::size_t k,
                                     std::size_t n);

/// Work that one thread has queued on a card, for another thread's stream to wait for. On the CPU
/// there is nothing to wait for.
class Handover {
 public:
  void give(c10::Device device);  ///< all work that this thread has queued in its stream
  /// Later work of this thread comes after that.
  void take(c10::Device device) const;

 private:
  std::optional<c10::Event> event_;
};

/// Adds the gradients of parts in a tree that does not depend on which process computed them. Parts
/// that follow each other are added in pairs, these in pairs, and so on. A process adds its own.
/// The sums are sent in buckets during the backward pass of the last own part. Each process adds
/// one stretch of each bucket, for all, and returns the sum.
///
/// In a batch: begin_part() and end_part() for each own part, then finish(). One thread at a time.
class GradientSum {
 public:
  /// \param sizes numbers of each weight \param ranks outlives *this
  /// \param device where gradients are and are added: the CPU in all ranks, or a card in all
  /// \param bucket bytes of a bucket, at least; a weight is never divided
  /// \throws Error if cards cannot be connected
  GradientSum(Ranks& ranks, const BatchParts& parts, std::vector<std::int64_t> sizes,
              c10::Device device = c10::kCPU, std::size_t bucket = std::size_t{1} << 20U);
  ~GradientSum();
  GradientSum(const GradientSum&) = delete;
  GradientSum& operator=(const GradientSum&) = delete;

  const BatchParts& parts() const noexcept { return parts_; }

  /// \param share by which the part's gradients and loss are multiplied
  void begin_part(double share);
  /// The gradient of a weight is complete, before end_part(): it may be sent. Counts in the last
  /// own part alone.
  void ready(std::size_t weight, const at::Tensor& gradient);
  /// All gradients of the part, by weight; undefined: none. And its loss.
  void end_part(std::span<const at::Tensor> gradients, double loss);
  /// Sums of all parts of all processes.
  struct Sums {
    /// By weight, flat, on the device, valid until the next begin_part(); undefined where no part
    /// had a gradient.
    std::vector<at::Tensor> gradients;
    double loss = 0;  ///< added up in float32, as the gradients
  };
  /// \throws LostRank
  Sums finish();

 private:
  struct Bucket {
    std::int64_t begin = 0, length = 0;  // a multiple of the processes
    std::size_t missing = 0;             // weights of it that are not ready
    std::vector<std::size_t> weights;
    Handover complete;
  };

  void lay_out(const std::vector<std::size_t>& order);
  void put(std::size_t weight, const at::Tensor& gradient);
  bool in_last_part() const noexcept { return done_ + 1 == parts_.count; }
  void learn_order();
  void communicate();
  void send(const Bucket& bucket);
  at::Tensor slice(const at::Tensor& flat, std::size_t weight) const;

  Ranks& ranks_;
  BatchParts parts_;
  std::vector<std::int64_t> sizes_;  // of the weights, then of the notes
  c10::Device device_;
  std::size_t bucket_bytes_;
  std::vector<std::int64_t> begins_;         // by weight
  std::vector<std::size_t> bucket_of_;       // by weight
  std::vector<Bucket> buckets_;              // in the order in which they are sent
  at::Tensor own_, total_;                   // flat
  std::vector<at::Tensor> earlier_, spare_;  // sums of earlier own parts, of falling powers of two
  // A part's flags by weight (1: it has a gradient), then its loss. Added like another weight's,
  // but written on the CPU.
  at::Tensor notes_;
  double share_ = 1;
  std::vector<std::uint8_t> is_ready_;   // by weight, in the last part
  std::vector<std::size_t> order_seen_;  // in which they got ready
  bool order_known_ = false;
  std::size_t done_ = 0;  // own parts of this batch

  // Shared by the sending thread and the others.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t to_send_ = 0, sent_buckets_ = 0;  // of this batch, in order
  bool stopping_ = false;
  std::exception_ptr failure_;
  std::thread sender_;
};

/// Tells a GradientSum when the gradients of leaves are complete while autograd follows a loss
/// back. Keep it as long as the leaves; it does nothing but between begin_part() and end_part().
class ReadyWatch {
 public:
  ReadyWatch(const Weights& weights, GradientSum& sum);
  ~ReadyWatch();
  ReadyWatch(const ReadyWatch&) = delete;
  ReadyWatch& operator=(const ReadyWatch&) = delete;

 private:
  std::vector<std::function<void()>> undo_;
};

/// The episodes of a loss.
struct BatchPart {
  std::span<const std::size_t> episodes;
  /// Names the random numbers: no other part or iteration has the same. For a batch in one part,
  /// the iteration.
  std::uint64_t stream = 0;
};
/// The mean over the episodes; undefined: there is nothing to learn.
using LossOf = std::function<at::Tensor(const BatchPart&)>;

/// Learns from batches, in parts where there are several. One thread at a time.
class PartedLearning {
 public:
  /// All outlive *this, and the weights stay the same tensors. \param parts of TrainConfig
  /// \throws ArgumentError as share_parts()
  PartedLearning(Ranks& ranks, std::size_t parts, const Weights& weights,
                 WeightOptimizer& optimizer);

  /// Follows the losses back and updates the weights. The mean of parts of unlike sizes is
  /// weighted by these. \return the loss of the batch \throws Error if it is not finite; LostRank
  double learn(std::span<const std::size_t> batch, std::uint64_t iteration, const LossOf& loss_of);

 private:
  const Weights& weights_;
  WeightOptimizer& optimizer_;
  std::optional<GradientSum> sum_;  // none: one part, one process
  std::optional<ReadyWatch> watch_;
};

}  // namespace enfilade::neural::core
