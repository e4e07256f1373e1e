/// \file  Indices that cannot be mistaken for one another.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace enfilade {

/// Position of a thing in the list that owns it. Tag keeps a viewpoint's index from being used as
/// a scan's. Trivial and as wide as a uint32_t, so that arrays of it can be handed to NumPy as is.
template <class Tag>
struct Index {
  std::uint32_t value = 0;

  constexpr Index() = default;
  constexpr explicit Index(std::size_t i) : value(static_cast<std::uint32_t>(i)) {}

  /// For subscripts: `positions[v.at()]`.
  constexpr std::size_t at() const noexcept { return value; }
  friend constexpr auto operator<=>(Index, Index) = default;
};

/// A viewpoint of one scan: its place in the scan's connectivity file, excluded viewpoints counted
/// (the `ix` of MatterSim).
using ViewpointIndex = Index<struct ViewpointTag>;
/// A scan: its place in the GraphSet that it was opened with.
using ScanIndex = Index<struct ScanTag>;

}  // namespace enfilade

template <class Tag>
struct std::hash<enfilade::Index<Tag>> {
  std::size_t operator()(enfilade::Index<Tag> i) const noexcept { return i.value; }
};
