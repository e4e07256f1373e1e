#ifdef EN_WITH_C10D
#include "enfilade/neural/detail/card_link.h"

#include <ATen/ATen.h>
#include <fmt/format.h>

#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#ifdef EN_WITH_NCCL
#include <torch/version.h>

#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <torch/csrc/distributed/c10d/ProcessGroupNCCL.hpp>
#endif

namespace enfilade::neural::detail {

#ifdef EN_WITH_NCCL

namespace {

// c10d's options have NCCL's, whose layout is of a version.
void check_version() {
  constexpr std::uint64_t kBuilt = std::uint64_t{NCCL_MAJOR} << 32U | std::uint64_t{NCCL_MINOR}
                                                                          << 16U;
  const std::uint64_t found = torch::cuda::nccl::version();
  if (found >> 16U == kBuilt >> 16U) return;
  throw Error(fmt::format("libtorch has NCCL {}.{}, but the headers were of {}", found >> 32U,
                          found >> 16U & 0xffffU, CardLink::library()));
}

// A call then returns when the card is done, and throws what went wrong; c10d's other way is to end
// the process.
void wait_in_calls() {
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 2)
  constexpr const char* kName = "TORCH_NCCL_BLOCKING_WAIT";
#else
  constexpr const char* kName = "NCCL_BLOCKING_WAIT";
#endif
  setenv(kName, "1", 1);
}

}  // namespace

struct CardLink::Impl {
  c10::intrusive_ptr<c10d::ProcessGroupNCCL> group;
};

std::string CardLink::library() {
  return fmt::format("NCCL {}.{}.{}", NCCL_MAJOR, NCCL_MINOR, NCCL_PATCH);
}

std::string CardLink::identity(c10::Device card) {
  const auto& bytes = at::cuda::getDeviceProperties(card.index())->uuid.bytes;
  return {std::begin(bytes), std::end(bytes)};
}

CardLink::CardLink(const c10::intrusive_ptr<c10d::Store>& store, int rank, int size,
                   c10::Device card, std::chrono::milliseconds timeout)
    : impl_(std::make_unique<Impl>()) {
  check_version();
  wait_in_calls();
  const auto options = c10d::ProcessGroupNCCL::Options::create();
  options->timeout = timeout;
  impl_->group = c10::make_intrusive<c10d::ProcessGroupNCCL>(store, rank, size, options);
  // The cards are connected by the first call.
  const at::Tensor ones = at::ones({1}, at::TensorOptions(card));
  add_up(ones);
  EN_CHECK_EQ(ones.item<float>(), static_cast<float>(size));
}

CardLink::~CardLink() {
  // Calls of a rank that is lost would be waited for.
  if constexpr (requires { impl_->group->abort(); }) impl_->group->abort();
}

void CardLink::exchange(const at::Tensor& given, const at::Tensor& out) {
  at::Tensor from = given, to = out;
  std::vector<std::int64_t> equal;
  impl_->group->alltoall_base(to, from, equal, equal)->wait();
}

void CardLink::collect(const at::Tensor& given, const at::Tensor& out) {
  at::Tensor from = given, to = out;
  impl_->group->_allgather_base(to, from)->wait();
}

void CardLink::add_up(const at::Tensor& values) {
  std::vector<at::Tensor> all{values};
  impl_->group->allreduce(all)->wait();
}

#else

struct CardLink::Impl {};

std::string CardLink::library() { return {}; }
std::string CardLink::identity(c10::Device /*card*/) { return {}; }

CardLink::CardLink(const c10::intrusive_ptr<c10d::Store>& /*store*/, int /*rank*/, int /*size*/,
                   c10::Device /*card*/, std::chrono::milliseconds /*timeout*/) {
  throw Error("this build has no NCCL");
}
CardLink::~CardLink() = default;
void CardLink::exchange(const at::Tensor& /*given*/, const at::Tensor& /*out*/) {}
void CardLink::collect(const at::Tensor& /*given*/, const at::Tensor& /*out*/) {}
void CardLink::add_up(const at::Tensor& /*values*/) {}

#endif

}  // namespace enfilade::neural::detail
#endif
