#include "enfilade/neural/continuous/episode_states.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>

#include <algorithm>

#include "enfilade/core/check.h"
#include "enfilade/core/half.h"

namespace enfilade::neural::continuous {

std::vector<std::int64_t> read_text(const models::InstructionWords& words, std::string_view text,
                                    const models::NetworkConfig& config) {
  return words.encode(config.inputs.language ? text : std::string_view(), config.max_words);
}

at::Tensor picture_numbers(std::span<const std::uint16_t> halves, std::int64_t n,
                           const Sizes& sizes) {
  if (halves.empty()) return at::zeros({n, std::max<std::int64_t>(sizes.features, 1)}, at::kFloat);
  at::Tensor numbers = at::empty({n, sizes.features}, at::kFloat);
  const bool finite =
      copy_halves(reinterpret_cast<const std::byte*>(halves.data()),
                  {numbers.data_ptr<float>(), static_cast<std::size_t>(numbers.numel())});
  EN_CHECK(finite);
  return numbers;
}

at::Tensor depth_numbers(std::span<const std::uint8_t> bytes, std::int64_t n) {
  at::Tensor numbers = at::zeros({n, kDepthSize}, at::kFloat);
  std::ranges::transform(bytes, numbers.data_ptr<float>(),
                         [](std::uint8_t byte) { return static_cast<float>(byte) / 255; });
  return numbers;
}

void EpisodeStates::start(std::size_t slot, const std::vector<std::int64_t>& instruction) {
  const c10::NoGradGuard no_gradients;
  if (slot >= previous_.size()) {
    const auto more = static_cast<std::int64_t>(slot + 1 - previous_.size());
    const auto grow = [&](at::Tensor& rows, std::int64_t width) {
      const at::Tensor nothing =
          at::zeros({more, width}, at::TensorOptions(at::kFloat).device(network_.device()));
      rows = rows.defined() ? at::cat({rows, nothing}) : nothing;
    };
    grow(sentences_, static_cast<std::int64_t>(network_.sizes().own.sentence));
    grow(states_, static_cast<std::int64_t>(network_.sizes().own.hidden));
    previous_.resize(slot + 1);
  }
  const auto row = static_cast<std::int64_t>(slot);
  sentences_[row].copy_(network_.read(std::span(&instruction, 1))[0]);
  states_[row].zero_();
  previous_[slot] = kNoAction;
}

std::vector<std::int64_t> EpisodeStates::likeliest(std::span<const std::size_t> slots,
                                                   const Seen& seen) {
  const at::Tensor best = step(slots, seen).argmax(1);
  const auto* const first = best.data_ptr<std::int64_t>();
  return {first, first + best.numel()};
}

at::Tensor EpisodeStates::step(std::span<const std::size_t> slots, const Seen& seen) {
  const c10::NoGradGuard no_gradients;
  const std::int64_t n = std::ssize(slots);
  const at::Tensor rows = at::empty({n}, at::kLong), previous = at::empty({n}, at::kLong);
  for (std::int64_t r = 0; r < n; ++r) {
    const std::size_t slot = slots[static_cast<std::size_t>(r)];
    rows.data_ptr<std::int64_t>()[r] = static_cast<std::int64_t>(slot);
    previous.data_ptr<std::int64_t>()[r] = previous_[slot];
  }
  const Steps steps{picture_numbers(seen.pictures, n, network_.sizes()),
                    depth_numbers(seen.depth, n),
                    previous,
                    {n}};
  const at::Tensor there = rows.to(network_.device());
  const at::Tensor states =
      network_.walk(sentences_.index_select(0, there), steps, states_.index_select(0, there));
  states_.index_copy_(0, there, states);
  return at::softmax(network_.score(states), 1).to(at::kCPU);
}

}  // namespace enfilade::neural::continuous
