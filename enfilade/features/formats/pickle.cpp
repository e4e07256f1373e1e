#include "enfilade/features/formats/pickle.h"

#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <set>
#include <string_view>
#include <unordered_map>

#include "enfilade/core/errors.h"
#include "enfilade/features/formats/pickle_names.h"
#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features::formats {
namespace {

// Of 50,000 tensors, a pickle has about 5 MB; values take a hundred times an opcode's room.
constexpr std::size_t kLongestPickle = std::size_t{64} << 20;
constexpr std::size_t kMostSides = 64;  // of a tensor, as in PyTorch
constexpr int kLatestProtocol = 5;

/// Pickle's stack machine. It builds values and calls nothing.
class Machine {
 public:
  Machine(std::span<const std::byte> bytes, const std::string& name, std::size_t offset,
          Pickle& into)
      : bytes_(bytes.first(std::min(bytes.size(), kLongestPickle))),
        name_(name),
        offset_(offset),
        into_(into) {}

  void run() {
    while (true) {
      opcode_at_ = at_;
      const auto opcode = static_cast<Opcode>(take(1)[0]);
      if (opcode == kStop) break;
      if (!scalar(opcode) && !text(opcode) && !container(opcode) && !filling(opcode) &&
          !memory(opcode) && !object(opcode)) {
        fail("bad-pickle", fmt::format("opcode {:#04x}, which torch.save() does not write",
                                       static_cast<unsigned>(opcode)));
      }
    }
    into_.root = pop();
    into_.bytes = at_;
  }

 private:
  [[noreturn]] void fail(const char* code, std::string message) const {
    refuse(name_, fmt::format("byte {}", offset_ + opcode_at_), code, std::move(message));
  }

  // --- bytes ---

  std::span<const std::byte> take(std::uint64_t count) {
    if (count > bytes_.size() - at_) {
      fail("truncated",
           fmt::format(
               "a pickle that goes on behind byte {}, where {}", offset_ + bytes_.size(),
               bytes_.size() == kLongestPickle ? "reading stops (64 MiB)" : "the file ends"));
    }
    const auto taken = bytes_.subspan(at_, static_cast<std::size_t>(count));
    at_ += taken.size();
    return taken;
  }

  std::uint64_t unsigned_of(std::size_t size) {
    std::uint64_t value = 0;
    const auto bytes = take(size);
    for (std::size_t i = 0; i < size; ++i) {
      value |= std::to_integer<std::uint64_t>(bytes[i]) << 8 * i;
    }
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
    if (stack_.size() <= bottom()) fail("bad-pickle", "takes a value from an empty stack");
    return stack_.back();
  }

  std::vector<Value*> pop_last(std::size_t count) {
    if (stack_.size() - bottom() < count) fail("bad-pickle", "takes a value from an empty stack");
    const auto first = stack_.end() - static_cast<std::ptrdiff_t>(count);
    std::vector<Value*> values(first, stack_.end());
    stack_.erase(first, stack_.end());
    return values;
  }

  std::vector<Value*> pop_to_mark() {
    if (marks_.empty()) fail("bad-pickle", "goes back to a mark that is not there");
    auto values = pop_last(stack_.size() - marks_.back());
    marks_.pop_back();
    return values;
  }

  template <class T>
  T& as(Value* value, const char* what) const {
    T* const is = std::get_if<T>(&value->is);
    if (is == nullptr) fail("bad-pickle", fmt::format("another value where {} has to be", what));
    return *is;
  }

  // --- opcodes, by kind; each function says whether it was one of its kind ---

