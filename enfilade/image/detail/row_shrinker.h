/// \file  Area averages of pictures whose rows come one after the other, so that a large picture
/// never is in memory. Internal.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace enfilade::image::detail {

/// Makes a smaller picture. A pixel is the exact mean of the area it covers, rounded to nearest.
class RowShrinker {
 public:
  struct Size {
    std::uint32_t width = 0, height = 0;
  };
  /// \param to  takes small.width x small.height x channels bytes, and outlives this
  /// \pre 1 <= small <= large, in both directions
  RowShrinker(Size large, Size small, std::uint32_t channels, std::uint8_t* to);

  /// A place for the next row of the large picture. It is the row's own one where sizes are equal.
  std::uint8_t* row() { return same_ ? to_ : row_.data(); }
  /// Takes the next row. \pre at most large.height times
  void add(const std::uint8_t* row);

 private:
  // The source pixels that an output pixel covers along an axis. Units: a source pixel has `out` of
  // them and an output pixel `in`, which are whole numbers, so means are exact.
  struct Cover {
    std::size_t first = 0, last = 0;  // source pixels, both included
    std::uint32_t first_weight = 0, last_weight = 0;

    std::uint32_t weight(std::size_t at, std::uint32_t out) const {
      if (at == first) return first_weight;
      return at == last ? last_weight : out;
    }
  };
  static std::vector<Cover> covers(std::uint32_t in, std::uint32_t out);
  void write_row();

  Size large_, small_;
  std::size_t channels_;
  bool same_;
  std::uint8_t* to_;                   // the next output row
  std::size_t in_ = 0, out_ = 0;       // the next rows
  std::vector<Cover> columns_, rows_;  // empty where sizes are equal
  std::vector<std::uint32_t> sums_;
  std::vector<std::uint8_t> row_;
};

}  // namespace enfilade::image::detail
