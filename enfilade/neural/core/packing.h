/// \file  Values as bytes that go to other processes of the same program and kind of computer.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/neural/ranks.h"

namespace enfilade::neural::core {

/// Writes values one behind the other.
class ValuePacker {
 public:
  template <class T>
    requires(std::is_trivially_copyable_v<T>)
  void add(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add(std::string_view text) {
    add(text.size());
    bytes_ += text;
  }
  void add(const std::string& text) { add(std::string_view(text)); }
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.size());
    for (const T& value : values) add(value);
  }
  template <class T>
  void add(const std::optional<T>& value) {
    add(value.has_value());
    if (value) add(*value);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads them in the same order. \pre they were written by a Packer of this program
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}

  bool done() const noexcept { return bytes_.empty(); }
  template <class T>
  T get() {
    T value{};
    read(value);
    return value;
  }
  template <class T>
    requires(std::is_trivially_copyable_v<T>)
  void read(T& value) {
    std::memcpy(&value, cut(sizeof value).data(), sizeof value);
  }
  void read(std::string& text) { text = cut(get<std::size_t>()); }
  template <class T>
  void read(std::vector<T>& values) {
    values.resize(get<std::size_t>());
    for (T& value : values) read(value);
  }
  template <class T>
  void read(std::optional<T>& value) {
    value.reset();
    if (get<bool>()) read(value.emplace());
  }

 private:
  std::string_view cut(std::size_t count) {
    EN_CHECK(count <= bytes_.size());
    const std::string_view front = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return front;
  }

  std::string_view bytes_;
};

/// One value.
template <class T>
std::string packed(const T& value) {
  ValuePacker packer;
  packer.add(value);
  return packer.take();
}
template <class T>
T unpacked(std::string_view bytes) {
  return Unpacker(bytes).get<T>();
}

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
