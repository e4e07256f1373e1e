/// \file  Tensors sent among ranks. All on the CPU and contiguous, of the same sizes everywhere.
#pragma once
#include <ATen/core/Tensor.h>

#include "enfilade/neural/ranks.h"

namespace enfilade::neural::detail {

/// Sends the k-th of size() equal parts of `given` to rank k. \return what all sent here, by rank
at::Tensor exchange(Ranks& ranks, const at::Tensor& given);
/// Puts the tensors of all ranks one behind the other.
void collect(Ranks& ranks, const at::Tensor& given, const at::Tensor& out);
/// Adds the tensors of all ranks in an order that depends on their number.
void add_up(Ranks& ranks, const at::Tensor& values);

}  // namespace enfilade::neural::detail
