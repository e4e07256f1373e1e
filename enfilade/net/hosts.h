/// \file  Addresses of clients as limits count them, and the server's own names in the headers Host
/// and Origin. They protect against pages of other names that resolve to this computer (DNS
/// rebinding).
#pragma once
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::net {

/// Content of a Host header: "vln.example.org", "10.0.0.3:8080", "[::1]:8080".
struct Host {
  std::string name;  ///< in lower case, without a dot at its end; IPv6 with the brackets
  std::string port;  ///< "" if none is written
};

/// None for a text of another form; names have letters, digits, ".", "-" and "_". Any thread.
std::optional<Host> parse_host(std::string_view text);

/// Whether a page of that Origin ("https://vln.example.org") is of the site that `host` names: the
/// same name and the same port, with the defaults 80 and 443. Any thread.
bool is_same_site(std::string_view origin, const Host& host);

/// The names of one server. Immutable: any thread may read it.
class OwnNames {
 public:
  /// \param interface  that the server listens on: an address or a name. If it is more than this
  /// machine's own, the name of the machine is one of the server's, alone and before ".local"
  /// \param given  names by which visitors reach it, "vln.example.org", without a port
  /// \throws ArgumentError for one of `given` that is no name
  OwnNames(const std::string& interface, const std::vector<std::string>& given);

  /// Whether a request for that host was meant for this server. It is one of its names,
  /// "localhost", or any address, as no other page's address can be resolved to it. The port does
  /// not matter: tunnels and containers change it.
  bool contains(const Host& host) const;
  /// Whether a page of that Origin is of one of the names that were given: behind a proxy, Host may
  /// be another.
  bool is_given(std::string_view origin) const;

 private:
  std::set<std::string, std::less<>> given_, machine_;
};

/// The address in an entry of X-Forwarded-For. Forms of proxies: "192.0.2.7", "192.0.2.7:51234",
/// "2001:db8::1", "[2001:db8::1]", "[2001:db8::1]:51234". There may be quotes and blanks around. A
/// port is left out, as it changes with each connection; so is a zone (fe80::1%eth0). No value for
/// other texts: "unknown", "_hidden", a name. Any thread.
std::optional<std::string> parse_address(std::string_view entry);

/// The address that limits count by. An IPv4 address, also one written as IPv6 (::ffff:1.2.3.4).
/// The first 64 bits of an IPv6 address, as a home or a lab has all addresses that begin with them.
/// A port, brackets and a zone do not count, as of parse_address(). Any other text is returned
/// unchanged. Any thread.
std::string address_group(std::string_view address);

}  // namespace enfilade::net
