#include "enfilade/neural/core/resident_views.h"

#include <ATen/ATen.h>
#include <algorithm>

namespace enfilade::neural::core {
namespace {

constexpr std::int64_t kFirstRows = 64 * ResidentViews::kViews;

}  // namespace

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
