/// \file  Any bytes are features in a file, or refused; what is read is finite.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/features/feature_set.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {

/// \param name of the file, whose ending says what it is. TMPDIR=/dev/shm keeps it in memory.
inline void read_features(const std::string& name, const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder("fuzz_features");
  const std::filesystem::path file = folder.path() / name;
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const auto read = features::FeatureSet::open(file);
    std::vector<float> views(read.info().views * read.info().dimensions);
    for (std::size_t row = 0; row < read.keys().size(); ++row) read.copy_views(row, views);
  } catch (const InvalidInput&) {
  }
}

}  // namespace enfilade::tests
