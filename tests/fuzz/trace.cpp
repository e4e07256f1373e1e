// The reader of recorded traces: gzip or plain, JSON a line.
#include <sys/mman.h>
#include <unistd.h>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

#include "apps/replay_mattersim/trace.h"
#include "enfilade/core/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  // The reader takes a path: a file in memory has one.
  const int file = memfd_create("trace", 0);
  EN_CHECK(file >= 0);
  EN_CHECK(write(file, data, size) == static_cast<ssize_t>(size));
  try {
    apps::TraceReader reader("/proc/self/fd/" + std::to_string(file));
    while (reader.next()) continue;
  } catch (const Error&) {
  }
  close(file);
  return 0;
}
