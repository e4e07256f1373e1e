// A request's head as a whole, and the texts in it: query, Host, Origin and X-Forwarded-For, a line
// each.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/net/connections/head.h"
#include "enfilade/net/hosts.h"
#include "enfilade/service/http/messages.h"

namespace {

using namespace enfilade;
namespace hosts = enfilade::net;

/// The lines of an input; those that are missing are empty.
std::array<std::string_view, 4> lines_of(std::string_view text) {
  std::array<std::string_view, 4> lines;
  for (std::string_view& line : lines) {
    const std::size_t end = text.find('\n');
    line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

/// The input as the bytes of a connection: its head is found at the same place however it arrives.
void read_head(std::string_view bytes) {
  try {
    net::connections::HeadEnd whole;
    const std::size_t end = whole.find(bytes);
    if (end == 0) return;
    net::connections::HeadEnd pieces;
    EN_CHECK(pieces.find(bytes.substr(0, end / 2)) == 0 && pieces.find(bytes) == end);
    const net::connections::Head head = net::connections::parse_head(bytes.substr(0, end));
    EN_CHECK(!head.request.method.empty() && !head.request.path.empty());
  } catch (const net::HttpError& error) {
    EN_CHECK(error.status() >= 400 && error.status() < 500);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const hosts::OwnNames kNames("127.0.0.1", {"vln.example.org"});
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  read_head(text);
  const auto [target, host, origin, forwarded] = lines_of(text);
  std::size_t bytes = 0;
  for (const auto& [name, value] : service::http::parse_query(target))
    bytes += name.size() + value.size();
  EN_CHECK(bytes <= target.size());  // nothing grows by being decoded
  if (const auto parsed = hosts::parse_host(host)) {
    const std::string whole =
        parsed->port.empty() ? parsed->name : parsed->name + ":" + parsed->port;
    const auto again = hosts::parse_host(whole);
    EN_CHECK(again.has_value() && again->name == parsed->name && again->port == parsed->port);
    const bool own = kNames.contains(*parsed);
    EN_CHECK(own || parsed->name != "vln.example.org");
    if (hosts::is_same_site(origin, *parsed)) {
      EN_CHECK(origin.size() >= parsed->name.size());
    }
    kNames.is_given(origin);
  }
  if (const auto address = hosts::parse_address(forwarded)) {
    EN_CHECK(hosts::parse_address(*address) == address);
    const std::string group = hosts::address_group(*address);
    EN_CHECK(hosts::address_group(forwarded) == group);
    EN_CHECK(hosts::address_group(group) == group);
  }
  return 0;
}
