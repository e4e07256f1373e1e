// The region map's reader.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/errors.h"
#include "enfilade/scan/regions.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const scan::RegionMap map = scan::RegionMap::parse(text, "<fuzz>");
    for (const std::string& scan : map.scans()) map.find(scan, scan);
  } catch (const Error&) {
  }
  return 0;
}
