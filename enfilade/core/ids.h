/// \file  Typed indices: of viewpoints, of scans.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace enfilade {

/// An index into the list that owns an object. The tag keeps the index of a viewpoint from being
/// used as that of a scan. Has the layout of a uint32_t, so that NumPy can use arrays of it
/// directly.
template <class Tag>
struct Index {
  std::uint32_t value = 0;

  constexpr Index() = default;
  /// \pre i fits 32 bits
  constexpr explicit Index(std::size_t i) : value(static_cast<std::uint32_t>(i)) {}

  /// For subscripts: `positions[v.at()]`.
  constexpr std::size_t at() const noexcept { return value; }
  friend constexpr auto operator<=>(Index, Index) = default;
};

/// A viewpoint of one scan: its index in the scan's connectivity file, excluded viewpoints included
/// (`ix` in MatterSim).
using ViewpointIndex = Index<struct ViewpointTag>;
/// A scan: its index in the GraphSet that it was opened with.
using ScanIndex = Index<struct ScanTag>;

}  // namespace enfilade

template <class Tag>
struct std::hash<enfilade::Index<Tag>> {
  std::size_t operator()(enfilade::Index<Tag> i) const noexcept { return i.value; }
};
