// Any bytes are what torch.save() wrote or refused, and each array has the bytes of its shape. They
// are tried as a file, and behind the start that such a file without an archive has.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/features/tensor_file.h"
#include "tests/fuzz/memory_file.h"

namespace {

void read(const std::string& bytes) {
  using namespace enfilade;
  using namespace enfilade::features;
  try {
    const fuzz::MemoryFile file(bytes);
    const TensorFile weights = TensorFile::open(file.path());
    for (const NamedArray& array : weights.arrays()) {
      EN_CHECK_EQ(array.elements() * size_of(array.type), array.bytes.size());
      std::size_t sum = 0;
      for (const std::byte byte : array.bytes) sum += std::to_integer<std::size_t>(byte);
      EN_CHECK_LE(sum, 255 * array.bytes.size());
    }
  } catch (const Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  read(bytes);
  // The magic number, the version 1001, {"little_endian": True}.
  constexpr std::string_view kStart(
      "\x80\x02\x8a\nl\xfc\x9c"
      "F\xf9 j\xa8P\x19.\x80\x02M\xe9\x03.\x80\x02}U\rlittle_endian\x88s.",
      42);
  read(std::string(kStart) + bytes);
  return 0;
}
