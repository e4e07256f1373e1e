#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/features/formats/pickle.h"
#include "enfilade/features/formats/stored_arrays.h"
#include "enfilade/scan/file_tree.h"

namespace enfilade::features::formats {
namespace {

constexpr std::size_t kShownName = 100;  // in messages, bytes

using Bytes = std::span<const std::byte>;
/// Gives the bytes of a whole storage. \throws InvalidInput
using FindStorage = std::function<Bytes(const PickledStorage&)>;

// --- which tensors ---

const Value* find(const Dictionary& dictionary, std::string_view key) {
  const Value* found = nullptr;
  for (const auto& [name, value] : dictionary.items) {
    const auto* text = std::get_if<std::string>(&name->is);
    if (text != nullptr && *text == key) found = value;
  }
  return found;
}

/// PickledTensor, or Opaque that holds numbers.
using Tensors = std::map<std::string, const Value*>;

bool is_tensor(const Value& value) {
  if (std::holds_alternative<PickledTensor>(value.is)) return true;
  const auto* opaque = std::get_if<Opaque>(&value.is);
  return opaque != nullptr && opaque->holds_numbers;
}

Tensors tensors_in(const Dictionary& dictionary) {
  Tensors tensors;
  for (const auto& [name, value] : dictionary.items) {
    const auto* text = std::get_if<std::string>(&name->is);
    if (text != nullptr && is_tensor(*value)) tensors.insert_or_assign(*text, value);
  }
  return tensors;
}

// The tensors of a TorchScript module and of the modules in it, by the names that its state_dict()
// has. Each module is looked at once: a file may make them refer to each other.
void add_tensors(const Module& module, const std::string& prefix, std::set<const Module*>& seen,
                 Tensors& tensors) {
  constexpr std::size_t kLongest = 4096;  // of names: a small file can nest them without end
  if (prefix.size() > kLongest || !seen.insert(&module).second) return;
  for (const auto& [name, tensor] : tensors_in(module.attributes)) {
    tensors.insert_or_assign(prefix + name, tensor);
  }
  for (const auto& [name, value] : module.attributes.items) {
    const auto* text = std::get_if<std::string>(&name->is);
    const auto* inner = std::get_if<Module>(&value->is);
    if (text == nullptr || inner == nullptr) continue;
    add_tensors(*inner, prefix + *text + ".", seen, tensors);
  }
}

constexpr std::array<std::string_view, 4> kInner{"state_dict", "model_state_dict", "model",
                                                 "module"};

// Training programs put the dictionary of tensors into another one, beside the epoch, the optimiser
// and so on; some of these are tensors too.
Tensors find_tensors_below(const Value* root, int depth = 0) {
  constexpr int kDeepest = 4;
  if (root == nullptr || depth == kDeepest) return {};
  if (const auto* module = std::get_if<Module>(&root->is)) {
    std::set<const Module*> seen;
    Tensors tensors;
    add_tensors(*module, "", seen, tensors);
    return tensors;
  }
  const auto* dictionary = std::get_if<Dictionary>(&root->is);
  if (dictionary == nullptr) return {};
  for (const std::string_view key : kInner) {
    Tensors tensors = find_tensors_below(find(*dictionary, key), depth + 1);
    if (!tensors.empty()) return tensors;
  }
  return tensors_in(*dictionary);
}

// Agents of several networks save a dictionary of them, each with a "state_dict" of its own. Names
// become "<network>.<name>", once.
Tensors find_parts(const Value* root) {
  Tensors all;
  const auto* dictionary = root == nullptr ? nullptr : std::get_if<Dictionary>(&root->is);
  if (dictionary == nullptr) return all;
  for (const auto& [key, value] : dictionary->items) {
    const auto* part = std::get_if<std::string>(&key->is);
    const auto* inner = std::get_if<Dictionary>(&value->is);
    if (part == nullptr || inner == nullptr || find(*inner, "state_dict") == nullptr) continue;
    const std::string prefix = *part + ".";
    for (const auto& [name, tensor] : find_tensors_below(find(*inner, "state_dict"))) {
      const std::string bare = bare_name(name);
      all.insert_or_assign(bare.starts_with(prefix) ? bare : prefix + bare, tensor);
    }
  }
  return all;
}

// What stands beside the tensors: whole numbers as digits, all else empty.
void add_beside(const Dictionary& dictionary, std::string_view tensors, const std::string& prefix,
                std::map<std::string, std::string>& into) {
  for (const auto& [key, value] : dictionary.items) {
    const auto* name = std::get_if<std::string>(&key->is);
    if (name == nullptr || *name == tensors) continue;
    const auto* number = std::get_if<std::int64_t>(&value->is);
    into[prefix + *name] = number == nullptr ? "" : std::to_string(*number);
  }
}

std::map<std::string, std::string> beside_tensors(const Value* root) {
  std::map<std::string, std::string> found;
  const auto* dictionary = root == nullptr ? nullptr : std::get_if<Dictionary>(&root->is);
  if (dictionary == nullptr) return found;
  const auto tensors = std::ranges::find_if(kInner, [&](std::string_view key) {
    return !find_tensors_below(find(*dictionary, key)).empty();
  });
  if (tensors != kInner.end()) {
    add_beside(*dictionary, *tensors, "", found);
    return found;
  }
  for (const auto& [key, value] : dictionary->items) {
    const auto* part = std::get_if<std::string>(&key->is);
    const auto* inner = std::get_if<Dictionary>(&value->is);
    if (part == nullptr || inner == nullptr || find(*inner, "state_dict") == nullptr) continue;
    add_beside(*inner, "state_dict", *part + ".", found);
  }
  return found;
}

// The first classes and functions that are not known, for a message.
std::string unknown_names(const Pickle& pickle) {
  constexpr std::size_t kNamed = 3;
  std::vector<std::string> names;
  for (const Value& value : pickle.values) {
    const auto* global = std::get_if<Global>(&value.is);
    if (global == nullptr || global->callable != Callable::kUnknown) continue;
    std::string name = quote(global->name, kShownName);
    if (names.size() < kNamed && std::ranges::find(names, name) == names.end()) {
      names.push_back(std::move(name));
    }
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

Tensors find_tensors(const Pickle& pickle, const std::string& name) {
  const Value* const root = pickle.root;
  // Several networks first: beside them a lone tensor, such as the best accuracy, is none of them.
  const auto* dictionary = root == nullptr ? nullptr : std::get_if<Dictionary>(&root->is);
  const bool inner = dictionary != nullptr && std::ranges::any_of(kInner, [&](auto key) {
                       return !find_tensors_below(find(*dictionary, key)).empty();
                     });
  Tensors tensors = inner ? Tensors{} : find_parts(root);
  if (tensors.empty()) tensors = find_tensors_below(root);
  if (!tensors.empty()) return tensors;
  const std::string unknown = unknown_names(pickle);
  if (!unknown.empty()) {
    refuse(name, "", "foreign-code",
           fmt::format("holds no dictionary of tensors, but objects of code that is not run: {}. "
                       "Where that code is installed, in Python: torch.save(model.state_dict(), "
                       "file)",
                       unknown));
  }
  refuse(name, "", "no-tensors",
         "holds no dictionary of tensors, neither as the outermost value nor below \"state_dict\", "
         "\"model_state_dict\", \"model\" or \"module\", nor several networks that each have a "
         "\"state_dict\"; nor a TorchScript module with tensors");
}

// --- from storages to arrays ---

[[noreturn]] void refuse_tensor(const std::string& file, const std::string& tensor,
                                std::string code, std::string message) {
  refuse(file, quote(tensor, kShownName), std::move(code), std::move(message));
}

// Number of elements from a tensor's first to its last in its storage; none if it overflows.
std::optional<std::uint64_t> extent(const PickledTensor& tensor) {
  std::uint64_t last = 0;
  for (std::size_t i = 0; i < tensor.shape.size(); ++i) {
    if (tensor.shape[i] == 0) return 0;
    const auto steps = static_cast<std::uint64_t>(tensor.shape[i] - 1);
    std::uint64_t reach = 0;
    if (__builtin_mul_overflow(steps, static_cast<std::uint64_t>(tensor.strides[i]), &reach) ||
        __builtin_add_overflow(last, reach, &last)) {
      return std::nullopt;
    }
  }
  return last + 1;
}

bool is_contiguous(const PickledTensor& tensor) {
  std::int64_t stride = 1;
  for (std::size_t i = tensor.shape.size(); i-- > 0;) {
    if (tensor.shape[i] != 1 && tensor.strides[i] != stride) return false;
    stride *= tensor.shape[i];
  }
  return true;
}

// Row by row, whatever the order of the elements in `from`, which begins with the first.
void gather(const PickledTensor& tensor, Bytes from, std::size_t size, std::span<std::byte> to) {
  std::vector<std::int64_t> index(tensor.shape.size());
  std::size_t at = 0;
  for (std::size_t filled = 0; filled < to.size(); filled += size) {
    std::memcpy(to.data() + filled, from.data() + at * size, size);
    for (std::size_t i = index.size(); i-- > 0;) {
      const auto stride = static_cast<std::size_t>(tensor.strides[i]);
      at += stride;
      if (++index[i] < tensor.shape[i]) break;
      at -= stride * static_cast<std::size_t>(tensor.shape[i]);
      index[i] = 0;
    }
  }
}

// The bytes of a tensor's storage, or of the part of it that is its view. \throws InvalidInput
Bytes viewed_bytes(const std::string& file, const std::string& name, const PickledStorage& storage,
                   Bytes all) {
  const std::size_t size = size_of(storage.type);
  const auto elements = static_cast<std::uint64_t>(storage.elements);
  if (all.size() % size != 0 || all.size() / size != elements) {
    refuse_tensor(file, name, "bad-size",
                  fmt::format("a storage of {} bytes, not of {} elements of {} bytes", all.size(),
                              elements, size));
  }
  if (!storage.view) return all;
  const auto offset = static_cast<std::uint64_t>(storage.view->offset);
  const auto viewed = static_cast<std::uint64_t>(storage.view->elements);
  if (offset > elements || viewed > elements - offset) {
    refuse_tensor(file, name, "bad-size",
                  fmt::format("a view of {} elements from element {} of a storage of {}", viewed,
                              offset, elements));
  }
  return all.subspan(offset * size, viewed * size);
}

void build_array(const std::string& file, const std::string& name, const PickledTensor& tensor,
                 const FindStorage& find_storage, StoredArrays& into) {
  if (tensor.storage == nullptr) {
    refuse_tensor(file, name, "bad-pickle", "a parameter to which the file gives no tensor");
  }
  const auto& storage = std::get<PickledStorage>(tensor.storage->is);
  const std::size_t size = size_of(storage.type);
  const auto bytes = bytes_of_shape(tensor.shape, storage.type);
  const auto reach = extent(tensor);
  const Bytes all = viewed_bytes(file, name, storage, find_storage(storage));
  const std::uint64_t elements = all.size() / size;
  const auto offset = static_cast<std::uint64_t>(tensor.offset);
  if (!bytes || !reach || offset > elements || *reach > elements - offset) {
    refuse_tensor(file, name, "bad-size",
                  fmt::format("reaches beyond the {} elements of its storage", elements));
  }
  NamedArray& array = into.arrays.emplace_back(NamedArray{name, storage.type, tensor.shape, {}});
  const Bytes from = all.subspan(offset * size);
  if (*bytes == 0 || is_contiguous(tensor)) {
    array.bytes = into.aligned(from.first(*bytes), storage.type);
    return;
  }
  // Strides of 0 make an array of any size from one number. No trained tensor looks like that, and
  // a small file could fill the memory.
  if (*bytes > from.size()) {
    refuse_tensor(
        file, name, "expanded",
        fmt::format("{} bytes from {} bytes of storage: an expanded tensor, which repeats its "
                    "numbers; save tensor.contiguous() instead",
                    *bytes, from.size()));
  }
  const auto to = into.allocate(*bytes);
  gather(tensor, from, size, to);
  array.bytes = to;
}

// Why a tensor cannot be read: the code of an error, and its message. No value if it can.
std::optional<std::pair<const char*, std::string>> unreadable(const Value& tensor) {
  if (const auto* opaque = std::get_if<Opaque>(&tensor.is)) {
    return std::pair("foreign-code", fmt::format("made by {}, which is not called",
                                                 quote(opaque->maker, kShownName)));
  }
  const Value* const storage = std::get<PickledTensor>(tensor.is).storage;
  const std::string_view other =
      storage == nullptr ? "" : std::get<PickledStorage>(storage->is).other_type;
  if (other.empty()) return std::nullopt;
  return std::pair("unsupported-type",
                   fmt::format("numbers of \"torch.{}\"; floats of 16, 32 or 64 bits, integers of "
                               "32 or 64 bits, bytes and booleans are read",
                               other));
}

// Tensors that cannot be read are left out, if there are others: perhaps no network needs them.
void build_arrays(const Pickle& pickle, const std::string& file, const FindStorage& find_storage,
                  StoredArrays& into) {
  const Tensors tensors = find_tensors(pickle, file);
  for (const auto& [name, tensor] : tensors) {
    if (const auto why = unreadable(*tensor)) {
      into.left_out[name] = why->second;
    } else {
      build_array(file, name, std::get<PickledTensor>(tensor->is), find_storage, into);
    }
  }
  if (into.arrays.empty() && !tensors.empty()) {
    const auto& [name, tensor] = *tensors.begin();
    const auto why = unreadable(*tensor);
    refuse_tensor(file, name, why->first, why->second);
  }
  into.metadata = beside_tensors(pickle.root);
}

Bytes bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

// --- pickles followed by storages ---

constexpr std::array<std::uint8_t, 12> kMagic{0x8a, 0x0a, 0x6c, 0xfc, 0x9c, 0x46,
                                              0xf9, 0x20, 0x6a, 0xa8, 0x50, 0x19};

bool has_magic(Bytes file) {
  const auto start = file.first(std::min<std::size_t>(file.size(), 32));
  return !std::ranges::search(start, std::as_bytes(std::span(kMagic))).empty();
}

/// The parts of such a file, one after the other.
class PickleSequence {
 public:
  PickleSequence(Bytes file, const std::string& name) : file_(file), name_(name) {}

  Pickle next() {
    Pickle pickle = read_pickle(file_.subspan(at_), name_, at_);
    at_ += pickle.bytes;
    return pickle;
  }

  // The number of elements, then the elements.
  Bytes next_storage(const std::string& key, const PickledStorage& storage) {
    std::uint64_t elements = 0;
    if (file_.size() - at_ < sizeof(elements)) truncated(key);
    std::memcpy(&elements, file_.data() + at_, sizeof(elements));
    at_ += sizeof(elements);
    if (elements != static_cast<std::uint64_t>(storage.elements)) {
      refuse(name_, fmt::format("byte {}", at_ - sizeof(elements)), "bad-size",
             fmt::format("storage {} has {} elements, not the {} that its tensors name", quote(key),
                         elements, storage.elements));
    }
    if (elements > (file_.size() - at_) / storage.element_bytes()) truncated(key);
    const Bytes bytes = file_.subspan(at_, elements * storage.element_bytes());
    at_ += bytes.size();
    return bytes;
  }

 private:
  [[noreturn]] void truncated(const std::string& key) const {
    refuse(name_, fmt::format("byte {}", at_), "truncated",
           fmt::format("the file ends within storage {}", quote(key)));
  }

  Bytes file_;
  const std::string& name_;
  std::size_t at_ = 0;
};

std::vector<std::string> strings_of(const Pickle& pickle, const std::string& name) {
  std::vector<std::string> strings;
  const auto* list = std::get_if<List>(&pickle.root->is);
  if (list == nullptr) {
    refuse(name, "", "bad-pickle", "no list of the storages' keys follows the tensors");
  }
  for (const Value* const item : list->items) {
    const auto* text = std::get_if<std::string>(&item->is);
    if (text == nullptr) {
      refuse(name, "", "bad-pickle", "a key in the list of the storages' keys is not a string");
    }
    strings.push_back(*text);
  }
  return strings;
}

void check_version(const Pickle& pickle, const std::string& name) {
  constexpr std::int64_t kVersion = 1001;
  const auto* version = std::get_if<std::int64_t>(&pickle.root->is);
  if (version == nullptr || *version != kVersion) {
    refuse(name, "", "bad-pickle",
           fmt::format("the version of the format is {}, not {}",
                       version == nullptr ? "not an integer" : std::to_string(*version), kVersion));
  }
}

void check_byte_order(const Pickle& pickle, const std::string& name) {
  const auto* dictionary = std::get_if<Dictionary>(&pickle.root->is);
  const Value* const little = dictionary == nullptr ? nullptr : find(*dictionary, "little_endian");
  const bool* const is_little = little == nullptr ? nullptr : std::get_if<bool>(&little->is);
  if (is_little == nullptr || !*is_little) {
    refuse(name, "", "big-endian", "not marked as little-endian, the only byte order that is read");
  }
}

// The folder of data.pkl, which every other part lies in or below: "archive/".
std::string archive_folder(const scan::FileTree& zip, const std::string& name) {
  constexpr std::string_view kPickle = "data.pkl";
  std::vector<std::string> found;
  for (std::string& path : zip.names()) {
    if (!path.ends_with(kPickle)) continue;
    path.resize(path.size() - kPickle.size());
    if (path.empty() || path.ends_with('/')) found.push_back(std::move(path));
  }
  if (found.empty()) {
    refuse(name, "", "no-tensors", "a zip archive without data.pkl: not written by torch.save()");
  }
  if (found.size() > 1) {
    refuse(name, "data.pkl", "repeated-name",
           fmt::format("lies in two folders of the zip, {} and {}", quote(found[0], kShownName),
                       quote(found[1], kShownName)));
  }
  return found[0];
}

}  // namespace

bool looks_like_zip(Bytes file) noexcept {
  constexpr std::string_view kSignature("PK\x03\x04", 4);
  return file.size() >= kSignature.size() &&
         std::ranges::equal(file.first(kSignature.size()), bytes_of(kSignature));
}

bool looks_like_pickle(Bytes file) noexcept {
  // The length at the start of a safetensors file can have these two bytes, but then the ninth byte
  // of the file is a "{".
  return file.size() >= 2 && file[0] == std::byte{0x80} && file[1] >= std::byte{2} &&
         file[1] <= std::byte{5} && (file.size() < 9 || file[8] != std::byte{'{'});
}

// POSIX's header of a file: its name, and the magic word at byte 257.
bool looks_like_tar(Bytes file) noexcept {
  constexpr std::string_view kUstar = "ustar";
  constexpr std::size_t kAt = 257;
  return file.size() >= kAt + kUstar.size() &&
         std::ranges::equal(file.subspan(kAt, kUstar.size()), bytes_of(kUstar));
}

void refuse_tar(Bytes file, const std::string& name) {
  constexpr std::size_t kNameBytes = 100;
  std::string first(reinterpret_cast<const char*>(file.data()), kNameBytes);
  first.resize(std::min(first.find('\0'), first.size()));
  for (const std::string_view part : {"sys_info", "pickle", "storages", "tensors"}) {
    if (first != part) continue;
    refuse(name, "", "old-torch",
           "torch.save()'s tar form of 2016 and 2017, which is not read. To convert it, in Python: "
           "torch.save(torch.load(file, weights_only=False), new_file)");
  }
  refuse(name, "", "no-tensors",
         fmt::format("a tar archive, which begins with {}; unpack it, and name the file of "
                     "weights in it",
                     quote(first)));
}

StoredArrays read_torch_zip(const std::filesystem::path& file) {
  const std::string name = file.string();
  // By their paths: TorchScript's constants have the names of tensors, in another folder.
  const auto zip = scan::FileTree::zip(file, scan::ZipNames::kPaths);
  const std::string folder = archive_folder(*zip, name);
  const auto text = zip->read(folder + "data.pkl");
  if (zip->read(folder + "byteorder").value_or("little") != "little") {
    refuse(name, "byteorder", "big-endian", "not \"little\", the only byte order that is read");
  }
  const Pickle pickle = read_pickle(bytes_of(text.value()), name + ":data.pkl");
  StoredArrays read;
  std::unordered_map<std::string, Bytes> storages;
  build_arrays(
      pickle, name,
      [&](const PickledStorage& storage) {
        const auto known = storages.find(storage.key);
        if (known != storages.end()) return known->second;
        auto content = zip->read(folder + "data/" + storage.key);
        if (!content) refuse(name, "data/" + storage.key, "truncated", "missing from the archive");
        const auto kept = std::make_shared<const std::string>(*std::move(content));
        read.memory.push_back(kept);
        return storages[storage.key] = bytes_of(*kept);
      },
      read);
  return read;
}

StoredArrays read_torch_pickle(Bytes file, const std::string& name) {
  if (!has_magic(file)) {
    refuse(name, "byte 0", "foreign-pickle", "a pickle, but not one that torch.save() wrote");
  }
  PickleSequence parts(file, name);
  parts.next();  // the magic number
  check_version(parts.next(), name);
  check_byte_order(parts.next(), name);
  const Pickle pickle = parts.next();
  std::unordered_map<std::string_view, const PickledStorage*> announced;
  for (const Value& value : pickle.values) {
    const auto* storage = std::get_if<PickledStorage>(&value.is);
    if (storage != nullptr) announced[storage->key] = storage;
  }
  std::unordered_map<std::string, Bytes> storages;
  for (const std::string& key : strings_of(parts.next(), name)) {
    const auto storage = announced.find(key);
    if (storage == announced.end()) {
      refuse(name, "", "bad-pickle",
             fmt::format("lists storage {}, which no tensor uses", quote(key)));
    }
    storages[key] = parts.next_storage(key, *storage->second);
  }
  StoredArrays read;
  build_arrays(
      pickle, name,
      [&](const PickledStorage& storage) {
        const auto found = storages.find(storage.key);
        if (found == storages.end()) {
          refuse(
              name, "", "truncated",
              fmt::format("storage {} is missing from the list of storages", quote(storage.key)));
        }
        return found->second;
      },
      read);
  return read;
}

}  // namespace enfilade::features::formats
