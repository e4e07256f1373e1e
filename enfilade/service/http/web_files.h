/// \file  What build steps put into the library: the files of the web client (web/README.md), and
/// the description of the API.
#pragma once
#include <span>
#include <string_view>

namespace enfilade::service::http {

/// A file of the bundle.
struct WebFile {
  std::string_view path;    ///< "/index.html", "/assets/viewer-3f2a.js"
  std::string_view type;    ///< media type
  std::string_view digest;  ///< of the content: its ETag
  std::string_view gzip;    ///< the content, compressed
};

/// Sorted by path; empty in a build without npm.
std::span<const WebFile> web_files();

extern const std::string_view kOpenApi;  ///< openapi.json

}  // namespace enfilade::service::http
