/// \file  The matrix products of a network, and the time that they take alone: the lower bound of
/// its time.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

namespace enfilade::bench {

/// One product: out (rows, columns) = a (rows, inner) b (inner, columns).
struct Product {
  std::int64_t rows = 0;
  std::int64_t columns = 0;
  std::int64_t inner = 0;
  bool a_transposed = false;  ///< a lies in memory as (inner, rows)
  bool b_transposed = false;  ///< b as (columns, inner)
  bool add = false;           ///< the product is added to `out`

  /// Floating-point operations.
  double operations() const noexcept {
    return 2.0 * static_cast<double>(rows) * static_cast<double>(columns) *
           static_cast<double>(inner);
  }
};

/// Products in the order of the calls.
using ProductLog = std::vector<Product>;

/// Logs libtorch's products of two matrices on the calling thread while it lives.
class ProductRecorder {
 public:
  explicit ProductRecorder(ProductLog& log);
  ~ProductRecorder();
  ProductRecorder(const ProductRecorder&) = delete;
  ProductRecorder& operator=(const ProductRecorder&) = delete;

 private:
  std::uint64_t handle_ = 0;
};

/// Repeats products on the CPU, on random numbers in the memory layout of the network's operands;
/// products of one shape share their memory. One thread at a time.
class ProductTimer {
 public:
  /// Allocates the operands.
  explicit ProductTimer(const ProductLog& products);
  ~ProductTimer();
  ProductTimer(const ProductTimer&) = delete;
  ProductTimer& operator=(const ProductTimer&) = delete;
  void run() const;  ///< all products, in order

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace enfilade::bench
