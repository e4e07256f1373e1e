/// \file  Writing of small zip files, as NumPy's `.npz` are.
#pragma once
#include <span>
#include <string>

namespace enfilade::scan {

/// A file in a zip file.
struct ZipEntry {
  std::string name;  ///< with '/' between folders; unique, not empty, UTF-8, at most 65,535 bytes
  std::string content;
};

/// A zip file with these entries, in this order, each deflated. The same entries give the same
/// bytes: all times are 1980-01-01. FileTree::zip_in_memory() reads it.
/// \throws ArgumentError for an empty, repeated or too long name, more than 65,535 entries, and
/// more than 4 GiB (both need zip64)
std::string zip(std::span<const ZipEntry> entries);

}  // namespace enfilade::scan
