/// \file  Inner loops on the CPU, on ranges that the caller divides among threads.
#pragma once
#include <cstddef>
#include <cstdint>

namespace enfilade::neural::core {

/// A matrix with contiguous rows.
struct MatrixRows {
  float* data = nullptr;
  std::size_t stride = 0;  ///< from a row to the next

  float* operator[](std::size_t row) const noexcept { return data + row * stride; }
};

/// n rows of an LSTM cell; gates are in PyTorch's order: i, f, g, o.
struct LstmRows {
  MatrixRows
      gates;  ///< (n, 4 h) forward: sums in, activations out; backward: those in, gradient out
  MatrixRows previous;  ///< (n, h) cells before
  MatrixRows cells;     ///< (n, h) after
  std::size_t hidden = 0;
};
struct LstmForward {
  LstmRows rows;
  const float* bias = nullptr;  ///< (4 h) added to the sums
  MatrixRows outputs;           ///< (n, h) written
};
struct LstmBackward {
  LstmRows rows;
  MatrixRows from_outputs;  ///< (n, h) gradient of the outputs from outside
  MatrixRows from_next;     ///< (n, h) and from the next step
  MatrixRows cells;         ///< (n, h) gradient of the cells, in: after; out: before
};

/// out (m, n) = sum over k of a(i, k) b(k, j), with any strides of a.
struct Combination {
  const float* a = nullptr;
  std::size_t a_row = 0;  ///< from a(i, k) to a(i + 1, k)
  std::size_t a_column = 0;
  MatrixRows b;
  MatrixRows out;
  std::size_t m = 0, n = 0, k = 0;
  bool add = false;  ///< to the values in `out`
};

struct AdamStep {
  float* weights = nullptr;
  const float* gradients = nullptr;
  float* first = nullptr;
  float* second = nullptr;
  float beta1 = 0, beta2 = 0, epsilon = 0, weight_decay = 0;
  float rate = 0;   ///< learning rate / (1 - beta1^updates)
  float scale = 0;  ///< 1 / sqrt(1 - beta2^updates)
};

/// Rows of `width` numbers: out = norm(kept y + x) scale + bias.
struct SumNorm {
  const float* y = nullptr;
  const float* kept = nullptr;  ///< factors of y; null: 1
  const float* x = nullptr;     ///< null: 0
  const float* scale = nullptr;
  const float* bias = nullptr;
  float epsilon = 0;  ///< added to the variance
  std::size_t width = 0;
  float* out = nullptr;
  float* normalized = nullptr;  ///< before scale and bias
  float* inverse = nullptr;     ///< (rows) of the deviation
};
struct SumNormBackward {
  const float* gradient = nullptr;
  const float* kept = nullptr;
  const float* scale = nullptr;
  const float* normalized = nullptr;
  const float* inverse = nullptr;
  std::size_t width = 0;
  float* to_x = nullptr;
  float* to_y = nullptr;      ///< written only if there is `kept`; it is to_x otherwise
  float* to_scale = nullptr;  ///< (width) added to
  float* to_bias = nullptr;   ///< (width) added to
};

struct SimdKernels {
  void (*lstm_forward)(const LstmForward&, std::size_t begin, std::size_t end);
  void (*lstm_backward)(const LstmBackward&, std::size_t begin, std::size_t end);
  /// Kept elements times scale, others 0. In place is allowed.
  void (*drop)(const float* in, float* out, std::size_t n, const std::uint64_t* kept, float scale);
  void (*tanh)(float* x, std::size_t n);
  void (*tanh_backward)(const float* y, float* gradient, std::size_t n);  ///< times 1 - y^2
  /// out (m, n) = a (m, k) times the transpose of b (n, k)
  void (*scores)(MatrixRows a, MatrixRows b, MatrixRows out, std::size_t m, std::size_t n,
                 std::size_t k);
  void (*combine)(const Combination&);
  void (*softmax)(float* x, std::size_t n);  ///< \pre n > 0
  /// gradient -> y (gradient - sum(y gradient))
  void (*softmax_backward)(const float* y, float* gradient, std::size_t n);
  void (*add_row)(const float* in, float* out, std::size_t n);
  void (*adam)(const AdamStep&, std::size_t begin, std::size_t end);
  bool (*all_finite)(const float* x, std::size_t n);
  void (*multiply)(const float* in, float* out, std::size_t n);  ///< out -> out in
  /// `kept` where 16 random bits are at least `dropped`, else 0.
  void (*keep)(const std::uint16_t* bits, std::uint32_t dropped, float kept, float* out,
               std::size_t n);
  /// x Phi(x) of the normal distribution's Phi, to 2e-7 |x|
  void (*gelu)(const float* x, float* out, std::size_t n);
  /// out = gradient (Phi(x) + x times the density at x)
  void (*gelu_backward)(const float* x, const float* gradient, float* out, std::size_t n);
  void (*sum_norm)(const SumNorm&, std::size_t begin, std::size_t end);
  void (*sum_norm_backward)(const SumNormBackward&, std::size_t begin, std::size_t end);
};

/// The loops for the processor's best instruction set. NaN in an input gives NaN in its outputs.
const SimdKernels& simd_kernels() noexcept;

}  // namespace enfilade::neural::core