  bool scalar(Opcode opcode) {
    switch (opcode) {
      case kNone:
        push(Other{});
        return true;
      case kNewTrue:
        push(true);
        return true;
      case kNewFalse:
        push(false);
        return true;
      case kBinInt1:
        push(static_cast<std::int64_t>(unsigned_of(1)));
        return true;
      case kBinInt2:
        push(static_cast<std::int64_t>(unsigned_of(2)));
        return true;
      case kBinInt:
        push(std::int64_t{static_cast<std::int32_t>(static_cast<std::uint32_t>(unsigned_of(4)))});
        return true;
      case kLong1:
        push_long(unsigned_of(1));
        return true;
      case kLong4:
        push_long(unsigned_of(4));
        return true;
      case kBinFloat:
        take(sizeof(double));
        push(Other{});
        return true;
      default:
        return false;
    }
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

  bool text(Opcode opcode) {
    switch (opcode) {
      case kShortBinString:
      case kShortBinUnicode:
        push(text_of(unsigned_of(1)));
        return true;
      case kBinString:
      case kBinUnicode:
        push(text_of(unsigned_of(4)));
        return true;
      case kBinUnicode8:
        push(text_of(unsigned_of(8)));
        return true;
      case kShortBinBytes:
        return skip(unsigned_of(1));
      case kBinBytes:
        return skip(unsigned_of(4));
      case kBinBytes8:
        return skip(unsigned_of(8));
      default:
        return false;
    }
  }

  bool skip(std::uint64_t size) {
    take(size);
    push(Other{});
    return true;
  }

  bool container(Opcode opcode) {
    switch (opcode) {
      case kMark:
        marks_.push_back(stack_.size());
        return true;
      case kEmptyTuple:
        push(Tuple{});
        return true;
      case kTuple1:
        push(Tuple{pop_last(1)});
        return true;
      case kTuple2:
        push(Tuple{pop_last(2)});
        return true;
      case kTuple3:
        push(Tuple{pop_last(3)});
        return true;
      case kTuple:
        push(Tuple{pop_to_mark()});
        return true;
      case kEmptyList:
        push(List{});
        return true;
      case kList:
        push(List{pop_to_mark()});
        return true;
      case kEmptyDict:
        push(Dictionary{});
        return true;
      case kDict: {
        Dictionary dictionary;
        add_pairs(pop_to_mark(), dictionary);
        push(std::move(dictionary));
        return true;
      }
      case kEmptySet:
        push(Other{});
        return true;
      case kFrozenSet:
        pop_to_mark();
        push(Other{});
        return true;
      default:
        return false;
    }
  }

  bool filling(Opcode opcode) {
    switch (opcode) {
      case kAppend: {
        Value* const item = pop();
        as<List>(top(), "a list").items.push_back(item);
        return true;
      }
      case kAppends: {
        const auto items = pop_to_mark();
        auto& to = as<List>(top(), "a list").items;
        to.insert(to.end(), items.begin(), items.end());
        return true;
      }
      case kSetItem: {
        const auto pair = pop_last(2);
        add_pairs(pair, as<Dictionary>(top(), "a dictionary"));
        return true;
      }
      case kSetItems: {
        const auto pairs = pop_to_mark();
        add_pairs(pairs, as<Dictionary>(top(), "a dictionary"));
        return true;
      }
      case kAddItems:
        pop_to_mark();
        return true;  // to a set, which nobody looks into
      default:
        return false;
    }
  }

  void add_pairs(std::span<Value* const> values, Dictionary& to) const {
    if (values.size() % 2 != 0) fail("bad-pickle", "a key without a value");
    for (std::size_t i = 0; i < values.size(); i += 2) {
      to.items.emplace_back(values[i], values[i + 1]);
    }
  }

  bool memory(Opcode opcode) {
    switch (opcode) {
      case kProto:
        check_protocol(unsigned_of(1));
        return true;
      case kFrame:
        unsigned_of(8);
        return true;  // only says how much to read at once
      case kPop:
        pop();
        return true;
      case kPopMark:
        pop_to_mark();
        return true;
      case kDup:
        stack_.push_back(top());
        return true;
      case kBinPut:
        memo_[unsigned_of(1)] = top();
        return true;
      case kLongBinPut:
        memo_[unsigned_of(4)] = top();
        return true;
      case kMemoize:
        memo_[memo_.size()] = top();
        return true;
      case kBinGet:
        push_remembered(unsigned_of(1));
        return true;
      case kLongBinGet:
        push_remembered(unsigned_of(4));
        return true;
      default:
        return false;
    }
  }

  void check_protocol(std::uint64_t protocol) const {
    if (protocol > kLatestProtocol) {
      fail("bad-pickle", fmt::format("protocol {}, at most {} is read", protocol, kLatestProtocol));
    }
  }

  void push_remembered(std::uint64_t key) {
    const auto found = memo_.find(key);
    if (found == memo_.end()) fail("bad-pickle", fmt::format("recalls value {}, not put", key));
    stack_.push_back(found->second);
  }

  bool object(Opcode opcode) {
    switch (opcode) {
      case kGlobal: {
        const std::string module = line();
        push(global(module, line()));
        return true;
      }
      case kStackGlobal: {
        const auto names = pop_last(2);
        push(global(as<std::string>(names[0], "a name"), as<std::string>(names[1], "a name")));
        return true;
      }
      case kReduce:
      case kNewObj: {
        const auto called = pop_last(2);
        call(as<Global>(called[0], "a function"), as<Tuple>(called[1], "arguments"));
        return true;
      }
      case kBuild:
        build();
        return true;
      case kBinPersId:
        push(storage(as<Tuple>(pop(), "a storage's place")));
        return true;
      default:
        return false;
    }
  }

  Global global(const std::string& module, const std::string& name) const {
    const std::string full = module + "." + name;
    const auto found = std::ranges::find(kGlobals, full, &NamedGlobal::name);
    if (found != std::end(kGlobals)) return found->global;
    const bool is_storage =
        (module == "torch" || module == "torch.cuda") && name.ends_with("Storage");
    const auto type = std::ranges::find(kStorageTypes, name, &NamedGlobal::name);
    if (is_storage && type != std::end(kStorageTypes)) return type->global;
    const std::string shown = fmt::format("{:?}", full.substr(0, 100));
    if (is_storage) {
      fail("unsupported-type",
           fmt::format("tensors of {}, not of 16, 32 or 64 bit floats, 32 or 64 bit integers, "
                       "bytes or truth values",
                       shown));
    }
    fail("foreign-code",
         fmt::format("holds {}; only tensors, in dictionaries, are read. In Python: "
                     "torch.save(model.state_dict(), file)",
                     shown));
  }

  void call(const Global& function, const Tuple& arguments) {
    switch (function.callable) {
      case Callable::kOrderedDict:
        push(ordered_dictionary(arguments));
        return;
      case Callable::kSize:
        if (arguments.items.size() != 1) fail("bad-pickle", "torch.Size of other than 1 argument");
        if (std::holds_alternative<Tuple>(arguments.items[0]->is)) {
          stack_.push_back(arguments.items[0]);
        } else {
          push(Tuple{as<List>(arguments.items[0], "a size").items});
        }
        return;
      case Callable::kRebuildTensor:
        push(tensor(arguments));
        return;
      case Callable::kRebuildParameter:
      case Callable::kParameter:
        // Very old files give a parameter its tensor only when they set its state.
        push(arguments.items.empty() ? PickledTensor{}
                                     : as<PickledTensor>(arguments.items[0], "a tensor"));
        return;
      case Callable::kStorageType:
        fail("bad-pickle", "calls a storage's type");
    }
  }

  // Of nothing, or, as Python 2 wrote it, of a list of pairs.
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
    auto* const built = std::get_if<PickledTensor>(&top()->is);
    // What is set of a dictionary is its _metadata, of a tensor whether it is trained.
    if (built == nullptr || built->storage != nullptr) return;
    const auto* parts = std::get_if<Tuple>(&state->is);
    if (parts != nullptr && !parts->items.empty()) {
      *built = as<PickledTensor>(parts->items[0], "a tensor");
    }
  }

