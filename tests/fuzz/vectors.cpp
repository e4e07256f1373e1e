// The reader of golden vectors, and what it compares them with.
#include <cstddef>
#include <cstdint>

#include "enfilade/core/errors.h"
#include "tests/conformance/vectors.h"
#include "tests/fuzz/fixture.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  static const auto kGraphs = fuzz::graphs();
  const fuzz::MemoryFile file(data, size);
  try {
    tests::check_vectors(file.path(), kGraphs, {});
  } catch (const Error&) {
  }
  return 0;
}
