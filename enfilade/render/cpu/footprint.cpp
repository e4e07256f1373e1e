#include "enfilade/render/cpu/footprint.h"

#include <algorithm>

#include "enfilade/render/cpu/sampling.h"

namespace enfilade::render::cpu {
namespace {

constexpr std::size_t kRowStep = 8;
constexpr std::size_t kCacheLine = 64;

// A load whose value is not used. Processors drop prefetch instructions when more than a few dozen
// are in flight, but never loads.
void read(const std::uint8_t* p) { asm volatile("" : : "r"(*p)); }

}  // namespace

Footprint::Footprint(std::span<const PlannedRow> rows, CubeFace face, std::uint32_t size)
    : size_(size), top_(static_cast<std::int32_t>(size)) {
  if (size > kLargest || rows.empty()) return;
  std::fill_n(begin_.begin(), size, static_cast<float>(size));
  std::fill_n(end_.begin(), size, -1.0F);
  for (std::size_t k = 0; k < rows.size(); k += kRowStep) add_row(rows[k], face);
  add_row(rows.back(), face);
}

void Footprint::add_row(const PlannedRow& row, CubeFace face) {
  const auto stretches = row.plan.stretches();
  const auto found = std::ranges::find(stretches, face, &Stretch::face);
  if (found == stretches.end()) return;
  const FaceLine& line = row.lines[index(face)];
  const auto point = [&](std::uint32_t column) {
    constexpr float kTexels = 1.0F / 32768;
    const TexelPoint p = texel_point(line, size_, column);
    const float last = static_cast<float>(size_ - 1);
    return Point{std::min(static_cast<float>(p.x) * kTexels, last),
                 std::min(static_cast<float>(p.y) * kTexels, last)};
  };
  const Point left = point(found->begin), right = point(found->end - 1);
  add_edge(left, right);
  if (started_) {
    add_edge(left_, left);
    add_edge(right_, right);
  }
  started_ = true;
  left_ = left;
  right_ = right;
}

void Footprint::add_edge(Point a, Point b) {
  if (a.y > b.y) std::swap(a, b);
  const float slope = b.y > a.y ? (b.x - a.x) / (b.y - a.y) : 0;
  const auto first = static_cast<std::int32_t>(a.y), last = static_cast<std::int32_t>(b.y);
  top_ = std::min(top_, first);
  bottom_ = std::max(bottom_, last);
  for (std::int32_t y = first; y <= last; ++y) {
    const auto k = static_cast<std::size_t>(y);
    const float from = y == first ? a.x : a.x + (static_cast<float>(y) - a.y) * slope;
    const float to = y == last ? b.x : a.x + (static_cast<float>(y + 1) - a.y) * slope;
    begin_[k] = std::min({begin_[k], from, to});
    end_[k] = std::max({end_[k], from, to});
  }
}

void Footprint::bring(const Face& face, std::size_t texel_bytes) const {
  for (std::int32_t y = top_; y <= bottom_; ++y) {
    const auto k = static_cast<std::size_t>(y);
    if (end_[k] < begin_[k]) continue;
    const std::uint8_t* row = face.origin + k * face.stride;
    const std::uint8_t* last = row + static_cast<std::size_t>(end_[k] + 1) * texel_bytes;
    for (const std::uint8_t* p = row + static_cast<std::size_t>(begin_[k]) * texel_bytes; p < last;
         p += kCacheLine) {
      read(p);
    }
  }
}

}  // namespace enfilade::render::cpu
