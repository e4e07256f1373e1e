#include "enfilade/net/connections/head.h"

#include <gmock/gmock.h>
#include <string>
#include <utility>
#include <vector>

namespace enfilade::net::connections {
namespace EN_UNIT {

/// What is wrong with a head, or "good".
std::string fault_of(const std::string& text) {
  try {
    HeadEnd end;
    const std::size_t size = end.find(text);
    if (size != text.size()) return size == 0 ? "no end" : "ends early";
    parse_head(text);
  } catch (const HttpError& error) {
    return std::to_string(error.status()) + " " + error.what();
  }
  return "good";
}

TEST(Head, HasMethodPathAndHeaders) {
  const Head head = parse_head(
      "GET /a%20b/c?x=%20#part HTTP/1.1\r\nHOST: localhost\r\nX-Name:\t one \r\nx-name: two\r\n"
      "Cookie: a=1\r\nCookie: b=2\r\nEmpty:\r\n\r\n");
  EXPECT_EQ(head.request.method, "GET");
  EXPECT_EQ(head.request.target, "/a%20b/c?x=%20");
  EXPECT_EQ(head.request.path, "/a b/c");
  EXPECT_EQ(head.request.header("x-name"), "one, two");
  EXPECT_EQ(head.request.header("cookie"), "a=1; b=2");
  EXPECT_TRUE(head.request.headers.contains("empty"));
  EXPECT_FALSE(head.has_body());
  EXPECT_FALSE(head.closes);
}

TEST(Head, SaysHowTheRequestEnds) {
  const auto of = [](const std::string& more) {
    return parse_head("POST / HTTP/1.1\r\nHost: a\r\n" + more + "\r\n");
  };
  EXPECT_EQ(of("Content-Length: 12\r\n").length, 12U);
  EXPECT_TRUE(of("Transfer-Encoding: Chunked\r\n").chunked);
  EXPECT_TRUE(of("Expect: 100-continue\r\nContent-Length: 1\r\n").waits);
  EXPECT_FALSE(of("Expect: 100-continue\r\n").waits);
  EXPECT_TRUE(of("Connection: Keep-Alive, Close\r\n").closes);
  EXPECT_TRUE(parse_head("GET / HTTP/1.0\r\n\r\n").closes);
  const Head only = parse_head("HEAD / HTTP/1.1\r\nHost: a\r\n\r\n");
  EXPECT_TRUE(only.head_only);
  EXPECT_EQ(only.request.method, "GET");
}

TEST(Head, WhatIsUnclearIsRefused) {
  const std::string get = "GET / HTTP/1.1\r\n", post = "POST / HTTP/1.1\r\nHost: a\r\n";
  const std::string host = "Host: a\r\n";
  const std::vector<std::pair<std::string, std::string>> heads{
      {get + host, "good"},
      {"GET / HTTP/1.0\r\n", "good"},
      {get, "400 Host: must be there, once"},
      {get + "Host:\r\n", "400 Host: must be there, once"},
      {get + host + host, "400 Host: must be there, once"},
      {get + host + "A: b\r\n c\r\n", "400 a header goes on in a second line"},
      {get + host + "A : b\r\n", "400 a line of the head is no header"},
      {get + host + "A\r\n", "400 a line of the head is no header"},
      {get + host + ": b\r\n", "400 a line of the head is no header"},
      {get + host + std::string("A: b\0\r\n", 7), "400 a header has a control character"},
      {get + host + "A: b\n", "400 a line of the head does not end with CR LF"},
      {get + host + "A: b\rc\r\n", "400 a line of the head does not end with CR LF"},
      {"GET / HTTP/1.1\n" + host, "400 a line of the head does not end with CR LF"},
      {"GET / HTTP/2.0\r\n" + host, "400 HTTP/1.1 and HTTP/1.0 are known"},
      {"GET /\r\n" + host, "400 this is no request of HTTP"},
      {"GET  / HTTP/1.1\r\n" + host, "400 this is no path"},
      {"GET http://a/ HTTP/1.1\r\n" + host, "400 this is no path"},
      {"GET /%00 HTTP/1.1\r\n" + host, "400 the path has a control character"},
      {"FOO / HTTP/1.1\r\n" + host, "400 no such method"},
      {"GET /" + std::string(3000, 'a') + " HTTP/1.1\r\n" + host, "414 the path is too long"},
      {post + "Content-Length: -1\r\n", "400 it is not clear where this request ends"},
      {post + "Content-Length: 3, 3\r\n", "400 it is not clear where this request ends"},
      {post + "Content-Length: 3\r\nContent-Length: 3\r\n",
       "400 it is not clear where this request ends"},
      {post + "Content-Length: 3\r\nTransfer-Encoding: chunked\r\n",
       "400 it is not clear where this request ends"},
      {post + "Transfer-Encoding: gzip, chunked\r\n",
       "400 it is not clear where this request ends"},
      {get + host + "Content-Length: 3\r\n", "400 it is not clear where this request ends"}};
  for (const auto& [text, fault] : heads) EXPECT_EQ(fault_of(text + "\r\n"), fault) << text;
  EXPECT_EQ(fault_of("\r\n"), "400 this is no request of HTTP");
}

TEST(Head, IsLimited) {
  const std::string get = "GET / HTTP/1.1\r\nHost: a\r\n";
  EXPECT_EQ(fault_of(std::string(8193, 'a')), "414 the path is too long");
  EXPECT_EQ(fault_of(get + "A: " + std::string(8192, 'a')), "400 a line of the head is too long");
  std::string lines, large;
  for (int k = 0; k < 200; ++k) lines += "A: b\r\n";
  for (int k = 0; k < 9; ++k) large += "A: " + std::string(8000, 'a') + "\r\n";
  EXPECT_EQ(fault_of(get + lines), "400 the head has too many lines");
  EXPECT_EQ(fault_of(get + large), "400 the head is too long");
}

TEST(Head, EndsWhereItEndsHoweverItArrives) {
  const std::string text = "GET / HTTP/1.1\r\nHost: a\r\n\r\nGET /next";
  HeadEnd end;
  for (std::size_t size = 1; size < text.size() - 9; ++size) {
    EXPECT_EQ(end.find(std::string_view(text).substr(0, size)), 0U) << size;
  }
  EXPECT_EQ(end.find(text), text.size() - 9);
}

}  // namespace EN_UNIT
}  // namespace enfilade::net::connections
