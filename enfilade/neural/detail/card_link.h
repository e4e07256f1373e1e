/// \file  Tensors on cards, sent among ranks by c10d's NCCL, where this build has it.
#pragma once
#include <ATen/core/Tensor.h>
#include <chrono>
#include <memory>
#include <string>
#include <torch/csrc/distributed/c10d/Store.hpp>

namespace enfilade::neural::detail {

/// One card of each rank. All ranks call the same functions in the same order; each returns when
/// the result is there. What the current stream has to do comes before. One thread at a time.
///
/// All functions \throw std::exception of c10d's where a rank or its card fails, or none answers.
class CardLink {
 public:
  /// "NCCL 2.28.9", or empty: this build has none.
  static std::string library();
  /// Tells a card from all others, of this machine and of others.
  static std::string identity(c10::Device card);

  CardLink(const c10::intrusive_ptr<c10d::Store>& store, int rank, int size, c10::Device card,
           std::chrono::milliseconds timeout);
  ~CardLink();
  CardLink(const CardLink&) = delete;
  CardLink& operator=(const CardLink&) = delete;

  /// As the functions of rank_tensors.h.
  void exchange(const at::Tensor& given, const at::Tensor& out);
  void collect(const at::Tensor& given, const at::Tensor& out);
  void add_up(const at::Tensor& values);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::neural::detail
