/// \file  Which matrix products the network made, and how long they take without the rest: the
/// measure of how well it runs.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace enfilade::neural {

/// out (rows, columns) = a (rows, inner) b (inner, columns)
struct Product {
  std::int64_t rows = 0;
  std::int64_t columns = 0;
  std::int64_t inner = 0;
  bool a_transposed = false;  ///< a lies in memory as (inner, rows)
  bool b_transposed = false;  ///< b as (columns, inner)
  bool add = false;           ///< to what is in `out`

  double operations() const noexcept {
    return 2.0 * static_cast<double>(rows) * static_cast<double>(columns) *
           static_cast<double>(inner);
  }
};

/// In the order they were asked for.
using ProductLog = std::vector<Product>;

/// Where the products of networks on the calling thread are noted from now on; null: nowhere.
/// Returns where they were before. \param log must live until the next call
ProductLog* log_products(ProductLog* log) noexcept;

/// Does products again, by themselves, on the CPU: on random numbers laid out as the network's
/// operands are; products of one shape share their memory. One thread at a time.
class ProductTimer {
 public:
  /// Makes random operands for each shape of these products.
  explicit ProductTimer(const ProductLog& products);
  ~ProductTimer();
  ProductTimer(const ProductTimer&) = delete;
  ProductTimer& operator=(const ProductTimer&) = delete;
  void run() const;  ///< all of them, in order

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace enfilade::neural
