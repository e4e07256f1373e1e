#include "enfilade/neural/seq2seq/parameters.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "enfilade/core/rng.h"

namespace enfilade::neural::seq2seq {
namespace {

constexpr std::int64_t kFloatsALine = 16;  // floats a cache line

// Box and Muller; a uniform number is never 1, so 1 - u has a logarithm.
double normal(Rng& rng) {
  const double radius = std::sqrt(-2 * std::log(1 - rng.uniform()));
  return radius * std::cos(2 * std::numbers::pi * rng.uniform());
}

}  // namespace

std::array<WeightInfo, kWeights> weight_infos(const models::NetworkConfig& config) {
  const auto h = static_cast<std::int64_t>(config.hidden);
  const auto words = static_cast<std::int64_t>(config.vocabulary);
  const auto embedding = static_cast<std::int64_t>(config.word_embedding);
  const auto action = static_cast<std::int64_t>(config.action_embedding);
  const auto input = action + static_cast<std::int64_t>(config.features);
  constexpr std::int64_t kInputs = kIgnoreInput + 1;
  std::array<WeightInfo, kWeights> infos{{
      {"encoder.embedding.weight", {words, embedding}, 0},
      {"encoder.lstm.weight_ih_l0", {4 * h, embedding}, h},
      {"encoder.lstm.weight_hh_l0", {4 * h, h}, h},
      {"encoder.lstm.bias_ih_l0", {4 * h}, h},
      {"encoder.lstm.bias_hh_l0", {4 * h}, h},
      {"encoder.encoder2decoder.weight", {h, h}, h},
      {"encoder.encoder2decoder.bias", {h}, h},
      {"decoder.embedding.weight", {kInputs, action}, 0},
      {"decoder.lstm.weight_ih", {4 * h, input}, h},
      {"decoder.lstm.weight_hh", {4 * h, h}, h},
      {"decoder.lstm.bias_ih", {4 * h}, h},
      {"decoder.lstm.bias_hh", {4 * h}, h},
      {"decoder.attention_layer.linear_in.weight", {h, h}, h},
      {"decoder.attention_layer.linear_out.weight", {h, 2 * h}, 2 * h},
      {"decoder.decoder2action.weight", {kSixActionCount, h}, h},
      {"decoder.decoder2action.bias", {kSixActionCount}, h},
  }};
  std::int64_t begin = 0;
  for (WeightInfo& info : infos) {
    info.begin = begin;
    info.elements = 1;
    for (const std::int64_t n : info.shape) info.elements *= n;
    begin += (info.elements + kFloatsALine - 1) / kFloatsALine * kFloatsALine;
  }
  return infos;
}

Parameters::Parameters(const models::NetworkConfig& config, const at::TensorOptions& options)
    : infos_(weight_infos(config)) {
  const WeightInfo& last = infos_.back();
  const std::int64_t size = last.begin + last.elements;
  flat_weights = at::zeros({size}, options);
  flat_gradients = at::zeros({size}, options);
  first = at::zeros({size}, options);
  second = at::zeros({size}, options);
  for (std::size_t i = 0; i < kWeights; ++i) {
    weights_[i] = view(flat_weights, i);
    gradients_[i] = view(flat_gradients, i);
  }
}

void Parameters::initialise(std::uint64_t seed) {
  const at::Tensor host = at::zeros(flat_weights.sizes(), at::TensorOptions().dtype(at::kFloat));
  for (std::size_t i = 0; i < kWeights; ++i) {
    const WeightInfo& info = infos_[i];
    const double most = info.inputs > 0 ? 1 / std::sqrt(static_cast<double>(info.inputs)) : 0;
    Rng rng(seed, i);
    float* out = host.data_ptr<float>() + info.begin;
    for (std::int64_t k = 0; k < info.elements; ++k) {
      out[k] = static_cast<float>(most > 0 ? most * (2 * rng.uniform() - 1) : normal(rng));
    }
    if (i == index(Weight::kWordEmbedding)) std::fill_n(out, info.shape[1], 0.0F);
  }
  flat_weights.copy_(host);
  for (const at::Tensor& other : {flat_gradients, first, second}) other.zero_();
  updates = 0;
}

at::Tensor Parameters::view(const at::Tensor& flat, std::size_t i) const {
  return flat.narrow(0, infos_[i].begin, infos_[i].elements).view(infos_[i].shape);
}

}  // namespace enfilade::neural::seq2seq
