#include "enfilade/net/hosts.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace enfilade::net {
namespace EN_UNIT {

TEST(Addresses, AHomeOfIpv6IsOneAddress) {
  EXPECT_EQ(address_group("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
  EXPECT_EQ(address_group("2001:DB8:1:2::1"), address_group("2001:db8:1:2:ffff::"));
  EXPECT_NE(address_group("2001:db8:1:3::1"), address_group("2001:db8:1:2::1"));
}

TEST(Addresses, AnIpv4AddressIsItselfHoweverItIsWritten) {
  EXPECT_EQ(address_group("192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(address_group("::ffff:192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(address_group("::FFFF:c000:207"), "192.0.2.7");
}

TEST(Addresses, AreReadAsProxiesWriteThem) {
  for (const auto& [entry, address] : std::vector<std::pair<std::string, std::string>>{
           {"203.0.113.7", "203.0.113.7"},
           {" 203.0.113.7\t", "203.0.113.7"},
           {"203.0.113.7:51234", "203.0.113.7"},
           {"203.0.113.7:0", "203.0.113.7"},
           {"2001:db8::1", "2001:db8::1"},
           {"[2001:db8::1]", "2001:db8::1"},
           {"[2001:db8::1]:51234", "2001:db8::1"},
           {"\"[2001:db8::1]:51234\"", "2001:db8::1"},
           {"2001:db8::1:51234", "2001:db8::1"},
           {"2001:db8:1:2:3:4:5:6:80", "2001:db8:1:2:3:4:5:6"},
           {"::ffff:203.0.113.7", "::ffff:203.0.113.7"},
           {"::ffff:203.0.113.7:51234", "::ffff:203.0.113.7"},
           {"[::ffff:203.0.113.7]:51234", "::ffff:203.0.113.7"},
           {"fe80::1%eth0", "fe80::1"},
           {"[fe80::1%eth0]:80", "fe80::1"}}) {
    EXPECT_EQ(parse_address(entry), address) << entry;
  }
  for (const char* entry : {"",
                            " ",
                            "\"",
                            "unknown",
                            "_hidden",
                            "_gazonk:80",
                            "localhost",
                            "vln.example.org:80",
                            ":80",
                            "203.0.113",
                            "203.0.113.7.1",
                            "203.0.113.256",
                            "203.0.113.7:",
                            "203.0.113.7:x",
                            "203.0.113.7:70000",
                            "203.0.113.7:-1",
                            "203.0.113.7:80:81",
                            "203.0.113.7 x",
                            "1",
                            "[",
                            "[]",
                            "[]:80",
                            "[203.0.113.7]",
                            "[203.0.113.7]:80",
                            "[2001:db8::1",
                            "[2001:db8::1]80",
                            "[2001:db8::1]:",
                            "[2001:db8::1]:70000",
                            "2001:db8::1]",
                            "[[2001:db8::1]]",
                            "203.0.113.7%eth0",
                            "2001:db8:::x",
                            "for=203.0.113.7",
                            "203.0.113.7/24"}) {
    EXPECT_EQ(parse_address(entry), std::nullopt) << entry;
  }
}

TEST(Addresses, OfOneClientAreOneGroupWhateverTheyAreWrittenWith) {
  for (const char* address : {"192.0.2.7:51234", "192.0.2.7:51235", "[::ffff:192.0.2.7]:1"}) {
    EXPECT_EQ(address_group(address), "192.0.2.7");
  }
  for (const char* address :
       {"[2001:db8:1:2::1]:51234", "2001:db8:1:2::1:5123", "2001:db8:1:2::7"}) {
    EXPECT_EQ(address_group(address), "2001:db8:1:2::/64");
  }
  EXPECT_EQ(address_group("fe80::1%eth0"), address_group("fe80::2%eth1"));
}

TEST(Addresses, WhatIsNoAddressStaysAsItIs) {
  EXPECT_EQ(address_group("unknown"), "unknown");
  EXPECT_EQ(address_group(""), "");
}

}  // namespace EN_UNIT
}  // namespace enfilade::net
