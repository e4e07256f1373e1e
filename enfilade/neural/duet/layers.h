/// \file  Layers of transformers, on parameters that are found by name.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstdint>
#include <optional>
#include <string>

#include "enfilade/neural/core/dropout.h"
#include "enfilade/neural/core/weights.h"

namespace enfilade::neural::duet {

/// Dropout at the network's rate, or at another one.
class Dropout {
 public:
  /// \param rate share of numbers that become 0, in [0, 1)
  Dropout(std::uint64_t seed, double rate, c10::Device device = c10::kCPU)
      : drop_(seed, device), rate_(rate) {}
  at::Tensor operator()(const at::Tensor& values) { return drop_(values, rate_); }
  at::Tensor operator()(const at::Tensor& values, double rate) { return drop_(values, rate); }
  at::Tensor mask(at::IntArrayRef sizes) { return drop_.mask(sizes, rate_); }
  double rate() const noexcept { return rate_; }

 private:
  core::Dropout drop_;
  double rate_;
};

inline constexpr double kBertEpsilon = 1e-12;  ///< of BERT's norms

/// Summand of an attention's scores of padding.
inline constexpr double kSoftMask = -10000;
/// Summand of an attention's scores: 0 for tokens, `padding` elsewhere.
/// \param mask (n, length) bool, true for a token
/// \return (n, 1, 1, length)
at::Tensor bias_of(const at::Tensor& mask, double padding);

/// Keys and values of an attention, as its layer needs them.
struct Attended {
  at::Tensor keys, values;  ///< (n, b, hidden)
};

/// The layers of one network. `dropout` may be null: then there is none.
class Layers {
 public:
  Layers(const core::Weights& weights, std::int64_t heads, Dropout* dropout)
      : weights_(weights), heads_(heads), dropout_(dropout) {}

  const at::Tensor& weight(const std::string& name) const;
  at::Tensor drop(const at::Tensor& values) const;
  at::Tensor linear(const at::Tensor& x, const std::string& name) const;
  at::Tensor norm(const at::Tensor& x, const std::string& name, double eps = kBertEpsilon) const;

  /// Attention of `x` (n, a, hidden) to `to` (n, b, hidden), then sum and norm.
  /// \param bias added to the scores, as (n, 1, a or 1, b)
  at::Tensor attention(const at::Tensor& x, const at::Tensor& to, const at::Tensor& bias,
                       const std::string& inner, const std::string& output) const;
  /// The same in two parts: keys and values may be the same in many calls.
  Attended attended(const at::Tensor& to, const std::string& inner) const;
  at::Tensor attention(const at::Tensor& x, const Attended& to, const at::Tensor& bias,
                       const std::string& inner, const std::string& output) const;
  /// Two linear maps with GELU (of erf) between them, then sum and norm.
  at::Tensor feed_forward(const at::Tensor& x, const std::string& inner,
                          const std::string& output) const;
  /// A layer that norms first, with torch.nn.MultiheadAttention's parameters.
  /// \param bias as in attention(); minus infinity for padding
  at::Tensor pre_norm_layer(const at::Tensor& x, const at::Tensor& bias,
                            const std::string& name) const;
  /// Linear, ReLU, norm, linear to one number: (..., hidden) -> (...).
  at::Tensor head(const at::Tensor& x, const std::string& name) const;

 private:
  at::Tensor attend(const at::Tensor& query, const at::Tensor& key, const at::Tensor& value,
                    const at::Tensor& bias) const;
  // norm(drop(y) + x)
  at::Tensor sum_norm(const at::Tensor& y, const at::Tensor& x, const std::string& name) const;
  // Factors of dropout; undefined: none.
  at::Tensor mask(at::IntArrayRef sizes) const;

  const core::Weights& weights_;
  std::int64_t heads_;
  Dropout* dropout_;
};

}  // namespace enfilade::neural::duet
