#include "enfilade/report/scaling_curve.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>

#include "enfilade/core/errors.h"
#include "enfilade/draw/markup.h"

namespace enfilade::report {
namespace {

using draw::escape;

// Of the sheet and of the part that holds the curve; pixels.
constexpr double kWidth = 720, kHeight = 400, kLeft = 56, kRight = 24, kTop = 44, kBottom = 52;
// Okabe and Ito's blue and grey: colour-blind readers tell them apart.
constexpr const char* kLine = "#0072b2";
constexpr const char* kGrey = "#6b6f76";

void check(const ScalingCurve& curve) {
  if (curve.points.empty()) throw ArgumentError("a curve of no point cannot be drawn");
  for (const CurvePoint& point : curve.points) {
    if (point.buildings == 0) throw ArgumentError("buildings: 0, at least 1 is needed");
  }
}

// From shares and numbers of buildings to the sheet.
class Axes {
 public:
  explicit Axes(const ScalingCurve& curve) {
    double top = curve.random ? curve.random->high : 0;
    first_ = last_ = static_cast<double>(curve.points.front().buildings);
    for (const CurvePoint& point : curve.points) {
      top = std::max(top, point.success.high);
      first_ = std::min(first_, static_cast<double>(point.buildings));
      last_ = std::max(last_, static_cast<double>(point.buildings));
    }
    step_ = top > 0.5 ? 0.2 : top > 0.2 ? 0.1 : 0.05;
    top_ = step_ * std::max(1.0, std::ceil(top / step_));
  }

  double x(std::size_t buildings) const {
    const double span = std::log(last_ / first_);
    const double share = span > 0 ? std::log(static_cast<double>(buildings) / first_) / span : 0.5;
    constexpr double kMargin = 24;
    return kLeft + kMargin + share * (kWidth - kLeft - kRight - 2 * kMargin);
  }
  double y(double share) const {
    return kHeight - kBottom - share / top_ * (kHeight - kTop - kBottom);
  }
  double step() const { return step_; }
  double top() const { return top_; }

 private:
  double first_ = 1, last_ = 1, step_ = 0.1, top_ = 1;
};

std::map<std::size_t, std::vector<CurvePoint>> by_buildings(const ScalingCurve& curve) {
  std::map<std::size_t, std::vector<CurvePoint>> groups;
  for (const CurvePoint& point : curve.points) groups[point.buildings].push_back(point);
  return groups;
}

double mean_success(const std::vector<CurvePoint>& points) {
  double sum = 0;
  for (const CurvePoint& point : points) sum += point.success.mean;
  return sum / static_cast<double>(points.size());
}

std::string grid(const ScalingCurve& curve, const Axes& axes) {
  std::string out;
  const double right = kWidth - kRight, foot = kHeight - kBottom;
  for (double share = 0; share <= axes.top() + 1e-9; share += axes.step()) {
    out += fmt::format(
        "<path d=\"M{} {:.1f}H{}\" stroke=\"#e3e5e9\"/><text x=\"{}\" y=\"{:.1f}\" "
        "text-anchor=\"end\">{:.0f}</text>\n",
        kLeft, axes.y(share), right, kLeft - 8, axes.y(share) + 4, 100 * share);
  }
  for (const auto& [buildings, points] : by_buildings(curve)) {
    out += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                       axes.x(buildings), foot + 18, buildings);
  }
  out += fmt::format(
      "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">training buildings</text>\n"
      "<text x=\"{}\" y=\"{}\">success in unseen buildings, %</text>\n",
      (kLeft + right) / 2, kHeight - 12, kLeft, kTop - 12);
  return out;
}

std::string random_of(const ScalingCurve& curve, const Axes& axes) {
  if (!curve.random) return "";
  const double high = axes.y(curve.random->high), low = axes.y(curve.random->low);
  return fmt::format(
      "<rect x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.1f}\" fill=\"{}\" "
      "fill-opacity=\".15\"/>"
      "<path d=\"M{} {:.1f}H{}\" stroke=\"{}\" stroke-dasharray=\"5 4\"/>"
      "<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">random</text>\n",
      kLeft, high, kWidth - kLeft - kRight, std::max(low - high, 0.5), kGrey, kLeft,
      axes.y(curve.random->mean), kWidth - kRight, kGrey, kWidth - kRight - 4,
      axes.y(curve.random->mean) - 4);
}

std::string dots(const ScalingCurve& curve, const Axes& axes) {
  std::string line, out;
  for (const auto& [buildings, points] : by_buildings(curve)) {
    line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", axes.x(buildings),
                        axes.y(mean_success(points)));
    // Seeds side by side, so that their intervals can be told apart.
    constexpr double kApart = 7;
    double x = axes.x(buildings) - kApart / 2 * static_cast<double>(points.size() - 1);
    for (const CurvePoint& point : points) {
      out += fmt::format(
          "<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke=\"{3}\" stroke-opacity=\".5\" "
          "stroke-width=\"2\"/><circle cx=\"{0:.1f}\" cy=\"{4:.1f}\" r=\"4\" fill=\"{3}\">"
          "<title>{5} buildings, seed {6}: {7:.1f} % [{8:.1f}, {9:.1f}]</title></circle>\n",
          x, axes.y(point.success.low), axes.y(point.success.high), kLine,
          axes.y(point.success.mean), buildings, point.seed, 100 * point.success.mean,
          100 * point.success.low, 100 * point.success.high);
      x += kApart;
    }
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"/>\n{}", line,
                     kLine, out);
}

