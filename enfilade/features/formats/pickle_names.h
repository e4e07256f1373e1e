/// \file  Opcodes of pickles, and the names in pickles of tensors.
#pragma once
#include <cstdint>
#include <string_view>

#include "enfilade/features/formats/pickle.h"

namespace enfilade::features::formats {

/// Opcodes of protocols 2 to 5 that torch.save() writes, with the names of Python's pickletools.
enum Opcode : std::uint8_t {
  kMark = '(',
  kStop = '.',
  kPop = '0',
  kPopMark = '1',
  kDup = '2',
  kBinFloat = 'G',
  kBinInt = 'J',
  kBinInt1 = 'K',
  kBinInt2 = 'M',
  kNone = 'N',
  kBinPersId = 'Q',
  kReduce = 'R',
  kBinString = 'T',
  kShortBinString = 'U',
  kBinUnicode = 'X',
  kEmptyList = ']',
  kAppend = 'a',
  kBuild = 'b',
  kGlobal = 'c',
  kDict = 'd',
  kAppends = 'e',
  kBinGet = 'h',
  kLongBinGet = 'j',
  kList = 'l',
  kBinPut = 'q',
  kLongBinPut = 'r',
  kSetItem = 's',
  kTuple = 't',
  kSetItems = 'u',
  kEmptyDict = '}',
  kEmptyTuple = ')',
  kBinBytes = 'B',
  kShortBinBytes = 'C',
  kProto = 0x80,
  kNewObj = 0x81,
  kTuple1 = 0x85,
  kTuple2 = 0x86,
  kTuple3 = 0x87,
  kNewTrue = 0x88,
  kNewFalse = 0x89,
  kLong1 = 0x8a,
  kLong4 = 0x8b,
  kShortBinUnicode = 0x8c,
  kBinUnicode8 = 0x8d,
  kBinBytes8 = 0x8e,
  kEmptySet = 0x8f,
  kAddItems = 0x90,
  kFrozenSet = 0x91,
  kStackGlobal = 0x93,
  kMemoize = 0x94,
  kFrame = 0x95,
};

struct NamedGlobal {
  std::string_view name;
  Global global;
};
inline constexpr NamedGlobal kGlobals[] = {
    {"collections.OrderedDict", {Callable::kOrderedDict}},
    {"torch.Size", {Callable::kSize}},
    {"torch._utils._rebuild_tensor", {Callable::kRebuildTensor}},
    {"torch._utils._rebuild_tensor_v2", {Callable::kRebuildTensor}},
    {"torch._utils._rebuild_parameter", {Callable::kRebuildParameter}},
    {"torch._utils._rebuild_parameter_with_state", {Callable::kRebuildParameter}},
    {"torch.nn.parameter.Parameter", {Callable::kParameter}},
};
inline constexpr NamedGlobal kStorageTypes[] = {
    {"HalfStorage", {Callable::kStorageType, DType::kFloat16}},
    {"BFloat16Storage", {Callable::kStorageType, DType::kBFloat16}},
    {"FloatStorage", {Callable::kStorageType, DType::kFloat32}},
    {"DoubleStorage", {Callable::kStorageType, DType::kFloat64}},
    {"IntStorage", {Callable::kStorageType, DType::kInt32}},
    {"LongStorage", {Callable::kStorageType, DType::kInt64}},
    {"ByteStorage", {Callable::kStorageType, DType::kUint8}},
    {"BoolStorage", {Callable::kStorageType, DType::kBool}},
};

}  // namespace enfilade::features::formats
