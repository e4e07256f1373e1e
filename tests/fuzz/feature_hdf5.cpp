// Any bytes are datasets of features or refused.
#include "tests/fuzz/feature_file.h"

// The library asks for as much memory as a file says, takes no for an answer, and forgets some of
// the memory of files that it refuses. The names are the sanitizer's.
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" const char* __asan_default_options() { return "allocator_may_return_null=1"; }
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  enfilade::tests::read_features("f.h5", data, size);
  return 0;
}