  std::int64_t count(Value* value, const char* what) const {
    const std::int64_t number = as<std::int64_t>(value, what);
    if (number < 0) fail("bad-pickle", fmt::format("{}: {}, not 0 or more", what, number));
    return number;
  }

  std::vector<std::int64_t> counts(Value* value, const char* what) const {
    std::vector<std::int64_t> numbers;
    for (Value* const item : as<Tuple>(value, what).items) numbers.push_back(count(item, what));
    return numbers;
  }

  PickledTensor tensor(const Tuple& arguments) const {
    const auto& items = arguments.items;
    if (items.size() < 4) fail("bad-pickle", "a tensor of fewer than 4 arguments");
    as<PickledStorage>(items[0], "a storage");
    PickledTensor tensor{items[0], count(items[1], "a tensor's offset"),
                         counts(items[2], "a tensor's shape"),
                         counts(items[3], "a tensor's strides")};
    if (tensor.shape.size() != tensor.strides.size() || tensor.shape.size() > kMostSides) {
      fail("bad-pickle", fmt::format("a tensor of {} sides and {} strides, not as many, at most {}",
                                     tensor.shape.size(), tensor.strides.size(), kMostSides));
    }
    constexpr std::size_t kFlags = 6;  // conjugated, negated: to be done when it is read
    if (items.size() > kFlags) {
      const auto* flags = std::get_if<Dictionary>(&items[kFlags]->is);
      if (flags != nullptr && !flags->items.empty()) {
        fail("unsupported-type", "a tensor that is conjugated or negated when it is read");
      }
    }
    return tensor;
  }

  // ("storage", type, key, where it was, elements[, None or (key, offset, elements)])
  PickledStorage storage(const Tuple& place) const {
    const auto& items = place.items;
    if (items.size() < 5 || as<std::string>(items[0], "\"storage\"") != "storage") {
      fail("bad-pickle", "a persistent id that is no storage's");
    }
    const Global& type = as<Global>(items[1], "a storage's type");
    if (type.callable != Callable::kStorageType) fail("bad-pickle", "a storage of no type");
    PickledStorage storage{as<std::string>(items[2], "a storage's key"), type.type,
                           count(items[4], "a storage's size"), std::nullopt};
    if (items.size() > 5 && std::holds_alternative<Tuple>(items[5]->is)) {
      const auto& view = std::get<Tuple>(items[5]->is).items;
      if (view.size() != 3) fail("bad-pickle", "a view of a storage without 3 parts");
      storage.view = {as<std::string>(view[0], "a view's key"), count(view[1], "a view's offset"),
                      count(view[2], "a view's size")};
    }
    return storage;
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

}  // namespace

Pickle read_pickle(std::span<const std::byte> bytes, const std::string& name, std::size_t offset) {
  Pickle pickle;
  Machine(bytes, name, offset, pickle).run();
  return pickle;
}

std::vector<const PickledStorage*> storages_of(const Pickle& pickle) {
  std::vector<const PickledStorage*> storages;
  for (const Value& value : pickle.values) {
    const auto* storage = std::get_if<PickledStorage>(&value.is);
    if (storage != nullptr) storages.push_back(storage);
  }
  return storages;
}

}  // namespace enfilade::features::formats
