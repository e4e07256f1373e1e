/// \file  The part of Python's pickles that torch.save() needs for a dictionary of tensors.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/features/tensor_file.h"

namespace enfilade::features::formats {

struct Value;

/// Classes and functions that a pickle may name; all others are refused by their name.
enum class Callable : std::uint8_t {
  kOrderedDict,
  kSize,           ///< torch.Size, a tuple
  kRebuildTensor,  ///< (storage, offset, shape, strides, ...)
  kParameter,      ///< (tensor, ...)
  kStorageType,    ///< torch.FloatStorage and the like: not a function
};
struct Global {
  std::string_view name;  ///< with its module; of a storage type without
  Callable callable = Callable::kSize;
  DType type = DType::kFloat32;  ///< of a storage's elements
};

/// A part of a storage that is a storage of its own; in old files only.
struct StorageView {
  std::string key;
  std::int64_t offset = 0, elements = 0;
};
/// A persistent id: bytes elsewhere in the file.
struct PickledStorage {
  std::string key;
  DType type = DType::kFloat32;
  std::int64_t elements = 0;
  std::optional<StorageView> view;
};

struct PickledTensor {
  const Value* storage = nullptr;  ///< holds a PickledStorage; null for a parameter without data
  std::int64_t offset = 0;         ///< elements
  std::vector<std::int64_t> shape, strides;  ///< of equal lengths, all >= 0
};

struct List {
  std::vector<Value*> items;
};
struct Tuple {
  std::vector<Value*> items;
};
struct Dictionary {
  std::vector<std::pair<Value*, Value*>> items;  ///< the last value of a key counts
};
struct Other {};  ///< None, a float, bytes, a set, an integer of more than 64 bits

struct Value {
  std::variant<Other, bool, std::int64_t, std::string, Tuple, List, Dictionary, Global,
               PickledStorage, PickledTensor>
      is;
};

/// The values of a pickle. They refer to each other, possibly in cycles.
struct Pickle {
  std::deque<Value> values;
  const Value* root = nullptr;
  std::size_t bytes = 0;  ///< length of the pickle
};

/// Reads the pickle at the start of `bytes`. \param offset of `bytes` in the file, for messages
/// \throws InvalidInput
Pickle read_pickle(std::span<const std::byte> bytes, const std::string& name,
                   std::size_t offset = 0);

}  // namespace enfilade::features::formats
