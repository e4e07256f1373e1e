#include "enfilade/core/texts.h"

#include <charconv>

namespace enfilade {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string decode_percent(std::string_view text) {
  std::string decoded;
  for (std::size_t k = 0; k < text.size(); ++k) {
    unsigned char byte = 0;
    const std::string_view digits = text.substr(k + 1, 2);
    const char* const end = digits.data() + digits.size();
    if (text[k] == '%' && digits.size() == 2 &&
        std::from_chars(digits.data(), end, byte, 16).ptr == end) {
      decoded += static_cast<char>(byte);
      k += 2;
    } else {
      decoded += text[k];
    }
  }
  return decoded;
}

}  // namespace enfilade
