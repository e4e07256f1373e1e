#include "enfilade/neural/encoders/home_network.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <charconv>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::neural::encoders {
namespace {

constexpr const char *kFormatKey = "format", *kFormat = "enfilade-home-encoder-1";
constexpr const char *kClassesKey = "classes", *kRoomsKey = "rooms";

Convolution prepared(const core::Weights& weights, const std::string& name, const HomeLayer& layer,
                     c10::Device device) {
  Convolution c;
  c.weight = weights.at(name + ".weight");
  c.bias = weights.at(name + ".bias");
  c.stride = layer.stride;
  c.dilation = layer.dilation;
  c.padding = layer.size / 2 * layer.dilation;
  prepare(c, device, Layout::kChannelsLast);
  return c;
}

std::string trunk_name(std::size_t i) { return fmt::format("trunk.{}", i); }

[[noreturn]] void fault(const std::filesystem::path& file, const char* where, std::string message) {
  refuse(file.string(), where, "no-home-encoder", std::move(message));
}

std::vector<std::int64_t> parse_classes(const std::filesystem::path& file, std::string_view text) {
  std::vector<std::int64_t> classes;
  for (const char* next = text.data(); next != text.data() + text.size();) {
    std::int64_t number = 0;
    const auto [stop, code] = std::from_chars(next, text.data() + text.size(), number);
    if (code != std::errc()) fault(file, kClassesKey, "whole numbers are expected");
    classes.push_back(number);
    next = stop + (stop != text.data() + text.size() && *stop == ' ' ? 1 : 0);
  }
  return classes;
}

}  // namespace

at::Tensor pool_thirds(const at::Tensor& cells) {
  std::vector<at::Tensor> thirds;
  for (std::size_t i = 0; i < kThirds; ++i) {
    thirds.push_back(cells.slice(3, kThirdColumns.at(i), kThirdColumns.at(i + 1)).mean({2, 3}));
  }
  return at::stack(thirds, 2);
}

at::Tensor describe(const HomeOutputs& outputs) {
  const at::Tensor shares = pool_thirds(outputs.classes.softmax(1)).sqrt();
  const at::Tensor distances = pool_thirds(outputs.distances);
  return at::cat({shares.flatten(1), distances.flatten(1), outputs.rooms.softmax(1)}, 1);
}

std::vector<core::ArraySpec> home_arrays(const HomeWords& words) {
  const auto classes = std::ssize(words.classes), rooms = std::ssize(words.rooms);
  std::vector<core::ArraySpec> arrays;
  const auto add = [&](const std::string& name, std::vector<std::int64_t> shape) {
    const std::int64_t out = shape[0];
    arrays.push_back({name + ".weight", std::move(shape)});
    arrays.push_back({name + ".bias", {out}});
  };
  for (std::size_t i = 0; i < kHomeLayers.size(); ++i) {
    const HomeLayer& layer = kHomeLayers.at(i);
    add(trunk_name(i), {layer.out, layer.in, layer.size, layer.size});
  }
  add("classes", {classes, kHomeChannels, 1, 1});
  add("distances", {1, kHomeChannels, 1, 1});
  add("rooms", {rooms, kHomeChannels});
  const std::int64_t dimensions = kThirds * (classes + 1) + rooms;
  arrays.push_back({"features.mean", {dimensions}});
  arrays.push_back({"features.deviation", {dimensions}});
  return arrays;
}

HomeNetwork::HomeNetwork(const core::Weights& weights, c10::Device device) : device_(device) {
  for (std::size_t i = 0; i < kHomeLayers.size(); ++i) {
    trunk_.push_back(prepared(weights, trunk_name(i), kHomeLayers.at(i), device));
  }
  constexpr HomeLayer kPointwise{kHomeChannels, 0, 1, 1, 1};
  classes_ = prepared(weights, "classes", kPointwise, device);
  distances_ = prepared(weights, "distances", kPointwise, device);
  rooms_weight_ = weights.at("rooms.weight").to(device);
  rooms_bias_ = weights.at("rooms.bias").to(device);
}

HomeOutputs HomeNetwork::run(const at::Tensor& pictures) const {
  at::Tensor x = prepare(pictures, device_, Layout::kChannelsLast);
  for (const Convolution& layer : trunk_) {
    x = apply(layer, x);
    at::relu_(x);
  }
  return {apply(classes_, x), apply(distances_, x),
          at::linear(x.mean({2, 3}), rooms_weight_, rooms_bias_)};
}

void write_home_network(const std::filesystem::path& file, const core::Weights& weights,
                        const HomeWords& words) {
  features::write_safetensors(file, core::as_arrays(weights),
                              {{kFormatKey, kFormat},
                               {kClassesKey, fmt::format("{}", fmt::join(words.classes, " "))},
                               {kRoomsKey, words.rooms}});
}

HomeFile read_home_network(const std::filesystem::path& file) {
  const features::TensorFile arrays = features::TensorFile::open(file);
  const auto& metadata = arrays.metadata();
  const auto value = [&](const char* key) {
    const auto found = metadata.find(key);
    if (found == metadata.end()) {
      fault(file, key, "no such metadata; a file of `enfilade pretrain` is expected");
    }
    return found->second;
  };
  if (value(kFormatKey) != kFormat) {
    fault(file, kFormatKey,
          fmt::format("{:?} is expected: run `enfilade pretrain` of this version", kFormat));
  }
  HomeFile home{{}, {parse_classes(file, value(kClassesKey)), value(kRoomsKey)}};
  if (home.words.classes.empty() || home.words.rooms.empty()) {
    fault(file, kClassesKey, "at least one class and one room are expected");
  }
  home.weights =
      core::read_weights(arrays, home_arrays(home.words), [](std::string_view) { return false; });
  return home;
}

}  // namespace enfilade::neural::encoders
