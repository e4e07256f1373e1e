#include "enfilade/net/connections/response_text.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace enfilade::net::connections {
namespace {

constexpr std::array<std::pair<int, std::string_view>, 22> kReasons{
    {{200, "OK"},
     {201, "Created"},
     {202, "Accepted"},
     {204, "No Content"},
     {302, "Found"},
     {303, "See Other"},
     {304, "Not Modified"},
     {400, "Bad Request"},
     {401, "Unauthorized"},
     {403, "Forbidden"},
     {404, "Not Found"},
     {405, "Method Not Allowed"},
     {408, "Request Timeout"},
     {409, "Conflict"},
     {413, "Payload Too Large"},
     {414, "URI Too Long"},
     {415, "Unsupported Media Type"},
     {421, "Misdirected Request"},
     {422, "Unprocessable Entity"},
     {429, "Too Many Requests"},
     {500, "Internal Server Error"},
     {503, "Service Unavailable"}}};

}  // namespace

std::string head_text(const Response& response, After after) {
  const auto* reason =
      std::ranges::find(kReasons, response.status, &std::pair<int, std::string_view>::first);
  std::string text = fmt::format("HTTP/1.1 {} {}\r\n", response.status,
                                 reason == kReasons.end() ? "Status" : reason->second);
  if (may_have_content(response.status)) {
    if (!response.body->empty()) text += "Content-Type: " + response.type + "\r\n";
    text += fmt::format("Content-Length: {}\r\n", response.body->size());
  }
  if (after == After::kCloses) text += "Connection: close\r\n";
  for (const auto& [name, value] : response.headers) {
    const std::string line = name + ": " + value;
    if (line.find_first_of("\r\n") == std::string::npos) text += line + "\r\n";
  }
  return text + "\r\n";
}

}  // namespace enfilade::net::connections
