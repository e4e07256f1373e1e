/// \file  Filling the holes of depth pictures by their colour's brightness.
#pragma once
#include <cstdint>
#include <span>

namespace enfilade::python::mattersim {

/// A cross-bilateral filter on a pyramid of three sizes, as the toolbox of the NYU Depth data set
/// (Silberman, Hoiem, Kohli, Fergus, ECCV 2012) fills holes: a missing pixel becomes the mean of
/// the known ones within 5 pixels, weighed by nearness in place and in brightness; where there are
/// none, what the next smaller size found. All pictures are height x width, *column after column*.
/// \param missing not 0 where `depth` is a hole  \param result may be `depth`
/// \pre all spans have height * width elements
void fill_holes(std::uint32_t height, std::uint32_t width, std::span<const std::uint8_t> depth,
                std::span<const std::uint8_t> brightness, std::span<const std::uint8_t> missing,
                std::span<std::uint8_t> result);

}  // namespace enfilade::python::mattersim
