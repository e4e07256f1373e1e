/// \file  Tensors on cards, sent among ranks by c10d's NCCL, where this build has it.
#pragma once
#include <ATen/core/Tensor.h>
#include <chrono>
#include <memory>
#include <string>
#include <torch/csrc/distributed/c10d/Store.hpp>

namespace enfilade::neural::core {

/// One card of each rank. All ranks call the same functions in the same order; each returns when
/// the result is there. Earlier work of the current stream comes first. One thread at a time.
///
/// All functions throw std::exception of c10d's if a rank or its card fails, or does not answer.
class CardLink {
 public:
  virtual ~CardLink() = default;
  /// As the functions of packing.h.
  virtual void exchange(const at::Tensor& given, const at::Tensor& out) = 0;
  virtual void collect(const at::Tensor& given, const at::Tensor& out) = 0;
  virtual void add_up(const at::Tensor& values) = 0;
};

/// "NCCL 2.28.9", or empty: this build has none.
std::string nccl_version();
/// Identifies a card among those of all computers; empty if this build has no NCCL.
std::string identity_of_card(c10::Device card);
/// Connects the ranks' cards. \pre this build has NCCL \throws as CardLink; Error if the library is
/// of another version than its headers
std::unique_ptr<CardLink> link_cards(const c10::intrusive_ptr<c10d::Store>& store, int rank,
                                     int size, c10::Device card, std::chrono::milliseconds timeout);

}  // namespace enfilade::neural::core
