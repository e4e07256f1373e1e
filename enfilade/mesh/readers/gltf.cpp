#include "enfilade/mesh/readers/gltf.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <limits>
#include <system_error>
#include <type_traits>
#include <utility>

#include "enfilade/core/written_lists.h"

namespace enfilade::mesh::readers {
namespace {

using tinygltf::Model;

template <class T>
T value_at(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));  // both the format and the machine are little-endian
  return value;
}
/// The user data of tinygltf's file callbacks.
struct Files {
  const Source& source;
  ReadResult& result;
  std::optional<std::string> missing;  ///< message of the last file that could not be read
  std::string last;                    ///< path of the last file that was read
};

/// tinygltf looks for a file in its base folder, which is "" here, then in "./": for both, find()
/// searches the source's folder.
bool file_exists(const std::string& path, void* user) {
  const Files& files = *static_cast<Files*>(user);
  std::error_code code;
  return files.source.on_disk && !path.empty() &&
         std::filesystem::is_regular_file(files.source.find(path).path, code);
}
std::string same_path(const std::string& path, void*) { return path; }
bool read_whole_file(std::vector<unsigned char>* out, std::string* error, const std::string& path,
                     void* user) {
  Files& files = *static_cast<Files*>(user);
  try {
    const Source::Part part = files.source.find(path);
    const std::string bytes = read_part(part.path);
    note_moved(files.result, files.source.name, "", path, part);
    out->assign(bytes.begin(), bytes.end());
    files.last = part.path.string();
    return true;
  } catch (const FileError& e) {
    files.missing = e.what();
    if (error != nullptr) *error = e.what();
    return false;
  }
}
bool write_nothing(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
  return false;
}
[[maybe_unused]] bool find_size(std::size_t* bytes, std::string* error, const std::string& path,
                                void* user) {
  const Files& files = *static_cast<Files*>(user);
  std::error_code code;
  *bytes = std::filesystem::file_size(files.source.find(path).path, code);
  if (code && error != nullptr) *error = code.message();
  return !code;
}

template <class Callbacks>  // FsCallbacks: a template, so that a member that it lacks is no error
Callbacks callbacks_of(Files& files) {
  Callbacks callbacks{};
  callbacks.FileExists = file_exists;
  callbacks.ExpandFilePath = same_path;
  callbacks.ReadWholeFile = read_whole_file;
  callbacks.WriteWholeFile = write_nothing;
  callbacks.user_data = &files;
  if constexpr (requires { callbacks.GetFileSizeInBytes; }) {  // since tinygltf 2.9
    callbacks.GetFileSizeInBytes = find_size;
  }
  return callbacks;
}

/// Keeps images encoded; read_gltf_materials() decodes those that are used. Images in buffers are
/// not copied here, as tinygltf does not check that they lie inside the buffer; view_bytes() does.
bool keep_image(tinygltf::Image* image, int, std::string*, std::string*, int, int,
                const unsigned char* bytes, int size, void* user) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  if (!image->uri.empty()) image->uri = static_cast<Files*>(user)->last;
  return true;
}

template <class T>
double number_at(const char* at) {
  return static_cast<double>(value_at<T>(at));
}

/// A number type of accessors.
struct ComponentType {
  int code;
  std::size_t bytes;
  double (*read)(const char* at);
  bool is_unsigned;
  double one;  ///< what stands for 1 if it is normalised (glTF 2.0, 3.6.2.2); 0: never normalised
};
template <class T>
constexpr ComponentType component_type(int code) {
  constexpr bool kNormalised = sizeof(T) < 4;
  return {code, sizeof(T), number_at<T>, std::is_unsigned_v<T>,
          kNormalised ? static_cast<double>(std::numeric_limits<T>::max()) : 0};
}
constexpr std::array kComponentTypes{
    component_type<std::int8_t>(TINYGLTF_COMPONENT_TYPE_BYTE),
    component_type<std::uint8_t>(TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE),
    component_type<std::int16_t>(TINYGLTF_COMPONENT_TYPE_SHORT),
    component_type<std::uint16_t>(TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT),
    component_type<std::uint32_t>(TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT),
    component_type<float>(TINYGLTF_COMPONENT_TYPE_FLOAT)};

