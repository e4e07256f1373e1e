/// \file  Proxies for HTTP, from the environment variables that curl and most clients read.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace enfilade {

/// A proxy that is spoken to in HTTP. Connections by HTTPS pass through it by CONNECT.
struct Proxy {
  std::string host;
  int port = 1080;              ///< as curl's default
  std::string user, password;   ///< decoded; empty: none
  std::string variable;         ///< the environment variable that names it
  std::string address() const;  ///< "proxy.lab:3128", without user and password
};

/// The value of an environment variable; null: not set.
using Environment = std::function<const char*(const char* name)>;

/// The proxy for an address: `https_proxy` or `http_proxy` by its scheme, else `all_proxy`, in
/// lower or upper case, the lower one first. `no_proxy` lists hosts without a proxy: names with all
/// names below them, addresses, ranges ("10.0.0.0/8"), each with or without a port; "*" is all.
/// This machine's own addresses (localhost, 127.0.0.0/8, ::1) never have one.
/// \param url  "https://api.example.org/v1"
/// \throws ArgumentError naming the variable, for a proxy that is not http://HOST:PORT. The message
/// has neither user nor password
std::optional<Proxy> proxy_for(std::string_view url);
/// The same for an environment of the caller's.
std::optional<Proxy> proxy_for(std::string_view url, const Environment& environment);

}  // namespace enfilade
