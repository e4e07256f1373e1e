// Any bytes are rows of features or refused.
#include "tests/fuzz/feature_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  enfilade::tests::read_features("f.tsv", data, size);
  return 0;
}
