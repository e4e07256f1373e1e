/// \file  Tensors sent among ranks. All contiguous, of the same sizes everywhere; in each call, on
/// the CPU in all ranks or on a card in all. When a call returns, its result is there.
///
/// Those on cards are sent by NCCL after connect_cards(), where that connected them; otherwise
/// through the CPU's memory.
#pragma once
#include <ATen/core/Tensor.h>

#include "enfilade/neural/ranks.h"

namespace enfilade::neural::core {

/// Connects the cards of the ranks, if each has one of its own, all have been built with NCCL, and
/// the variable ENFILADE_NCCL is not "0". Connected once.
/// \param card of this rank; that of later tensors
/// \throws Error with the way to do without NCCL, if it fails
void connect_cards(Ranks& ranks, c10::Device card);

/// Sends the k-th of size() equal parts of `given` to rank k. \return what all sent here, by rank
at::Tensor exchange(Ranks& ranks, const at::Tensor& given);
/// Puts the tensors of all ranks one behind the other.
void collect(Ranks& ranks, const at::Tensor& given, const at::Tensor& out);
/// Adds the tensors of all ranks in an order that depends on their number.
void add_up(Ranks& ranks, const at::Tensor& values);

}  // namespace enfilade::neural::core
