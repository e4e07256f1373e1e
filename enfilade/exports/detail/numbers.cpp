#include "enfilade/exports/detail/numbers.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/half.h"

namespace enfilade::exports::detail {

using features::Hdf5Type;

StoredNumbers::StoredNumbers(Hdf5Type type) : type_(type) {
  if (type != Hdf5Type::kFloat16 && type != Hdf5Type::kFloat32 && type != Hdf5Type::kFloat64) {
    throw ArgumentError("type of features: floats of 16, 32 or 64 bits are allowed");
  }
}

std::span<const std::byte> StoredNumbers::store(std::span<const float> numbers,
                                                const std::string& where) {
  if (type_ == Hdf5Type::kFloat32) return std::as_bytes(numbers);
  if (type_ == Hdf5Type::kFloat64) {
    doubles_.assign(numbers.begin(), numbers.end());
    return std::as_bytes(std::span(doubles_));
  }
  halves_.resize(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    halves_[i] = to_half(numbers[i]);
    if ((halves_[i] & 0x7c00U) == 0x7c00U) {
      throw ArgumentError(
          fmt::format("{}: {} is no number of 16 bits; 32 would hold it", where, numbers[i]));
    }
  }
  return std::as_bytes(std::span(halves_));
}

void pool_depth(std::span<const float> depths, std::size_t pictures, std::size_t cells,
                std::size_t cell, float unit, std::span<float> out) {
  const std::size_t edge = cells * cell;
  EN_CHECK_EQ(depths.size(), pictures * edge * edge);
  EN_CHECK_EQ(out.size(), pictures * cells * cells);
  std::vector<double> sums(out.size());
  std::vector<std::size_t> counts(out.size());
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!(depths[i] > 0)) continue;
    const std::size_t row = i / edge;  // of all pictures, one below the other
    const std::size_t place = row / cell * cells + i % edge / cell;
    sums[place] += std::min(depths[i] / unit, 1.0F);
    ++counts[place];
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = counts[i] == 0 ? 0.0F : static_cast<float>(sums[i] / static_cast<double>(counts[i]));
  }
}

std::vector<features::Hdf5Attribute> view_attributes(const std::string& scan,
                                                     const std::string& viewpoint,
                                                     const Camera& camera) {
  // Without the rounding error of a conversion to radians and back.
  const double vfov = std::round(to_degrees(camera.vertical_field_of_view) * 1e9) / 1e9;
  features::Hdf5Value field = vfov;
  if (vfov == std::floor(vfov)) field = static_cast<std::int64_t>(vfov);
  return {{"scanId", scan},
          {"viewpointId", viewpoint},
          {"image_w", std::int64_t{camera.width}},
          {"image_h", std::int64_t{camera.height}},
          {"vfov", std::move(field)}};
}

}  // namespace enfilade::exports::detail
