#include "enfilade/image/detail/row_shrinker.h"

#include <algorithm>

namespace enfilade::image::detail {

std::vector<RowShrinker::Cover> RowShrinker::covers(std::uint32_t in, std::uint32_t out) {
  std::vector<Cover> all(out);
  for (std::uint64_t i = 0; i < out; ++i) {
    const std::uint64_t begin = i * in, end = begin + in;  // units
    Cover& cover = all[i];
    cover.first = begin / out;
    cover.last = (end - 1) / out;
    cover.first_weight =
        static_cast<std::uint32_t>(std::min(end, (cover.first + 1) * std::uint64_t{out}) - begin);
    cover.last_weight = static_cast<std::uint32_t>(end - cover.last * std::uint64_t{out});
  }
  return all;
}

RowShrinker::RowShrinker(Size large, Size small, std::uint32_t channels, std::uint8_t* to)
    : large_(large),
      small_(small),
      channels_(channels),
      same_(large.width == small.width && large.height == small.height),
      to_(to) {
  if (same_) return;
  columns_ = covers(large.width, small.width);
  rows_ = covers(large.height, small.height);
  sums_.resize(std::size_t{large.width} * channels);
  row_.resize(sums_.size());
}

void RowShrinker::add(const std::uint8_t* row) {
  if (same_) {
    const std::size_t bytes = large_.width * channels_;
    if (row != to_) std::copy_n(row, bytes, to_);
    to_ += bytes;
    return;
  }
  // A row may belong to two output rows. 255 * kLongestEdge fits into the 32 bits of a sum.
  for (; out_ < rows_.size() && rows_[out_].first <= in_; ++out_) {
    const std::uint32_t weight = rows_[out_].weight(in_, small_.height);
    for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k] += weight * row[k];
    if (rows_[out_].last > in_) break;
    write_row();
  }
  ++in_;
}

// Averages columns of weighted sums down to one output row.
void RowShrinker::write_row() {
  const std::uint64_t area = std::uint64_t{large_.width} * large_.height;
  for (const Cover& cover : columns_) {
    for (std::size_t c = 0; c < channels_; ++c) {
      std::uint64_t sum = area / 2;
      for (std::size_t x = cover.first; x <= cover.last; ++x) {
        sum += std::uint64_t{cover.weight(x, small_.width)} * sums_[x * channels_ + c];
      }
      *to_++ = static_cast<std::uint8_t>(sum / area);
    }
  }
  std::ranges::fill(sums_, 0U);
}

}  // namespace enfilade::image::detail
