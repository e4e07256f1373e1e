#ifdef EN_WITH_C10D
#include "enfilade/neural/core/card_link.h"

#include "enfilade/core/check.h"
#ifdef EN_WITH_NCCL
#include <ATen/ATen.h>
#include <fmt/format.h>
#include <torch/version.h>

#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <torch/csrc/distributed/c10d/ProcessGroupNCCL.hpp>
#include <vector>

#include "enfilade/core/errors.h"
#endif

namespace enfilade::neural::core {

#ifdef EN_WITH_NCCL

namespace {

// c10d's options have NCCL's, whose layout is of a version.
void check_version() {
  constexpr std::uint64_t kBuilt = std::uint64_t{NCCL_MAJOR} << 32U | std::uint64_t{NCCL_MINOR}
                                                                          << 16U;
  const std::uint64_t found = torch::cuda::nccl::version();
  if (found >> 16U == kBuilt >> 16U) return;
  throw Error(fmt::format("libtorch has NCCL {}.{}, but the headers were of {}", found >> 32U,
                          found >> 16U & 0xffffU, nccl_version()));
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

class NcclLink final : public CardLink {
 public:
  NcclLink(const c10::intrusive_ptr<c10d::Store>& store, int rank, int size, c10::Device card,
           std::chrono::milliseconds timeout) {
    check_version();
    wait_in_calls();
    const auto options = c10d::ProcessGroupNCCL::Options::create();
    options->timeout = timeout;
    group_ = c10::make_intrusive<c10d::ProcessGroupNCCL>(store, rank, size, options);
    // The cards are connected by the first call.
    const at::Tensor ones = at::ones({1}, at::TensorOptions(card));
    add_up_now(ones);
    EN_CHECK_EQ(ones.item<float>(), static_cast<float>(size));
  }
  ~NcclLink() override {
    // Calls of a rank that is lost would be waited for.
    abort(*group_);
  }
  NcclLink(const NcclLink&) = delete;
  NcclLink& operator=(const NcclLink&) = delete;

  void exchange(const at::Tensor& given, const at::Tensor& out) override {
    at::Tensor from = given, to = out;
    std::vector<std::int64_t> equal;
    group_->alltoall_base(to, from, equal, equal)->wait();
  }
  void collect(const at::Tensor& given, const at::Tensor& out) override {
    at::Tensor from = given, to = out;
    group_->_allgather_base(to, from)->wait();
  }
  void add_up(const at::Tensor& values) override { add_up_now(values); }

 private:
  // Older versions have no abort().
  template <class Group>
  static void abort(Group& group) {
    if constexpr (requires { group.abort(); }) group.abort();
  }
  void add_up_now(const at::Tensor& values) {
    std::vector<at::Tensor> all{values};
    group_->allreduce(all)->wait();
  }

  c10::intrusive_ptr<c10d::ProcessGroupNCCL> group_;
};

}  // namespace

std::string nccl_version() {
  return fmt::format("NCCL {}.{}.{}", NCCL_MAJOR, NCCL_MINOR, NCCL_PATCH);
}

std::string identity_of_card(c10::Device card) {
  const auto& bytes = at::cuda::getDeviceProperties(card.index())->uuid.bytes;
  return {std::begin(bytes), std::end(bytes)};
}

std::unique_ptr<CardLink> link_cards(const c10::intrusive_ptr<c10d::Store>& store, int rank,
                                     int size, c10::Device card,
                                     std::chrono::milliseconds timeout) {
  return std::make_unique<NcclLink>(store, rank, size, card, timeout);
}

#else

std::string nccl_version() { return {}; }
std::string identity_of_card(c10::Device /*card*/) { return {}; }
std::unique_ptr<CardLink> link_cards(const c10::intrusive_ptr<c10d::Store>& /*store*/, int /*rank*/,
                                     int /*size*/, c10::Device /*card*/,
                                     std::chrono::milliseconds /*timeout*/) {
  EN_CHECK(false);
  return nullptr;
}

#endif

}  // namespace enfilade::neural::core
#endif