/// Null for types that the format does not allow.
const ComponentType* find_type(int code) {
  const auto at = std::ranges::find(kComponentTypes, code, &ComponentType::code);
  return at == kComponentTypes.end() ? nullptr : &*at;
}

class AccessorReader {
 public:
  AccessorReader(const Model& model, int accessor, const std::string& file)
      : model_(model),
        file_(file),
        where_(fmt::format("$.accessors[{}]", accessor)),
        accessor_(item_at(model.accessors, accessor)) {
    if (accessor_ == nullptr) {
      refuse(file, where_, "bad-index", fmt::format("only {} are there", model.accessors.size()));
    }
  }

  GltfNumbers read() {
    const tinygltf::Accessor& a = *accessor_;
    type_ = find_type(a.componentType);
    const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type));
    if (type_ == nullptr || components <= 0) {
      fail(fmt::format("component type {}, not one of glTF's", a.componentType));
    }
    if (a.count == 0) fail("a count of 0");
    out_.components = static_cast<std::size_t>(components);
    out_.count = a.count;
    out_.whole = !a.normalized && type_->is_unsigned;
    const std::size_t element = out_.components * type_->bytes;
    if (a.bufferView < 0) {  // all zeros (glTF 2.0, 3.6.2.3), but for the sparse ones
      const std::size_t most = most_items(model_) / out_.components;
      if (a.count > most) fail(fmt::format("{} items of zeros, more than {}", a.count, most));
      out_.values.resize(out_.count * out_.components);
    } else {
      read_view(element);
    }
    if (a.sparse.isSparse) read_sparse(element);
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(std::string message) const {
    refuse(file_, where_, "bad-accessor", std::move(message));
  }
  std::string_view view(int index) const { return view_bytes(model_, index, file_, where_); }

  void read_view(std::size_t element) {
    const tinygltf::Accessor& a = *accessor_;
    const std::string_view bytes = view(a.bufferView);
    const std::size_t given = item_at(model_.bufferViews, a.bufferView)->byteStride;
    const std::size_t stride = given == 0 ? element : given;
    if (stride < element) fail(fmt::format("a stride of {} for items of {}", stride, element));
    check_fits(bytes, a.byteOffset, a.count, stride, element);
    out_.values.resize(out_.count * out_.components);
    for (std::size_t i = 0; i < a.count; ++i) {
      set_item(i, bytes.data() + a.byteOffset + i * stride);
    }
  }
  void check_fits(std::string_view bytes, std::size_t offset, std::size_t count, std::size_t stride,
                  std::size_t element) const {
    const bool fits = offset <= bytes.size() && element <= bytes.size() - offset &&
                      count - 1 <= (bytes.size() - offset - element) / stride;
    if (fits) return;
    fail(fmt::format("{} items from byte {} on, every {} bytes, end after their {} bytes", count,
                     offset, stride, bytes.size()));
  }
  void set_item(std::size_t item, const char* from) {
    for (std::size_t k = 0; k < out_.components; ++k) {
      const double value = type_->read(from + k * type_->bytes);
      const bool normalised = accessor_->normalized && type_->one > 0;
      out_.values[item * out_.components + k] =
          normalised ? std::max(value / type_->one, -1.0) : value;
    }
  }
  void read_sparse(std::size_t element) {
    const auto& sparse = accessor_->sparse;
    const ComponentType* type = find_type(sparse.indices.componentType);
    if (sparse.count < 1 || static_cast<std::size_t>(sparse.count) > out_.count ||
        std::cmp_less(sparse.indices.byteOffset, 0) ||  // signed until tinygltf 2.9
        std::cmp_less(sparse.values.byteOffset, 0) || type == nullptr || !type->is_unsigned) {
      fail("its sparse part has a count, an offset or a type that is not allowed");
    }
    const auto count = static_cast<std::size_t>(sparse.count),
               at = static_cast<std::size_t>(sparse.indices.byteOffset),
               values_at = static_cast<std::size_t>(sparse.values.byteOffset);
    const std::string_view indices = view(sparse.indices.bufferView),
                           values = view(sparse.values.bufferView);
    check_fits(indices, at, count, type->bytes, type->bytes);
    check_fits(values, values_at, count, element, element);
    for (std::size_t i = 0; i < count; ++i) {
      const auto item = static_cast<std::size_t>(type->read(indices.data() + at + i * type->bytes));
      if (item >= out_.count) fail(fmt::format("sparse index {} of {}", item, out_.count));
      set_item(item, values.data() + values_at + i * element);
    }
  }

  const Model& model_;
  const std::string& file_;
  std::string where_;
  const tinygltf::Accessor* accessor_;
  const ComponentType* type_ = nullptr;
  GltfNumbers out_;
};

}  // namespace

