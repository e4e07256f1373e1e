#include "enfilade/net/hosts.h"

#include <gmock/gmock.h>
#include <unistd.h>
#include <array>

#include "enfilade/core/errors.h"
#include "tests/support/refusal.h"

namespace enfilade::net {
namespace EN_UNIT {

using ::testing::HasSubstr;

std::string parsed(std::string_view text) {
  const auto host = parse_host(text);
  return host ? host->name + " " + host->port : "none";
}

TEST(Hosts, ANameOrAnAddressAndAPort) {
  EXPECT_EQ(parsed("vln.example.org"), "vln.example.org ");
  EXPECT_EQ(parsed("VLN.Example.org.:8080"), "vln.example.org 8080");
  EXPECT_EQ(parsed("10.0.0.3:80"), "10.0.0.3 80");
  EXPECT_EQ(parsed("[::1]"), "[::1] ");
  EXPECT_EQ(parsed("[FE80::1]:8080"), "[fe80::1] 8080");
  EXPECT_EQ(parsed("gpu_7:"), "gpu_7 ");
}

TEST(Hosts, AnythingElseIsNone) {
  for (const std::string text :
       {"", ".", "a..", ":80", "a b", "a/b", "a@b", "a,b", "a:65536", "a:-1", "a:8x", "a:1:2",
        "::1", "[::1", "[x]", "[127.0.0.1]", "a\tb", "\xc3\xa9"}) {
    EXPECT_EQ(parsed(text), "none") << text;
  }
  EXPECT_EQ(parsed(std::string(254, 'a')), "none");
}

TEST(Hosts, AnOriginIsOfTheSameSiteByNameAndPort) {
  const auto same = [](const char* origin, const char* host) {
    return is_same_site(origin, *parse_host(host));
  };
  EXPECT_TRUE(same("http://a.org", "a.org"));
  EXPECT_TRUE(same("http://a.org", "A.org:80"));
  EXPECT_TRUE(same("https://a.org:443", "a.org"));
  EXPECT_TRUE(same("http://127.0.0.1:8080", "127.0.0.1:8080"));
  EXPECT_FALSE(same("http://a.org:8081", "a.org:8080"));
  EXPECT_FALSE(same("http://a.org", "a.org:8080"));
  EXPECT_FALSE(same("https://a.org", "a.org:80"));
  EXPECT_FALSE(same("http://b.org", "a.org"));
  EXPECT_FALSE(same("http://a.org.b.org", "a.org"));
  EXPECT_FALSE(same("http://b.org/a.org", "a.org"));
  EXPECT_FALSE(same("http://a.org@b.org", "a.org"));
  EXPECT_FALSE(same("ftp://a.org", "a.org"));
  EXPECT_FALSE(same("null", "a.org"));
  EXPECT_FALSE(same("", "a.org"));
}

TEST(Hosts, AServerKnowsAddressesLocalhostAndItsNames) {
  const OwnNames names("127.0.0.1", {"VLN.example.org"});
  const auto known = [&names](const char* host) { return names.contains(*parse_host(host)); };
  for (const char* host : {"127.0.0.1", "10.1.2.3:9", "[::1]:80", "localhost:8080", "Localhost.",
                           "vln.example.org", "vln.example.org:8443"}) {
    EXPECT_TRUE(known(host)) << host;
  }
  for (const char* host : {"evil.org", "evil.org:8080", "localhost.evil.org", "127.0.0.1.evil.org",
                           "vln.example.org.evil.org", "xvln.example.org", "example.org", "1"}) {
    EXPECT_FALSE(known(host)) << host;
  }
  EXPECT_TRUE(names.is_given("https://vln.example.org"));
  EXPECT_FALSE(names.is_given("https://127.0.0.1"));
}

TEST(Hosts, TheMachinesNameIsAServersIfOthersCanReachIt) {
  std::array<char, 256> text{};
  ASSERT_EQ(::gethostname(text.data(), text.size() - 1), 0);
  const auto machine = parse_host(text.data());
  if (!machine || machine->name == "localhost") GTEST_SKIP() << "this machine has no name";
  EXPECT_TRUE(OwnNames("0.0.0.0", {}).contains(*machine));
  EXPECT_TRUE(OwnNames("10.0.0.3", {}).contains(*machine));
  for (const char* own : {"127.0.0.1", "localhost", "::1"}) {
    EXPECT_FALSE(OwnNames(own, {}).contains(*machine)) << own;
  }
  EXPECT_TRUE(OwnNames("gpu7.lab", {}).contains(*parse_host("gpu7.lab:8080")));
}

TEST(Hosts, WhatIsNoNameIsRefused) {
  for (const char* name : {"", "https://vln.example.org", "vln.example.org:443", "a b"}) {
    EXPECT_THAT(tests::refusal<ArgumentError>([name] { const OwnNames names("::1", {name}); }),
                HasSubstr("public name: \""))
        << name;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::net
