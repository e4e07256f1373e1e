#include "bench/products.h"

#include <ATen/ATen.h>
#include <ATen/record_function.h>
#include <c10/core/InferenceMode.h>

#include <array>
#include <map>
#include <string_view>
#include <utility>

namespace enfilade::bench {
namespace {

thread_local ProductLog* product_log = nullptr;

bool transposed(const at::Tensor& x) { return x.stride(1) != 1 && x.stride(0) == 1; }

std::unique_ptr<at::ObserverContext> note(const at::RecordFunction& function) {
  const std::string_view name = function.name();
  const bool add = name == "aten::addmm_";
  if (!add && name != "aten::mm") return nullptr;
  const auto inputs = function.inputs();
  const std::size_t first = add ? 1 : 0;
  const at::Tensor a = inputs[first].toTensor(), b = inputs[first + 1].toTensor();
  product_log->push_back({a.size(0), b.size(1), a.size(1), transposed(a), transposed(b), add});
  return nullptr;
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

ProductRecorder::ProductRecorder(ProductLog& log) {
  product_log = &log;
  handle_ = at::addThreadLocalCallback(
      at::RecordFunctionCallback(&note).needsInputs(true).scopes({at::RecordScope::FUNCTION}));
}
ProductRecorder::~ProductRecorder() { at::removeCallback(handle_); }

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
    at::Tensor target = out;
    if (add) {
      target.addmm_(a, b);
    } else {
      at::mm_out(target, a, b);
    }
  }
}

}  // namespace enfilade::bench
