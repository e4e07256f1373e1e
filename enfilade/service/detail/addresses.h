/// \file  Addresses of clients as limits count them.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::service::detail {

/// What limits count as one address: an IPv4 address, also one written as IPv6 (::ffff:1.2.3.4);
/// the first 64 bits of an IPv6 address, as a home or a lab is given all addresses that begin with
/// them. A text that is no address is returned as it is. Any thread.
std::string address_group(std::string_view address);

}  // namespace enfilade::service::detail
