// Any bytes are a picture or refused; a picture can be shown.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/image/codecs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  // Four digits a side are plenty: larger pictures are only slower.
  std::size_t digits = 0;
  for (const char c : text.substr(0, text.find("\n\n") + 64)) {
    digits = std::isdigit(static_cast<unsigned char>(c)) != 0 ? digits + 1 : 0;
    if (digits > 4) return 0;
  }
  try {
    const image::ImageF picture = image::decode_hdr(image::bytes_of(text), "<fuzz>");
    EN_CHECK(std::ranges::none_of(picture.pixels, [](float x) { return std::isnan(x) || x < 0; }));
    if (picture.pixels.size() < 1U << 20U) {
      EN_CHECK_EQ(image::tone_map(picture).pixels.size(), picture.pixels.size());
    }
  } catch (const InvalidInput&) {
  }
  return 0;
}