double normalised_one(const tinygltf::Accessor& accessor) {
  const ComponentType* type = find_type(accessor.componentType);
  return type != nullptr && accessor.normalized ? type->one : 0;
}

Model load_gltf(const Source& source, ReadResult& result) {
  if (source.bytes.size() > std::numeric_limits<std::uint32_t>::max()) {
    refuse(source.name, "", "bad-container", "more than 4 GiB, the most that a glTF file can have");
  }
  const bool binary = source.bytes.starts_with("glTF");
  const bool plain = check_gltf_json(
      binary ? gltf_json_chunk(source.bytes, source.name) : source.bytes, source.name, result);
  std::string rewritten;  // what tinygltf would refuse
  if (!plain) rewritten = rewrite_gltf(source.bytes, source.name);
  const std::string_view bytes = plain ? source.bytes : std::string_view(rewritten);
  Files files{source, result, std::nullopt, {}};
  tinygltf::TinyGLTF reader;
  reader.SetImageLoader(keep_image, &files);
  reader.SetFsCallbacks(callbacks_of<tinygltf::FsCallbacks>(files));
  Model model;
  std::string error, warning;
  bool read = false;
  const auto size = static_cast<unsigned>(bytes.size());
  try {
    read = binary ? reader.LoadBinaryFromMemory(
                        &model, &error, &warning,
                        reinterpret_cast<const unsigned char*>(bytes.data()), size, "")
                  : reader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, "");
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {  // its JSON library throws for values of a wrong type
    error = e.what();
  }
  if (files.missing && !read) throw FileError(*files.missing);
  if (!read) {
    const std::string_view first = trimmed(std::string_view(error).substr(0, error.find('\n')));
    refuse(source.name, "", "bad-gltf", std::string(first.substr(0, 200)));
  }
  unpack_meshopt(model, source.name);
  return model;
}

std::string_view view_bytes(const Model& model, int view, const std::string& file,
                            const std::string& where) {
  const auto fail = [&](const std::string& what) {
    refuse(file, where, "bad-buffer-view", fmt::format("buffer view {}: {}", view, what));
  };
  const tinygltf::BufferView* v = item_at(model.bufferViews, view);
  if (v == nullptr) fail(fmt::format("only {} are there", model.bufferViews.size()));
  if (!reads_extension(kMeshoptCompression) && is_meshopt_alone(model, *v)) {
    fail(lacks_library(kMeshoptCompression));
  }
  const tinygltf::Buffer* buffer = item_at(model.buffers, v->buffer);
  if (buffer == nullptr) fail(fmt::format("buffer {} of {}", v->buffer, model.buffers.size()));
  const auto& data = buffer->data;
  if (v->byteOffset > data.size() || v->byteLength > data.size() - v->byteOffset) {
    fail(fmt::format("{} bytes from {} on end after their buffer's {}", v->byteLength,
                     v->byteOffset, data.size()));
  }
  return {reinterpret_cast<const char*>(data.data()) + v->byteOffset, v->byteLength};
}

std::size_t most_items(const Model& model) {
  std::size_t bytes = 0;
  for (const tinygltf::Buffer& buffer : model.buffers) bytes += buffer.data.size();
  const bool draco =
      std::ranges::find(model.extensionsUsed, kDracoCompression) != model.extensionsUsed.end();
  return (std::size_t{1} << 22) + (draco ? 64 : 4) * bytes;
}

GltfNumbers read_accessor(const Model& model, int accessor, const std::string& file) {
  return AccessorReader(model, accessor, file).read();
}

}  // namespace enfilade::mesh::readers