std::string row_of(const CurvePoint& point) {
  const auto cell = [](const tasks::MeanInterval& value) {
    return fmt::format("<td>{:.1f} [{:.1f}, {:.1f}]</td>", 100 * value.mean, 100 * value.low,
                       100 * value.high);
  };
  return fmt::format("<tr><td>{}</td><td>{}</td>{}{}</tr>\n", point.buildings, point.seed,
                     cell(point.success), cell(point.spl));
}

}  // namespace

std::string scaling_curve_svg(const ScalingCurve& curve) {
  check(curve);
  const Axes axes(curve);
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" font-family=\"system-ui, sans-serif\" font-size=\"12\" fill=\"#33404f\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#fdfdfc\"/>\n"
      "<text x=\"{2}\" y=\"18\" font-size=\"15\" font-weight=\"600\">{3}{4}</text>\n{5}{6}{7}"
      "</svg>\n",
      kWidth, kHeight, kLeft, escape(curve.title), curve.synthetic ? " (SYNTHETIC)" : "",
      grid(curve, axes), random_of(curve, axes), dots(curve, axes));
}

std::string scaling_curve_page(const ScalingCurve& curve) {
  const std::string picture = scaling_curve_svg(curve);
  std::vector<CurvePoint> points = curve.points;
  std::ranges::sort(points, {}, [](const CurvePoint& p) { return std::pair(p.buildings, p.seed); });
  std::string rows, facts;
  for (const CurvePoint& point : points) rows += row_of(point);
  for (const auto& [name, value] : curve.facts) {
    facts += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escape(name), escape(value));
  }
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>{0}</title>\n<style>\n"
      "body {{ font: 15px/1.5 system-ui, sans-serif; max-width: 760px; margin: 2em auto; padding: "
      "0 1em; color: #1d2026; background: #fdfdfc }}\n"
      "svg {{ width: 100%; height: auto }}\n"
      "table {{ border-collapse: collapse; margin: 1em 0 }}\n"
      "td, th {{ padding: .2em .8em; text-align: left; border-bottom: 1px solid #e3e5e9 }}\n"
      "</style>\n<h1>{0}</h1>\n{1}{2}\n"
      "<table>\n<tr><th>buildings</th><th>seed</th><th>SR (%)</th><th>SPL (%)</th></tr>\n{3}"
      "</table>\n<p>Intervals are of 95 %: bootstrap over paths. The line goes through the means "
      "of the seeds.</p>\n<table>\n{4}</table>\n</html>\n",
      escape(curve.title),
      curve.synthetic ? "<p>SYNTHETIC: model homes made by Enfilade. Not to be compared with any "
                        "published figure.</p>\n"
                      : "",
      picture, rows, facts);
}

}  // namespace enfilade::report
