// The reader of recorded traces: gzip or plain, JSON a line.
#include <cstddef>
#include <cstdint>

#include "enfilade/core/errors.h"
#include "tests/conformance/trace.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  const fuzz::MemoryFile file(data, size);
  try {
    tests::TraceReader reader(file.path());
    while (reader.next()) continue;
  } catch (const Error&) {
  }
  return 0;
}
