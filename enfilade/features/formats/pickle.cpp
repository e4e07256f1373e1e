#include "enfilade/features/formats/pickle.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <unordered_map>

#include "enfilade/core/errors.h"

namespace enfilade::features::formats {
namespace {

// A pickle of 50,000 tensors has about 5 MB. The limit is there because an opcode of one byte can
// make a value of a hundred.
constexpr std::size_t kLongestPickle = std::size_t{64} << 20;
constexpr std::size_t kMostDimensions = 64;  // of a tensor, as in PyTorch
constexpr int kLatestProtocol = 5;

constexpr Global kGlobals[] = {
    {"collections.OrderedDict", Callable::kOrderedDict},
    {"torch.Size", Callable::kSize},
    {"torch._utils._rebuild_tensor", Callable::kRebuildTensor},
    {"torch._utils._rebuild_tensor_v2", Callable::kRebuildTensor},
    {"torch._utils._rebuild_parameter", Callable::kParameter},
    {"torch._utils._rebuild_parameter_with_state", Callable::kParameter},
    {"torch.nn.parameter.Parameter", Callable::kParameter},
    {"torch.device", Callable::kDropped},
};
// Code that a file of TorchScript brings with it has names of this kind.
constexpr std::string_view kScripted = "__torch__.";
constexpr Global kModule{kScripted, Callable::kModule};
// What marks the types of TorchScript's lists and dictionaries.
constexpr std::string_view kScriptedTypes = "torch.jit._pickle.";
constexpr Global kTyped{kScriptedTypes, Callable::kDropped};
// Of the modules torch and torch.cuda.
constexpr Global kStorageTypes[] = {
    {"HalfStorage", Callable::kStorageType, DType::kFloat16},
    {"BFloat16Storage", Callable::kStorageType, DType::kBFloat16},
    {"FloatStorage", Callable::kStorageType, DType::kFloat32},
    {"DoubleStorage", Callable::kStorageType, DType::kFloat64},
    {"IntStorage", Callable::kStorageType, DType::kInt32},
    {"LongStorage", Callable::kStorageType, DType::kInt64},
    {"ByteStorage", Callable::kStorageType, DType::kUint8},
    {"BoolStorage", Callable::kStorageType, DType::kBool},
};
// Those of numbers that are not read, of the same modules and torch.storage; with an element's
// bytes.
constexpr Global kOtherStorageTypes[] = {
    {"CharStorage", Callable::kStorageType, DType::kUint8, 1},
    {"ShortStorage", Callable::kStorageType, DType::kUint8, 2},
    {"ComplexFloatStorage", Callable::kStorageType, DType::kUint8, 8},
    {"ComplexDoubleStorage", Callable::kStorageType, DType::kUint8, 16},
    {"QInt8Storage", Callable::kStorageType, DType::kUint8, 1},
    {"QUInt8Storage", Callable::kStorageType, DType::kUint8, 1},
    {"QInt32Storage", Callable::kStorageType, DType::kUint8, 4},
    {"UntypedStorage", Callable::kStorageType, DType::kUint8, 1},
};

/// Pickle's stack machine. It builds values and calls nothing.
class Machine {
 public:
  Machine(std::span<const std::byte> bytes, const std::string& name, std::size_t offset,
          Pickle& into)
      : bytes_(bytes.first(std::min(bytes.size(), kLongestPickle))),
        name_(name),
        offset_(offset),
        into_(into) {}

  void run();

 private:
  struct Opcode {
    std::uint8_t code;
    void (*run)(Machine&);
  };
  static const Opcode kOpcodes[];

  [[noreturn]] void fail(const char* code, std::string message) const {
    refuse(name_, fmt::format("byte {}", offset_ + opcode_at_), code, std::move(message));
  }
  [[noreturn]] void fail_bad(const std::string& fault) const {
    fail("bad-pickle", "not a pickle of torch.save(): " + fault);
  }

  // --- bytes ---

