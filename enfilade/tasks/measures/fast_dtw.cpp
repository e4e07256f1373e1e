#include "enfilade/tasks/fast_dtw.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"

namespace enfilade::tasks {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Points = std::vector<Point3>;
using Alignment = std::vector<std::pair<std::size_t, std::size_t>>;  // from the start to the end

// Columns of a row that may be used, both included.
struct Bounds {
  std::size_t low = 0, high = 0;
  bool has(std::size_t j) const { return low <= j && j <= high; }
};
using Window = std::vector<Bounds>;

double distance(const Point3& a, const Point3& b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z);
}

enum class Step : std::uint8_t { kUp, kLeft, kCorner };

// The alignment within a window, row by row.
class Aligner {
 public:
  Aligner(std::span<const Point3> a, std::span<const Point3> b, Window window, FastDtw form)
      : a_(a), b_(b), window_(std::move(window)), form_(form), steps_(a.size()) {}

  double cost() {
    for (std::size_t i = 0; i < a_.size(); ++i) fill(i);
    return row_.back();
  }

  // \pre cost() was called
  Alignment path() const {
    Alignment path;
    std::size_t i = a_.size() - 1, j = b_.size() - 1;
    path.emplace_back(i, j);
    while (i > 0 || j > 0) {
      const Step step = steps_[i][j - window_[i].low];
      if (step != Step::kLeft) --i;
      if (step != Step::kUp) --j;
      path.emplace_back(i, j);
    }
    std::ranges::reverse(path);
    return path;
  }

 private:
  void fill(std::size_t i) {
    const Bounds bounds = window_[i];
    std::vector<double> row(bounds.high - bounds.low + 1, kInfinity);
    steps_[i].resize(row.size());
    for (std::size_t j = bounds.low; j <= bounds.high; ++j) {
      const std::size_t k = j - bounds.low;
      if (i == 0 && j == 0) {
        row[0] = distance(a_[0], b_[0]);
        continue;
      }
      const double left = k > 0 ? row[k - 1] : kInfinity;
      const auto [least, step] = best(above(i, j), left, corner(i, j));
      row[k] = least + distance(a_[i], b_[j]);
      steps_[i][k] = step;
    }
    row_ = std::move(row);
  }

  double above(std::size_t i, std::size_t j) const {
    return i > 0 && window_[i - 1].has(j) ? row_[j - window_[i - 1].low] : kInfinity;
  }
  double corner(std::size_t i, std::size_t j) const {
    if (i == 0 || j == 0 || !window_[i - 1].has(j - 1)) return kInfinity;
    if (form_ == FastDtw::kCompiled && j > window_[i - 1].high) return kInfinity;
    return row_[j - 1 - window_[i - 1].low];
  }
  std::pair<double, Step> best(double up, double left, double corner) const {
    using enum Step;
    const std::array<std::pair<double, Step>, 3> plain{
        {{up, kUp}, {left, kLeft}, {corner, kCorner}}};
    const std::array<std::pair<double, Step>, 3> compiled{
        {{corner, kCorner}, {left, kLeft}, {up, kUp}}};
    const auto& order = form_ == FastDtw::kPlain ? plain : compiled;
    return *std::ranges::min_element(order, {},
                                     &std::pair<double, Step>::first);  // the first of equals
  }

  std::span<const Point3> a_, b_;
  Window window_;
  FastDtw form_;
  std::vector<std::vector<Step>> steps_;
  std::vector<double> row_;  // the last one that was filled
};

Window whole(std::size_t rows, std::size_t columns) { return Window(rows, {0, columns - 1}); }

// Means of neighbours; the last of an odd number is left out.
Points halved(std::span<const Point3> points) {
  Points half(points.size() / 2);
  for (std::size_t k = 0; k < half.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      half[k][c] = (points[2 * k][c] + points[2 * k + 1][c]) / 2;
    }
  }
  return half;
}

// The window within one cell of a coarse alignment, for twice as many rows and columns.
Window refined(const Alignment& path, std::size_t rows, std::size_t columns, FastDtw form) {
  std::vector<Bounds> coarse(path.back().first + 2, {columns, 0});  // one row beyond
  for (const auto& [i, j] : path) {
    for (std::size_t row = i > 0 ? i - 1 : 0; row <= i + 1; ++row) {
      coarse[row].low = std::min(coarse[row].low, j > 0 ? j - 1 : 0);
      coarse[row].high = std::max(coarse[row].high, j + 1);
    }
  }
  Window window(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    const Bounds& from = coarse[i / 2];
    window[i] = {2 * from.low, std::min(columns - 1, 2 * from.high + 1)};
  }
  if (form == FastDtw::kCompiled && rows % 2 == 1) window[rows - 1] = window[rows - 2];
  return window;
}

std::pair<double, Alignment> align(std::span<const Point3> a, std::span<const Point3> b,
                                   FastDtw form) {
  constexpr std::size_t kLeast = 3;  // radius + 2
  Window window;
  if (a.size() < kLeast || b.size() < kLeast) {
    window = whole(a.size(), b.size());
  } else {
    window = refined(align(halved(a), halved(b), form).second, a.size(), b.size(), form);
  }
  Aligner aligner(a, b, std::move(window), form);
  const double cost = aligner.cost();
  return {cost, aligner.path()};
}

}  // namespace

double exact_dtw(std::span<const Point3> a, std::span<const Point3> b) {
  EN_CHECK(!a.empty() && !b.empty());
  std::vector<double> row(b.size(), kInfinity);
  for (std::size_t i = 0; i < a.size(); ++i) {
    double diagonal = i == 0 ? 0 : kInfinity, left = kInfinity;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const double above = row[j];
      left = distance(a[i], b[j]) + std::min({left, above, diagonal});
      row[j] = left;
      diagonal = above;
    }
  }
  return row.back();
}

double fast_dtw(std::span<const Point3> a, std::span<const Point3> b, FastDtw form) {
  EN_CHECK(!a.empty() && !b.empty());
  return align(a, b, form).first;
}

}  // namespace enfilade::tasks
