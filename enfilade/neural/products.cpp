#include "enfilade/neural/products.h"

#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>

#include <array>
#include <map>
#include <utility>

#include "enfilade/neural/seq2seq/kernels.h"

namespace enfilade::neural {
namespace {

thread_local ProductLog* product_log = nullptr;

bool transposed(const at::Tensor& x) { return x.stride(1) != 1 && x.stride(0) == 1; }

void note(const at::Tensor& a, const at::Tensor& b, bool add) {
  if (product_log == nullptr) return;
  product_log->push_back({a.size(0), b.size(1), a.size(1), transposed(a), transposed(b), add});
}

struct Operands {
  at::Tensor a, b, out;
};

Operands operands_of(const Product& product) {
  const auto matrix = [](std::int64_t rows, std::int64_t columns, bool transposed) {
    return transposed ? at::randn({columns, rows}).t() : at::randn({rows, columns});
  };
  return {matrix(product.rows, product.inner, product.a_transposed),
          matrix(product.inner, product.columns, product.b_transposed),
          at::zeros({product.rows, product.columns})};
}

}  // namespace

ProductLog* log_products(ProductLog* log) noexcept { return std::exchange(product_log, log); }

void seq2seq::multiply(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out) {
  note(a, b, false);
  at::Tensor target = out;
  at::mm_out(target, a, b);
}

void seq2seq::multiply_add(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out) {
  note(a, b, true);
  out.addmm_(a, b);
}

struct ProductTimer::Impl {
  std::map<std::array<std::int64_t, 5>, Operands> operands;
  std::vector<std::pair<const Operands*, bool>> order;  // and whether the product is added
};

ProductTimer::ProductTimer(const ProductLog& products) {
  const c10::InferenceMode guard;
  auto impl = std::make_unique<Impl>();
  for (const Product& p : products) {
    const auto [place, is_new] =
        impl->operands.try_emplace({p.rows, p.columns, p.inner, p.a_transposed, p.b_transposed});
    if (is_new) place->second = operands_of(p);
    impl->order.emplace_back(&place->second, p.add);
  }
  impl_ = std::move(impl);
}
ProductTimer::~ProductTimer() = default;

void ProductTimer::run() const {
  const c10::InferenceMode guard;
  for (const auto& [operands, add] : impl_->order) {
    const auto& [a, b, out] = *operands;
    add ? seq2seq::multiply_add(a, b, out) : seq2seq::multiply(a, b, out);
  }
}

}  // namespace enfilade::neural
