/// \file  Angles with their unit in the type.
#pragma once
#include <cmath>
#include <compare>
#include <numbers>

namespace enfilade {

/// The ratio of a circle's circumference to its diameter.
inline constexpr double kPi = std::numbers::pi;

/// An angle in radians. Headings count clockwise from world +y (turning right is positive);
/// elevations from the horizon, up positive.
struct Radians {
  double value = 0;

  constexpr Radians() = default;
  /// Radians from a plain number.
  constexpr explicit Radians(double radians) : value(radians) {}
  friend constexpr auto operator<=>(Radians, Radians) = default;
  friend constexpr Radians operator+(Radians a, Radians b) { return Radians(a.value + b.value); }
  friend constexpr Radians operator-(Radians a, Radians b) { return Radians(a.value - b.value); }
  friend constexpr Radians operator-(Radians a) { return Radians(-a.value); }
  friend constexpr Radians operator*(double k, Radians a) { return Radians(k * a.value); }
};

/// From degrees, and back to them.
constexpr Radians degrees(double degrees) { return Radians(degrees * (kPi / 180)); }
constexpr double to_degrees(Radians angle) { return angle.value * (180 / kPi); }

/// `90_deg`, `-8.5_deg` after `using namespace enfilade::literals`.
inline namespace literals {
constexpr Radians operator""_deg(long double value) { return degrees(static_cast<double>(value)); }
constexpr Radians operator""_deg(unsigned long long value) {
  return degrees(static_cast<double>(value));
}
}  // namespace literals

/// The same heading in [0, 2 pi], as MatterSim computes it: fmod, then additions of 2 pi while
/// negative. A negative angle closer to 0 than half a bit of 2 pi gives 2 pi itself.
inline Radians wrap_heading(Radians heading) {
  double h = heading.value;
  if (!(h > -2 * kPi && h < 2 * kPi)) h = std::fmod(h, 2 * kPi);
  return Radians(h < 0 ? h + 2 * kPi : h);
}

/// The same angle in (-pi, pi]: the shorter way to turn.
inline Radians wrap_difference(Radians angle) {
  const double a = std::remainder(angle.value, 2 * kPi);
  return Radians(a <= -kPi ? kPi : a);
}

}  // namespace enfilade
