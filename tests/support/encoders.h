/// \file  What tests of image encoders do with pictures and features.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/encoder.h"

namespace enfilade::tests {

inline std::vector<float> encoded(neural::ImageEncoder& encoder, std::span<const float> pictures,
                                  std::size_t n, const Camera& camera) {
  std::vector<float> features(n * encoder.dimensions());
  encoder.encode(pictures, n, camera, features);
  return features;
}

/// Largest difference beside the largest number of `b`.
inline double relative_difference(std::span<const float> a, std::span<const float> b) {
  double largest = 0, difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(double{b[i]}));
    difference = std::max(difference, std::abs(double{a[i]} - double{b[i]}));
  }
  return difference / largest;
}

/// The numbers of a float32 array of a file, which has it.
inline std::vector<float> numbers(const features::TensorFile& file, const char* name) {
  const features::NamedArray& array = *file.find(name);
  std::vector<float> values(array.elements());
  std::memcpy(values.data(), array.bytes.data(), array.bytes.size());
  return values;
}

/// A python3 that has these packages, "torch, timm": the first on the path may be another one than
/// Debian's.
inline std::optional<std::string> python_with(const std::string& packages) {
  for (const std::string python : {"python3", "/usr/bin/python3"}) {
    const std::string command = python + " -c 'import " + packages + "' > /dev/null 2>&1";
    if (std::system(command.c_str()) == 0) return python;
  }
  return std::nullopt;
}

}  // namespace enfilade::tests
