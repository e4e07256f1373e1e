/// \file  Numbers of tensors, for comparisons. Apart from agents_golden.h, which needs no libtorch.
#pragma once
#include <ATen/ATen.h>
#include <vector>

namespace enfilade::tests {

/// The elements of a tensor of any type, row by row.
inline std::vector<double> numbers(const at::Tensor& tensor) {
  const at::Tensor flat = tensor.detach().to(at::kCPU, at::kDouble).contiguous();
  return {flat.data_ptr<double>(), flat.data_ptr<double>() + flat.numel()};
}

}  // namespace enfilade::tests
