// Any bytes are rows of features or refused; what is read is finite. TMPDIR=/dev/shm keeps the
// file, whose name says what it is, in memory.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include "enfilade/agents/neural/feature_set.h"
#include "enfilade/core/errors.h"
#include "tests/support/temporary_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  using namespace enfilade::agents::neural;
  static const tests::TemporaryFolder folder("fuzz_feature_tsv");
  const std::filesystem::path file = folder.path() / "f.tsv";
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const FeatureSet read = FeatureSet::open(file);
    std::vector<float> views(read.info().views * read.info().dimensions);
    for (std::size_t row = 0; row < read.keys().size(); ++row) read.copy_views(row, views);
  } catch (const InvalidInput&) {
  }
  return 0;
}
