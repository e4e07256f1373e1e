/// \file  Reads the pickles that torch.save() writes: the opcodes and classes that a dictionary of
/// tensors needs. Objects of other classes are opaque; nothing that a pickle names is called.
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

/// The classes and functions that a pickle may name.
enum class Callable : std::uint8_t {
  kOrderedDict,
  kSize,           ///< torch.Size(items), a tuple
  kRebuildTensor,  ///< (storage, offset, shape, strides, ...)
  kParameter,      ///< (tensor, ...)
  kStorageType,    ///< torch.FloatStorage and the like; may be named, not called
  kModule,         ///< a class of TorchScript's code, which is not run; its attributes are kept
  kDropped,        ///< makes something that no tensor is in
  kUnknown,        ///< any other, which is not called: its result is Opaque
};
/// A class or function that a pickle names.
struct Global {
  std::string_view name;  ///< with the module; for a storage type, without it
  Callable callable = Callable::kSize;
  DType type = DType::kFloat32;  ///< of the elements, if it is a storage type
  /// Bytes of an element, if it is a storage type whose numbers DType lacks; else 0.
  std::size_t other_bytes = 0;
};

/// A part of a storage that tensors use as a storage of its own. Only in old files.
struct StorageView {
  std::string key;
  std::int64_t offset = 0, elements = 0;
};
/// The numbers of tensors, elsewhere in the file; in the pickle, a persistent id.
struct PickledStorage {
  std::string key;  ///< its name in the file
  DType type = DType::kFloat32;
  std::int64_t elements = 0;
  std::optional<StorageView> view;
  /// If DType lacks the type: its name and an element's bytes; `type` then means nothing.
  std::string_view other_type = {};
  std::size_t other_bytes = 0;

  std::size_t element_bytes() const { return other_bytes > 0 ? other_bytes : size_of(type); }
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
  std::vector<std::pair<Value*, Value*>> items;  ///< a key may repeat; its last value is valid
};
/// An object of TorchScript: a dictionary of its attributes.
struct Module {
  Dictionary attributes;
};
/// An object of a class that is not known, or what an unknown function would give.
struct Opaque {
  std::string_view maker;      ///< the class or function, with its module
  bool holds_numbers = false;  ///< a storage or tensor is among the arguments
};
struct Other {};  ///< None, a float, bytes, a set, an integer of more than 64 bits

struct Value {
  std::variant<Other, bool, std::int64_t, std::string, Tuple, List, Dictionary, Module, Global,
               PickledStorage, PickledTensor, Opaque>
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
