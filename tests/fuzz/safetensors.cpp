// Any bytes are a file of weights or refused; what is read, written and read again is equal.
// TMPDIR=/dev/shm keeps what is written in memory.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/features/tensor_file.h"
#include "tests/fuzz/memory_file.h"
#include "tests/support/temporary_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  using namespace enfilade::features;
  static const tests::TemporaryFolder folder("fuzz_safetensors");
  const std::filesystem::path written = folder.path() / "written";
  std::optional<TensorFile> read;
  const fuzz::MemoryFile file(data, size);
  try {
    read = TensorFile::open(file.path());
    for (const NamedArray& array : read->arrays()) {
      EN_CHECK_EQ(array.elements() * size_of(array.type), array.bytes.size());
    }
    if (size % 16 != 0) return 0;  // writing takes as long as a hundred readings
    write_safetensors(written, read->arrays(), read->metadata());
  } catch (const Error&) {  // names of a pickle's tensors may be no UTF-8, which JSON is
    return 0;
  }
  const TensorFile again = TensorFile::open(written);
  EN_CHECK(again.metadata() == read->metadata());
  EN_CHECK_EQ(again.arrays().size(), read->arrays().size());
  for (std::size_t i = 0; i < read->arrays().size(); ++i) {
    const NamedArray &a = read->arrays()[i], &b = again.arrays()[i];
    EN_CHECK_EQ(a.name, b.name);
    EN_CHECK(a.shape == b.shape && a.type == b.type && std::ranges::equal(a.bytes, b.bytes));
  }
  return 0;
}
