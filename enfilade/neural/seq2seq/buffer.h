/// \file  Memory that is reused from one rollout to the next.
#pragma once
#include <ATen/ATen.h>
#include <cstdint>

namespace enfilade::neural::seq2seq {

/// Grows when needed, so a rollout gets no new pages from the system. Its content after get() is
/// undefined.
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
