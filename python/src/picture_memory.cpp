#include "python/src/picture_memory.h"

#include <nanobind/ndarray.h>

#include <algorithm>
#include <array>
#include <functional>
#include <new>
#include <numeric>
#include <utility>

#include "enfilade/core/errors.h"

namespace nb = nanobind;

namespace enfilade::python {
namespace {

constexpr std::align_val_t kAlignment{64};  // a cache line
constexpr std::size_t kKept = 4;            // colour, depth, classes, instances of one step

struct Free {
  void operator()(std::byte* memory) const { ::operator delete(memory, kAlignment); }
};

/// Memory and its size.
struct Piece {
  std::size_t bytes = 0;
  std::unique_ptr<std::byte, Free> memory;
};

struct Type {
  const char* name;
  nb::dlpack::dtype type;
};
const std::array<Type, 4> kTypes{{{"uint8", nb::dtype<std::uint8_t>()},
                                  {"uint16", nb::dtype<std::uint16_t>()},
                                  {"uint32", nb::dtype<std::uint32_t>()},
                                  {"float32", nb::dtype<float>()}}};

}  // namespace

/// Released memory, the latest last.
struct PictureMemory::Store {
  Store() { pieces.reserve(kKept); }  // so that give_back() cannot fail

  std::mutex mutex;
  std::vector<Piece> pieces;

  Piece take(std::size_t bytes) {
    {
      const std::scoped_lock lock(mutex);
      const auto found = std::ranges::find(pieces, bytes, &Piece::bytes);
      if (found != pieces.end()) {
        Piece piece = std::move(*found);
        pieces.erase(found);
        return piece;
      }
    }
    return {bytes, std::unique_ptr<std::byte, Free>(
                       static_cast<std::byte*>(::operator new(bytes, kAlignment)))};
  }

  void give_back(Piece piece) {
    const std::scoped_lock lock(mutex);
    if (pieces.size() == kKept) pieces.erase(pieces.begin());
    pieces.push_back(std::move(piece));
  }
};

/// The owner of an array's memory.
struct PictureMemory::Block {
  std::shared_ptr<Store> store;
  Piece piece;
};

PictureMemory::PictureMemory() : store_(std::make_shared<Store>()) {}

nb::object PictureMemory::array(std::span<const std::size_t> shape, const std::string& type) {
  const auto* known = std::ranges::find(kTypes, type, &Type::name);
  if (known == kTypes.end()) throw ArgumentError("type '" + type + "' is none of a picture's");
  const std::size_t values =
      std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies());
  auto block = std::make_unique<Block>(Block{store_, store_->take(values * known->type.bits / 8)});
  std::byte* memory = block->piece.memory.get();
  const nb::capsule owner(block.release(), [](void* p) noexcept {
    const std::unique_ptr<Block> gone(static_cast<Block*>(p));
    gone->store->give_back(std::move(gone->piece));
  });
  return nb::cast(
      nb::ndarray<nb::numpy>(memory, shape.size(), shape.data(), owner, nullptr, known->type));
}

}  // namespace enfilade::python
