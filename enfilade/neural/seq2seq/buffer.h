/// \file  Memory that is kept from one rollout to the next.
#pragma once
#include <ATen/ATen.h>

namespace enfilade::neural::seq2seq {

/// Grows when it has to, so that no pages are fetched anew in every rollout. What it holds after
/// get() is anything.
class Buffer {
 public:
  at::Tensor get(at::IntArrayRef shape, const at::TensorOptions& options) {
    std::int64_t needed = 1;
    for (const std::int64_t n : shape) needed *= n;
    if (!storage_.defined() || storage_.numel() < needed) storage_ = at::empty({needed}, options);
    return storage_.narrow(0, 0, needed).view(shape);
  }

 private:
  at::Tensor storage_;
};

}  // namespace enfilade::neural::seq2seq
