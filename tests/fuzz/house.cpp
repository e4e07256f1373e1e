// The reader of .house files; what is read, written and read again is equal.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/mesh/house.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const mesh::House house = mesh::parse_house(text, "<fuzz>");
    const std::string written = mesh::to_text(house);
    try {
      EN_CHECK(mesh::to_text(mesh::parse_house(written, "<written>")) == written);
    } catch (const InvalidInput&) {
      EN_CHECK(false);
    }
  } catch (const InvalidInput&) {
  }
  return 0;
}
