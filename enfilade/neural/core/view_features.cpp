#include "enfilade/neural/core/view_features.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <string>

#include "enfilade/core/errors.h"

namespace enfilade::neural::core {
namespace {

constexpr std::size_t kNamed = 5;  // missing viewpoints that a message names

std::vector<std::uint32_t> rows_of(const features::FeatureSet& features,
                                   const graph::NavGraph& graph,
                                   std::vector<std::string>& missing) {
  std::vector<std::uint32_t> rows(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex viewpoint(i);
    if (!graph.included(viewpoint)) continue;
    const auto row = features.row(graph.scan(), graph.id(viewpoint));
    if (row) {
      rows[i] = static_cast<std::uint32_t>(*row);
    } else {
      missing.push_back(graph.scan() + "_" + graph.id(viewpoint));
    }
  }
  return rows;
}

constexpr std::int64_t kFirstRows = 64 * ResidentViews::kViews;

}  // namespace

ViewFeatures::ViewFeatures(features::FeatureSet features, const tasks::EpisodeSet& episodes)
    : features_(std::move(features)), graphs_(episodes.graphs), rows_(episodes.graphs->size()) {
  if (features_.info().views != kViews) {
    refuse("features", "", "wrong-views",
           fmt::format("{} views a viewpoint, not {}", features_.info().views, kViews));
  }
  std::vector<std::string> missing;
  for (const tasks::ReferencePath& path : episodes.paths) {
    std::vector<std::uint32_t>& rows = rows_[path.scan.at()];
    if (rows.empty()) rows = rows_of(features_, episodes.graphs->graph(path.scan), missing);
  }
  if (missing.empty()) return;
  const std::size_t count = missing.size();
  if (count > kNamed) missing.resize(kNamed);
  refuse("features", "", "missing-viewpoints",
         fmt::format("none for {} viewpoints that agents may come to in split {}: {}{}", count,
                     episodes.split, fmt::join(missing, ", "), count > kNamed ? ", ..." : ""));
}

ResidentViews::ResidentViews(std::int64_t dimensions, c10::Device device, Source source)
    : dimensions_(dimensions),
      device_(device),
      source_(std::move(source)),
      table_(at::zeros({kFirstRows, dimensions}, at::TensorOptions(at::kFloat).device(device))) {}

std::int64_t ResidentViews::first_row(graph::Location location) {
  const auto [known, is_new] =
      rows_.try_emplace({location.scan.value, location.viewpoint.value}, used_);
  if (is_new) {
    const auto size = static_cast<std::size_t>(kViews * dimensions_);
    to_send_.resize(to_send_.size() + size);
    source_(location, std::span(to_send_).last(size));
    used_ += kViews;
  }
  return known->second;
}

void ResidentViews::send() {
  if (to_send_.empty()) return;
  const std::int64_t rows = static_cast<std::int64_t>(to_send_.size()) / dimensions_;
  const std::int64_t before = used_ - rows;
  if (table_.size(0) < used_) {
    const at::Tensor larger =
        at::zeros({std::max(2 * table_.size(0), used_), dimensions_}, table_.options());
    larger.narrow(0, 0, before).copy_(table_.narrow(0, 0, before));
    table_ = larger;
  }
  table_.narrow(0, before, rows).copy_(at::from_blob(to_send_.data(), {rows, dimensions_}));
  to_send_.clear();
}

at::Tensor ResidentViews::gather(const std::vector<std::int64_t>& rows) {
  send();
  return table_.index_select(0, at::tensor(rows, at::kLong).to(device_));
}

}  // namespace enfilade::neural::core
