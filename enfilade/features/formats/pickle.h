/// \file  The part of Python's pickles that torch.save() needs for a dictionary of tensors.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/features/tensor_file.h"

namespace enfilade::features::formats {

struct Value;

/// What a pickle may name of Python's code; anything else is refused by its name.
enum class Callable : std::uint8_t {
  kOrderedDict,
  kSize,              ///< torch.Size, a tuple
  kRebuildTensor,     ///< (storage, offset, shape, strides, ...)
  kRebuildParameter,  ///< (tensor, ...)
  kParameter,         ///< (tensor, ...), as files of before PyTorch 0.4 have it
  kStorageType,       ///< torch.FloatStorage and the like: no function
};
struct Global {
  Callable callable = Callable::kSize;
  DType type = DType::kFloat32;  ///< of a storage's elements
};

/// Part of a storage that is a storage by itself: old files only.
struct StorageView {
  std::string key;
  std::int64_t offset = 0, elements = 0;
};
/// What a persistent id stands for: bytes that lie elsewhere in the file.
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
  std::vector<std::pair<Value*, Value*>> items;  ///< a key's later value counts
};
struct Other {};  ///< None, a float, bytes, a set, an integer of more than 64 bits

struct Value {
  std::variant<Other, bool, std::int64_t, std::string, Tuple, List, Dictionary, Global,
               PickledStorage, PickledTensor>
      is;
};

/// What a pickle makes. Values refer to each other, in rings, too.
struct Pickle {
  std::deque<Value> values;
  const Value* root = nullptr;
  std::size_t bytes = 0;  ///< that the pickle took
};

/// Reads the pickle at the start of `bytes`. \param offset of `bytes` in the file, for messages
/// \throws InvalidInput
Pickle read_pickle(std::span<const std::byte> bytes, const std::string& name,
                   std::size_t offset = 0);

/// The storages that the values of a pickle refer to, in the order of their first mention.
std::vector<const PickledStorage*> storages_of(const Pickle& pickle);

}  // namespace enfilade::features::formats
