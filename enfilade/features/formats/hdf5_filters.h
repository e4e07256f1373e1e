/// \file  Filters that datasets of HDF5 files are packed with: h5py's LZF, and which the library
/// lacks. Internal, as it includes hdf5.h.
#pragma once
#include <hdf5.h>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace enfilade::features::formats {

/// Unpacks LZF as Marc Lehmann's liblzf writes it, h5py's "lzf".
/// \return number of bytes written; no value for damaged bytes, or more than `to` has room for
std::optional<std::size_t> unpack_lzf(std::span<const std::byte> packed, std::span<std::byte> to);

/// Lets the library read datasets that are packed with LZF. \pre an Hdf5Library is held
void register_lzf();

/// Refuses chunks that LZF unpacks to less than their size. N-bit and scale-offset shorten chunks
/// before LZF, so with them any size is right. Until the next call.
/// \param made  the dataset's creation properties \pre an Hdf5Library is held
void expect_chunks_of(hid_t made);

/// The first filter of a dataset that the library lacks, as "\"blosc\" (32001)".
/// \param made  the dataset's creation properties \pre an Hdf5Library is held
std::optional<std::string> missing_filter(hid_t made);

}  // namespace enfilade::features::formats
