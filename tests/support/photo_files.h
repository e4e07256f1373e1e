/// \file  JPEGs with the notes that cameras write: EXIF's orientation, and GPano's fields in XMP.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "enfilade/image/codecs.h"

namespace enfilade::tests {

inline std::string jpeg_of(const image::Image8& picture) {
  const auto bytes = image::encode_jpeg(picture, 95, true);
  return {bytes.begin(), bytes.end()};
}

/// A PNG of 16 x 8 pixels and 16 bits: no red, full green, half of the blue.
inline std::string colour_of_sixteen_bits() {
  return {
      "\211PNG\015\012\032\012\000\000\000\015IHDR\000\000\000\020\000\000\000\010\020\002"
      "\000\000\000\057\2044\203\000\000\000\030IDATx\332c\140\140\370\377\277\241\201\226"
      "\344\250\005\243\026\014z\013\000\240\365\177\020KK\277h\000\000\000\000IEND\256B"
      "\140\202",
      81};
}

/// With a segment APP1 behind the first marker.
inline std::string with_segment(const std::string& jpeg, const std::string& body) {
  const std::size_t size = body.size() + 2;
  std::string segment = "\xff\xe1";
  segment += static_cast<char>(size >> 8U);
  segment += static_cast<char>(size & 0xffU);
  return jpeg.substr(0, 2) + segment + body + jpeg.substr(2);
}

/// The body of EXIF with an orientation alone.
inline std::string exif(int orientation, bool big_endian = false) {
  const char value = static_cast<char>(orientation);
  std::string body("Exif\0\0", 6);
  if (big_endian) {
    body += std::string("MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", 19);
    body += value;
    return body + std::string(6, '\0');
  }
  body += std::string("II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0", 18);
  body += value;
  return body + std::string(7, '\0');
}

inline std::string with_orientation(const std::string& jpeg, int orientation,
                                    bool big_endian = false) {
  return with_segment(jpeg, exif(orientation, big_endian));
}

/// An XMP packet with fields of GPano, as attributes or as elements.
inline std::string gpano(const std::vector<std::pair<std::string, std::string>>& fields,
                         bool elements = false) {
  std::string attributes, inner;
  for (const auto& [name, value] : fields) {
    attributes += " GPano:" + name + "=\"" + value + "\"";
    inner += "<GPano:" + name + ">" + value + "</GPano:" + name + ">\n";
  }
  const std::string space = " xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\"";
  return "<x:xmpmeta><rdf:RDF><rdf:Description" + space + (elements ? "" : attributes) + ">" +
         (elements ? inner : "") + "</rdf:Description></rdf:RDF></x:xmpmeta>";
}

inline std::string with_xmp(const std::string& jpeg, const std::string& xmp) {
  return with_segment(jpeg, std::string("http://ns.adobe.com/xap/1.0/\0", 29) + xmp);
}

}  // namespace enfilade::tests
