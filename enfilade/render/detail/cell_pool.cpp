#include "enfilade/render/detail/cell_pool.h"

#include <sys/mman.h>

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

namespace enfilade::render::detail {
namespace {

constexpr std::size_t kPage = std::size_t{2} << 20;
constexpr std::size_t kPieces = 16;  // of a block, at least: no more than a page is lost at its end

std::size_t whole_pages(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

}  // namespace

// Pieces of one size.
struct CellPool::Block {
  std::size_t piece_bytes, mapped_bytes;
  std::uint8_t* mapped;
  std::vector<std::uint8_t*> free;
  std::size_t used = 0;

  explicit Block(std::size_t bytes) : piece_bytes(bytes) {
    // With room for the first page to begin where it may be a large one.
    const std::size_t wanted = whole_pages(kPieces * bytes);
    mapped_bytes = wanted + kPage;
    void* address = mmap(nullptr, mapped_bytes, PROT_READ | PROT_WRITE,
                         MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (address == MAP_FAILED) throw std::bad_alloc();
    mapped = static_cast<std::uint8_t*>(address);
    const std::size_t skipped = (kPage - reinterpret_cast<std::uintptr_t>(mapped) % kPage) % kPage;
    std::uint8_t* first = mapped + skipped;
    // Only advice: small pages serve as well, more slowly.
    static_cast<void>(madvise(first, wanted, MADV_HUGEPAGE));
    for (std::size_t k = wanted / bytes; k-- > 0;) free.push_back(first + k * bytes);
  }
  ~Block() { munmap(mapped, mapped_bytes); }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
};

CellPool::CellPool() = default;
CellPool::~CellPool() = default;

CellPool::Piece CellPool::take(std::size_t bytes) {
  auto block = std::ranges::find_if(
      blocks_, [&](const Block& b) { return b.piece_bytes == bytes && !b.free.empty(); });
  if (block == blocks_.end()) block = blocks_.emplace(blocks_.end(), bytes);
  std::uint8_t* piece = block->free.back();
  block->free.pop_back();
  ++block->used;
  return {piece, Return(this, block)};
}

void CellPool::give_back(std::list<Block>::iterator block, std::uint8_t* piece) noexcept {
  block->free.push_back(piece);  // never more than it once held
  if (--block->used == 0) blocks_.erase(block);
}

}  // namespace enfilade::render::detail
