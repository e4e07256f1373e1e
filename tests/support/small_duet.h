/// \file  For tests: two episodes for a very small DUET, and how to check its gradients.
#pragma once
#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/duet/duet_network.h"

namespace enfilade::neural::duet::testing {

/// Sizes of a network with one layer of each kind.
inline DuetConfig tiny_duet() {
  DuetConfig config;
  config.hidden = 8;
  config.heads = 2;
  config.feed_forward = 12;
  config.panorama_feed_forward = 12;
  config.text_layers = config.panorama_layers = config.cross_layers = 1;
  config.vocabulary = 20;
  config.positions = config.max_words = 16;
  config.image = 5;
  config.object = 3;
  config.steps = 20;
  return config;
}

/// Normal numbers.
inline at::Tensor random_tensor(const std::vector<std::int64_t>& shape, std::uint64_t seed) {
  Rng rng(seed);
  return core::normal(shape, 1, rng);
}

/// int64.
inline at::Tensor integers(const std::vector<std::int64_t>& values) {
  return at::tensor(values, at::kLong);
}

/// Two episodes; the first is shorter in everything, so it has padding.
struct DuetBatch {
  at::Tensor ids = integers({1, 5, 7, 2, 0, 0, 1, 9, 4, 8, 6, 2}).view({2, 6});
  at::Tensor lengths = integers({4, 6});
  PanoramaInput panorama;
  NavigationInput navigation;

  DuetBatch() {
    panorama.views = random_tensor({2, 5, 5}, 1);
    panorama.view_counts = integers({4, 5});
    panorama.objects = random_tensor({2, 2, 3}, 2);
    panorama.object_counts = integers({2, 1});
    panorama.locations = random_tensor({2, 6, 7}, 3);
    panorama.types = integers({1, 1, 0, 0, 2, 2, 1, 1, 1, 0, 0, 2}).view({2, 6});
    navigation.steps = integers({0, 1, 0, 0, 0, 0, 1, 2, 0, 0}).view({2, 5});
    navigation.node_positions = random_tensor({2, 5, 7}, 4);
    navigation.node_mask = mask_of(integers({4, 5}), 5);
    navigation.visited = navigation.steps.gt(0);
    const at::Tensor metres = random_tensor({2, 5, 5}, 5).abs();
    navigation.distances = (metres + metres.transpose(1, 2)).contiguous();
    navigation.distances.select(1, 0).zero_();
    navigation.distances.select(2, 0).zero_();
    navigation.token_positions = random_tensor({2, 7, 14}, 6);
    navigation.choices = integers({1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0}).view({2, 7}).gt(0);
    navigation.objects = integers({0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 1}).view({2, 7}).gt(0);
    navigation.node_of_token =
        integers({-1, 2, 3, -1, -1, -1, -1, -1, 1, 4, -1, -1, -1, -1}).view({2, 7});
  }

  /// One row without its padding.
  DuetBatch row(std::int64_t i) const {
    DuetBatch one = *this;
    const auto cut = [i](const at::Tensor& x, std::int64_t length) {
      return x.narrow(0, i, 1).narrow(1, 0, length).contiguous();
    };
    const std::int64_t words = i == 0 ? 4 : 6, views = i == 0 ? 4 : 5, objects = i == 0 ? 2 : 1;
    const std::int64_t nodes = i == 0 ? 4 : 5, tokens = views + objects;
    one.ids = cut(ids, words);
    one.lengths = lengths.narrow(0, i, 1);
    one.panorama = {cut(panorama.views, views),      panorama.view_counts.narrow(0, i, 1),
                    cut(panorama.objects, objects),  panorama.object_counts.narrow(0, i, 1),
                    cut(panorama.locations, tokens), cut(panorama.types, tokens)};
    NavigationInput& n = one.navigation;
    n.steps = cut(n.steps, nodes);
    n.node_positions = cut(n.node_positions, nodes);
    n.node_mask = cut(n.node_mask, nodes);
    n.visited = cut(n.visited, nodes);
    n.distances = cut(n.distances, nodes).narrow(2, 0, nodes);
    n.token_positions = cut(n.token_positions, tokens + 1);
    n.choices = cut(n.choices, tokens + 1);
    n.objects = cut(n.objects, tokens + 1);
    n.node_of_token = cut(n.node_of_token, tokens + 1);
    return one;
  }

  NavigationOutput run(const DuetNetwork& network, RateDropout* dropout = nullptr) const {
    const Tokens text = network.encode_text(ids, lengths, dropout);
    return network.navigate(text, seen(network, dropout), dropout);
  }

  /// `navigation` with the encoded views.
  NavigationInput seen(const DuetNetwork& network, RateDropout* dropout = nullptr) const {
    const Tokens seen = network.encode_panorama(panorama, dropout);
    NavigationInput input = navigation;
    const std::int64_t n = ids.size(0), hidden = network.config().hidden;
    const at::Tensor stop = at::zeros({n, 1, hidden});
    input.tokens = at::cat({stop, seen.values}, 1);
    input.token_mask = at::cat({at::ones({n, 1}, at::kBool), seen.mask}, 1);
    // Any embedding will do for the nodes: here each is a token of the panorama.
    input.nodes = at::cat({stop, seen.values.narrow(1, 0, input.steps.size(1) - 1)}, 1);
    return input;
  }
};

/// Compares each weight's gradient, where it is largest, with finite differences of `loss`. The
/// weights are made larger first, so that every part has its say. \return the weights whose
/// gradients are others, or missing
inline std::vector<std::string> wrong_gradients(const core::Weights& weights,
                                                const std::function<at::Tensor()>& loss) {
  std::vector<std::string> wrong;
  {
    const c10::NoGradGuard no_gradients;
    Rng rng(4);
    for (const auto& [name, values] : weights) {
      at::Tensor(values).add_(core::normal(values.sizes().vec(), 0.2, rng));
    }
  }
  loss().backward();
  const c10::NoGradGuard no_gradients;
  const double here = loss().item<double>();
  for (const auto& [name, values] : weights) {
    const at::Tensor gradient = values.grad();
    if (!gradient.defined()) {
      wrong.push_back(name + ": none");
      continue;
    }
    const auto place = gradient.view({-1}).abs().argmax().item<std::int64_t>();
    const double expected = gradient.view({-1})[place].item<double>();
    at::Tensor number = at::Tensor(values).view({-1})[place];
    const float before = number.item<float>();
    constexpr float kStep = 1e-3F;  // float32: rounding is some 1e-3 of the quotient
    number.fill_(before + kStep);
    const double above = loss().item<double>();
    number.fill_(before - kStep);
    const double below = loss().item<double>();
    number.fill_(before);
    // ReLU has kinks, where the gradient is that of one side.
    const double apart = std::min({std::abs((above - below) / (2 * kStep) - expected),
                                   std::abs((above - here) / kStep - expected),
                                   std::abs((here - below) / kStep - expected)});
    if (apart < 5e-3 + 0.03 * std::abs(expected)) continue;
    wrong.push_back(fmt::format("{}: {}, by {}", name, expected, apart));
  }
  return wrong;
}

}  // namespace enfilade::neural::duet::testing
