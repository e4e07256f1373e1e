/// \file  Memory for decoded faces, in large pages.
#pragma once
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>

namespace enfilade::render::detail {

/// Allocates pieces of memory from blocks of 2 MiB pages, where the system has them. Drawing reads
/// texels all over a panorama, and one page table entry then serves 512 times as many. A block goes
/// back to the system when none of its pieces is used. Not for several threads at once.
class CellPool {
  struct Block;

 public:
  /// Gives its memory back.
  class Return {
   public:
    Return() = default;
    Return(CellPool* pool, std::list<Block>::iterator block) : pool_(pool), block_(block) {}
    void operator()(std::uint8_t* piece) const noexcept { pool_->give_back(block_, piece); }

   private:
    CellPool* pool_ = nullptr;
    std::list<Block>::iterator block_;
  };
  /// A piece; must not outlive the pool.
  using Piece = std::unique_ptr<std::uint8_t, Return>;

  CellPool();
  ~CellPool();  // NOLINT(performance-trivially-destructible): Block is incomplete here
  CellPool(const CellPool&) = delete;
  CellPool& operator=(const CellPool&) = delete;

  /// Aligned to 64 bytes; its content is unspecified. \pre bytes > 0, a multiple of 64
  /// \throws std::bad_alloc
  Piece take(std::size_t bytes);

 private:
  void give_back(std::list<Block>::iterator block, std::uint8_t* piece) noexcept;

  std::list<Block> blocks_;
};

}  // namespace enfilade::render::detail