  std::span<const std::byte> take(std::uint64_t count) {
    if (count > bytes_.size() - at_) {
      fail("truncated",
           bytes_.size() == kLongestPickle
               ? "the pickle is longer than 64 MiB, the most that is read"
               : fmt::format("the pickle is cut off: it ends at byte {}", offset_ + bytes_.size()));
    }
    const auto taken = bytes_.subspan(at_, static_cast<std::size_t>(count));
    at_ += taken.size();
    return taken;
  }

  // Little-endian, as this machine (safetensors.cpp).
  std::uint64_t unsigned_of(std::size_t size) {
    std::uint64_t value = 0;
    std::memcpy(&value, take(size).data(), size);
    return value;
  }

  std::string text_of(std::uint64_t size) {
    const auto bytes = take(size);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  std::string line() {
    std::string text;
    for (char c = 0; (c = static_cast<char>(take(1)[0])) != '\n';) text += c;
    return text;
  }

  // --- the stack ---

  template <class T>
  void push(T is) {
    into_.values.push_back({std::move(is)});
    stack_.push_back(&into_.values.back());
  }

  std::size_t bottom() const { return marks_.empty() ? 0 : marks_.back(); }

  Value* pop() {
    Value* const value = top();
    stack_.pop_back();
    return value;
  }

  Value* top() const {
    if (stack_.size() <= bottom()) fail_bad("an opcode takes a value from an empty stack");
    return stack_.back();
  }

  std::vector<Value*> pop_last(std::size_t count) {
    if (stack_.size() - bottom() < count) fail_bad("an opcode takes a value from an empty stack");
    const auto first = stack_.end() - static_cast<std::ptrdiff_t>(count);
    std::vector<Value*> values(first, stack_.end());
    stack_.erase(first, stack_.end());
    return values;
  }

  std::vector<Value*> pop_to_mark() {
    if (marks_.empty()) fail_bad("an opcode goes back to a mark that was not set");
    auto values = pop_last(stack_.size() - marks_.back());
    marks_.pop_back();
    return values;
  }

  template <class T>
  T& as(Value* value, const char* what) const {
    T* const is = std::get_if<T>(&value->is);
    if (is == nullptr) fail_bad(fmt::format("a value of another type where {} is expected", what));
    return *is;
  }

  // --- what opcodes do ---

  void push_int32() {
    const auto bits = static_cast<std::uint32_t>(unsigned_of(4));
    push(std::int64_t{static_cast<std::int32_t>(bits)});
  }

  // Two's complement of any length, little-endian.
  void push_long(std::uint64_t size) {
    const auto bytes = take(size);
    if (size > sizeof(std::int64_t)) {
      push(Other{});
      return;
    }
    std::uint64_t value =
        !bytes.empty() && (bytes.back() & std::byte{0x80}) != std::byte{0} ? ~std::uint64_t{0} : 0;
    for (std::size_t i = bytes.size(); i-- > 0;) {
      value = value << 8U | std::to_integer<std::uint64_t>(bytes[i]);
    }
    push(static_cast<std::int64_t>(value));
  }

  // For values that no tensor needs.
  void skip(std::uint64_t size) {
    take(size);
    push(Other{});
  }

  // What is put into an opaque object is dropped.
  bool top_is_opaque() const { return std::holds_alternative<Opaque>(top()->is); }

  void append(const std::vector<Value*>& items) {
    if (top_is_opaque()) return;
    auto& list = as<List>(top(), "a list").items;
    list.insert(list.end(), items.begin(), items.end());
  }

  void add_pairs(std::span<Value* const> values, Dictionary& to) const {
    if (values.size() % 2 != 0) fail_bad("a dictionary's key has no value");
    for (std::size_t i = 0; i < values.size(); i += 2) {
      to.items.emplace_back(values[i], values[i + 1]);
    }
  }

  void push_dictionary(std::span<Value* const> pairs) {
    Dictionary dictionary;
    add_pairs(pairs, dictionary);
    push(std::move(dictionary));
  }

  void set_items(std::span<Value* const> pairs) {
    if (top_is_opaque()) return;
    add_pairs(pairs, as<Dictionary>(top(), "a dictionary"));
  }

  void check_protocol(std::uint64_t protocol) const {
    if (protocol > kLatestProtocol) {
      fail("bad-pickle", fmt::format("pickle protocol {}; protocols up to {} are read", protocol,
                                     kLatestProtocol));
    }
  }

  void put(std::size_t key_bytes) {
    Value* const value = top();
    memo_[unsigned_of(key_bytes)] = value;
  }

  void get(std::size_t key_bytes) {
    const std::uint64_t key = unsigned_of(key_bytes);
    const auto found = memo_.find(key);
    if (found == memo_.end()) {
      fail_bad(fmt::format("recalls value {}, which was never stored", key));
    }
    stack_.push_back(found->second);
  }

  void push_global() {
    const std::string module = line();
    push(global(module, line()));
  }

  void push_stack_global() {
    const auto names = pop_last(2);
    push(global(as<std::string>(names[0], "a name"), as<std::string>(names[1], "a name")));
  }

  void call_function() {
    const auto called = pop_last(2);
    if (const auto* const opaque = std::get_if<Opaque>(&called[0]->is)) {
      push(Opaque{opaque->maker, opaque->holds_numbers || holds_numbers(*called[1])});
      return;
    }
    const Global& function = as<Global>(called[0], "a function");
    if (function.callable == Callable::kUnknown) {
      push(Opaque{function.name, holds_numbers(*called[1])});
      return;
    }
    call(function, as<Tuple>(called[1], "arguments"));
  }

  // A class, its arguments and named ones. No class that is known takes any.
  void call_with_names() {
    const auto called = pop_last(3);
    const auto* const function = std::get_if<Global>(&called[0]->is);
    push(Opaque{function != nullptr ? function->name : "a class",
                holds_numbers(*called[1]) || holds_numbers(*called[2])});
  }

  static bool holds_numbers(const Value& value) {
    std::size_t left = 1000;  // values to look at: a small file can nest them without end
    return holds_numbers(value, left);
  }
  static bool holds_numbers(const Value& value, std::size_t& left) {
    if (left == 0) return false;
    --left;
    if (std::holds_alternative<PickledStorage>(value.is) ||
        std::holds_alternative<PickledTensor>(value.is)) {
      return true;
    }
    if (const auto* const opaque = std::get_if<Opaque>(&value.is)) return opaque->holds_numbers;
    const auto* const tuple = std::get_if<Tuple>(&value.is);
    const auto* const list = std::get_if<List>(&value.is);
    if (tuple == nullptr && list == nullptr) return false;
    return std::ranges::any_of(tuple != nullptr ? tuple->items : list->items,
                               [&](const Value* item) { return holds_numbers(*item, left); });
  }

  Global global(const std::string& module, const std::string& name) {
    const std::string full = module + "." + name;
    const auto found = std::ranges::find(kGlobals, full, &Global::name);
    if (found != std::end(kGlobals)) return *found;
    if (full.starts_with(kScripted)) return kModule;
    if (full.starts_with(kScriptedTypes)) return kTyped;
    const bool is_storage =
        (module == "torch" || module == "torch.cuda") && name.ends_with("Storage");
    const auto type = std::ranges::find(kStorageTypes, name, &Global::name);
    if (is_storage && type != std::end(kStorageTypes)) return *type;
    const auto other = std::ranges::find(kOtherStorageTypes, name, &Global::name);
    if ((is_storage || module == "torch.storage") && other != std::end(kOtherStorageTypes)) {
      return *other;
    }
    // The text is a value of its own, so that views of it stay valid.
    constexpr std::size_t kLongestName = 100;
    into_.values.push_back({full.substr(0, kLongestName)});
    return {std::get<std::string>(into_.values.back().is), Callable::kUnknown};
  }

  void call(const Global& function, const Tuple& arguments) {
    switch (function.callable) {
      case Callable::kOrderedDict:
        push(ordered_dictionary(arguments));
        return;
      case Callable::kSize:
        if (arguments.items.size() != 1) {
          fail_bad(fmt::format("torch.Size of {} arguments, not 1", arguments.items.size()));
        }
        if (std::holds_alternative<Tuple>(arguments.items[0]->is)) {
          stack_.push_back(arguments.items[0]);
        } else {
          push(Tuple{as<List>(arguments.items[0], "a size").items});
        }
        return;
      case Callable::kRebuildTensor:
        push(tensor(arguments));
        return;
      case Callable::kParameter:
        // Very old files give a parameter its tensor only when they set its state.
        if (arguments.items.empty()) {
          push(PickledTensor{});
        } else if (const auto* made = std::get_if<Opaque>(&arguments.items[0]->is)) {
          push(Opaque{*made});
        } else {
          push(PickledTensor{as<PickledTensor>(arguments.items[0], "a tensor")});
        }
        return;
      case Callable::kModule:
        push(Module{});
        return;
      case Callable::kDropped:
        push(Other{});
        return;
      case Callable::kUnknown:
        push(Opaque{function.name});
        return;
      case Callable::kStorageType:
        fail_bad("a storage's type is called like a function");
    }
  }

  // Made from nothing or, as Python 2 wrote it, from a list of pairs.
  Dictionary ordered_dictionary(const Tuple& arguments) const {
    Dictionary dictionary;
    if (arguments.items.empty()) return dictionary;
    for (Value* const item : as<List>(arguments.items[0], "a list of pairs").items) {
      const auto* list = std::get_if<List>(&item->is);
      add_pairs(list != nullptr ? list->items : as<Tuple>(item, "a pair").items, dictionary);
    }
    return dictionary;
  }

  void build() {
    Value* const state = pop();
    if (auto* const module = std::get_if<Module>(&top()->is)) {
      const auto* attributes = std::get_if<Dictionary>(&state->is);
      if (attributes != nullptr) module->attributes = *attributes;
      return;
    }
    auto* const built = std::get_if<PickledTensor>(&top()->is);
    // The state of a dictionary is its _metadata, that of a tensor whether it is trained.
    if (built == nullptr || built->storage != nullptr) return;
    const auto* parts = std::get_if<Tuple>(&state->is);
    if (parts != nullptr && !parts->items.empty()) {
      *built = as<PickledTensor>(parts->items[0], "a tensor");
    }
  }

  std::int64_t count(Value* value, const char* what) const {
    const std::int64_t number = as<std::int64_t>(value, what);
    if (number < 0) fail_bad(fmt::format("{}: {}, not 0 or more", what, number));
    return number;
  }

  std::vector<std::int64_t> counts(Value* value, const char* what) const {
    std::vector<std::int64_t> numbers;
    for (Value* const item : as<Tuple>(value, what).items) numbers.push_back(count(item, what));
    return numbers;
  }

  PickledTensor tensor(const Tuple& arguments) const {
    const auto& items = arguments.items;
    if (items.size() < 4) {
      fail_bad(fmt::format(
          "a tensor of {} arguments; storage, offset, shape and strides are needed", items.size()));
    }
    as<PickledStorage>(items[0], "a storage");
    PickledTensor tensor{items[0], count(items[1], "a tensor's offset"),
                         counts(items[2], "a tensor's shape"),
                         counts(items[3], "a tensor's strides")};
    if (tensor.shape.size() != tensor.strides.size() || tensor.shape.size() > kMostDimensions) {
      fail_bad(
          fmt::format("a tensor of {} dimensions and {} strides; the numbers must be equal, at "
                      "most {}",
                      tensor.shape.size(), tensor.strides.size(), kMostDimensions));
    }
    // Index of the argument `metadata`. It has a key "conj" or "neg" if PyTorch conjugates or
    // negates the stored numbers whenever the tensor is read; else it is empty, or not there.
    constexpr std::size_t kMetadata = 6;
    if (items.size() > kMetadata) {
      const auto* metadata = std::get_if<Dictionary>(&items[kMetadata]->is);
      if (metadata != nullptr && !metadata->items.empty()) {
        fail("unsupported-type",
             "a tensor whose conjugation or negation is not carried out yet; save "
             "tensor.resolve_conj().resolve_neg() instead");
      }
    }
    return tensor;
  }

  // ("storage", type, key, where it was, elements[, None or (key, offset, elements)])
  void push_storage() {
    const auto& items = as<Tuple>(pop(), "a storage's place").items;
    if (items.size() < 5 || as<std::string>(items[0], "\"storage\"") != "storage") {
      fail_bad("a persistent id that is not of a storage");
    }
    const Global& type = as<Global>(items[1], "a storage's type");
    if (type.callable != Callable::kStorageType) {
      fail_bad(fmt::format("a storage of type {}, which is not a type of storages", type.name));
    }
    PickledStorage storage{as<std::string>(items[2], "a storage's key"), type.type,
                           count(items[4], "a storage's size"),          std::nullopt,
                           type.other_bytes > 0 ? type.name : "",        type.other_bytes};
    if (items.size() > 5 && std::holds_alternative<Tuple>(items[5]->is)) {
      const auto& view = std::get<Tuple>(items[5]->is).items;
      if (view.size() != 3) {
        fail_bad(fmt::format("a view of a storage with {} parts, not key, offset and size",
                             view.size()));
      }
      storage.view = {as<std::string>(view[0], "a view's key"), count(view[1], "a view's offset"),
                      count(view[2], "a view's size")};
    }
    push(std::move(storage));
  }

  std::span<const std::byte> bytes_;
  const std::string& name_;
  std::size_t offset_;
  Pickle& into_;
  std::size_t at_ = 0;
  std::size_t opcode_at_ = 0;
  std::vector<Value*> stack_;
  std::vector<std::size_t> marks_;
  std::unordered_map<std::uint64_t, Value*> memo_;
};

// The opcodes of protocols 2 to 5 that torch.save() writes, with their names in Python's
// pickletools.
const Machine::Opcode Machine::kOpcodes[] = {
    // Scalars.
    {'N', [](Machine& m) { m.push(Other{}); }},                                      // NONE
    {0x88, [](Machine& m) { m.push(true); }},                                        // NEWTRUE
    {0x89, [](Machine& m) { m.push(false); }},                                       // NEWFALSE
    {'K', [](Machine& m) { m.push(static_cast<std::int64_t>(m.unsigned_of(1))); }},  // BININT1
    {'M', [](Machine& m) { m.push(static_cast<std::int64_t>(m.unsigned_of(2))); }},  // BININT2
    {'J', [](Machine& m) { m.push_int32(); }},                                       // BININT
    {0x8a, [](Machine& m) { m.push_long(m.unsigned_of(1)); }},                       // LONG1
    {0x8b, [](Machine& m) { m.push_long(m.unsigned_of(4)); }},                       // LONG4
    {'G', [](Machine& m) { m.skip(sizeof(double)); }},                               // BINFLOAT
    // Texts and bytes.
    {'U', [](Machine& m) { m.push(m.text_of(m.unsigned_of(1))); }},   // SHORT_BINSTRING
    {0x8c, [](Machine& m) { m.push(m.text_of(m.unsigned_of(1))); }},  // SHORT_BINUNICODE
    {'T', [](Machine& m) { m.push(m.text_of(m.unsigned_of(4))); }},   // BINSTRING
    {'X', [](Machine& m) { m.push(m.text_of(m.unsigned_of(4))); }},   // BINUNICODE
    {0x8d, [](Machine& m) { m.push(m.text_of(m.unsigned_of(8))); }},  // BINUNICODE8
    {'C', [](Machine& m) { m.skip(m.unsigned_of(1)); }},              // SHORT_BINBYTES
    {'B', [](Machine& m) { m.skip(m.unsigned_of(4)); }},              // BINBYTES
    {0x8e, [](Machine& m) { m.skip(m.unsigned_of(8)); }},             // BINBYTES8
    {0x96, [](Machine& m) { m.skip(m.unsigned_of(8)); }},             // BYTEARRAY8
    // Containers. The content of sets is dropped, as no tensor is in one.
    {'(', [](Machine& m) { m.marks_.push_back(m.stack_.size()); }},  // MARK
    {')', [](Machine& m) { m.push(Tuple{}); }},                      // EMPTY_TUPLE
    {0x85, [](Machine& m) { m.push(Tuple{m.pop_last(1)}); }},        // TUPLE1
    {0x86, [](Machine& m) { m.push(Tuple{m.pop_last(2)}); }},        // TUPLE2
    {0x87, [](Machine& m) { m.push(Tuple{m.pop_last(3)}); }},        // TUPLE3
    {'t', [](Machine& m) { m.push(Tuple{m.pop_to_mark()}); }},       // TUPLE
    {']', [](Machine& m) { m.push(List{}); }},                       // EMPTY_LIST
    {'l', [](Machine& m) { m.push(List{m.pop_to_mark()}); }},        // LIST
    {'a', [](Machine& m) { m.append(m.pop_last(1)); }},              // APPEND
    {'e', [](Machine& m) { m.append(m.pop_to_mark()); }},            // APPENDS
    {'}', [](Machine& m) { m.push(Dictionary{}); }},                 // EMPTY_DICT
    {'d', [](Machine& m) { m.push_dictionary(m.pop_to_mark()); }},   // DICT
    {'s', [](Machine& m) { m.set_items(m.pop_last(2)); }},           // SETITEM
    {'u', [](Machine& m) { m.set_items(m.pop_to_mark()); }},         // SETITEMS
    {0x8f, [](Machine& m) { m.push(Other{}); }},                     // EMPTY_SET
    {0x90, [](Machine& m) { m.pop_to_mark(); }},                     // ADDITEMS
    {0x91, [](Machine& m) { m.pop_to_mark(), m.push(Other{}); }},    // FROZENSET
    // Stack and memo. A frame's length only tells how much to read at once, so it is skipped.
    {0x80, [](Machine& m) { m.check_protocol(m.unsigned_of(1)); }},  // PROTO
    {0x95, [](Machine& m) { m.take(8); }},                           // FRAME
    {'0', [](Machine& m) { m.pop(); }},                              // POP
    {'1', [](Machine& m) { m.pop_to_mark(); }},                      // POP_MARK
    {'2', [](Machine& m) { m.stack_.push_back(m.top()); }},          // DUP
    {'q', [](Machine& m) { m.put(1); }},                             // BINPUT
    {'r', [](Machine& m) { m.put(4); }},                             // LONG_BINPUT
    {0x94, [](Machine& m) { m.memo_[m.memo_.size()] = m.top(); }},   // MEMOIZE
    {'h', [](Machine& m) { m.get(1); }},                             // BINGET
    {'j', [](Machine& m) { m.get(4); }},                             // LONG_BINGET
    // Objects.
    {'c', [](Machine& m) { m.push_global(); }},         // GLOBAL
    {0x93, [](Machine& m) { m.push_stack_global(); }},  // STACK_GLOBAL
    {'R', [](Machine& m) { m.call_function(); }},       // REDUCE
    {0x81, [](Machine& m) { m.call_function(); }},      // NEWOBJ
    {0x92, [](Machine& m) { m.call_with_names(); }},    // NEWOBJ_EX
    {'b', [](Machine& m) { m.build(); }},               // BUILD
    {'Q', [](Machine& m) { m.push_storage(); }},        // BINPERSID
};

void Machine::run() {
  constexpr std::uint8_t kStop = '.';
  while (true) {
    opcode_at_ = at_;
    const auto code = std::to_integer<std::uint8_t>(take(1)[0]);
    if (code == kStop) break;
    const auto opcode = std::ranges::find(kOpcodes, code, &Opcode::code);
    if (opcode == std::end(kOpcodes)) {
      fail_bad(fmt::format("opcode {:#04x}, which torch.save() does not write", code));
    }
    opcode->run(*this);
  }
  into_.root = pop();
  into_.bytes = at_;
}

}  // namespace

Pickle read_pickle(std::span<const std::byte> bytes, const std::string& name, std::size_t offset) {
  Pickle pickle;
  Machine(bytes, name, offset, pickle).run();
  return pickle;
}

}  // namespace enfilade::features::formats
