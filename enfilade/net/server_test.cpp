#include "enfilade/net/server.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <chrono>
#include <future>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/core/gzip.h"
#include "tests/support/raw_socket.h"
#include "tests/support/refusal.h"

namespace enfilade::net {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using tests::exchange;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMost = 100'000;

/// Answers with what it was asked.
ServerConfig echo(double body_seconds = 30) {
  ServerConfig config;
  config.most_body_bytes = kMost;
  config.body_seconds = body_seconds;
  config.answer = [](const Request& request, const BodyReader& read_body) {
    if (request.path == "/fail") throw ArgumentError("a secret");
    Response response;
    response.type = "text/plain";
    const std::string body = read_body && request.path != "/unread" ? read_body(kMost) : "";
    response.body = std::make_shared<const std::string>(
        fmt::format("[{} {} {}]", request.method, request.path,
                    body.size() > 100 ? std::to_string(body.size()) : body));
    return response;
  };
  config.refuse = [](const HttpError& error) {
    Response response;
    response.status = error.status();
    response.body = std::make_shared<const std::string>(error.what());
    return response;
  };
  return config;
}

std::string head(const std::string& line, const std::string& more = "") {
  return line + " HTTP/1.1\r\nHost: localhost\r\n" + more + "\r\n";
}

const std::string kChunked = "Transfer-Encoding: chunked\r\n";
const std::string kClose = "Connection: close\r\n";

TEST(Server, AnswersOneRequestAfterTheOther) {
  const Server server(echo());
  const std::string responses = exchange(
      server.port(),
      {head("GET /one") + head("POST /two", "Content-Length: 3\r\n") + "abc" + head("HEAD /three"),
       head("POST /four", kChunked) + "2\r\nab\r\n1;x=y\r\nc\r\n0\r\nTrailer: 1\r\n\r\n",
       head("POST /unread", "Content-Length: 3\r\n") + "abc", head("GET /five", kClose),
       head("GET /never")},
      20);
  for (const char* part : {"[GET /one ]", "[POST /two abc]", "Content-Length: 13\r\n\r\nHTTP/1.1",
                           "[POST /four abc]", "[POST /unread ]", "[GET /five ]"}) {
    EXPECT_THAT(responses, HasSubstr(part));
  }
  EXPECT_THAT(responses, Not(HasSubstr("never")));
}

TEST(Server, ReadsBodiesWithinItsLimits) {
  const Server server(echo());
  const auto post = [&](const std::string& more, const std::string& body) {
    return exchange(server.port(), {head("POST /", kClose + more) + body}, 0);
  };
  const auto length = [](std::size_t size) { return fmt::format("Content-Length: {}\r\n", size); };
  const std::string large(kMost, 'x'), packed = gzip(std::string(20'000, 'x'), 9);
  EXPECT_THAT(post(length(kMost), large), HasSubstr("[POST / 100000]"));
  EXPECT_THAT(post(length(kMost + 1), large), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(post(kChunked, fmt::format("{:x}\r\n{}\r\n0\r\n\r\n", kMost, large)),
              HasSubstr("[POST / 100000]"));
  EXPECT_THAT(post(kChunked, fmt::format("{:x}\r\n{}x\r\n0\r\n\r\n", kMost + 1, large)),
              StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(post(length(packed.size()) + "Content-Encoding: gzip\r\n", packed),
              HasSubstr("[POST / 20000]"));
  const std::string bomb = gzip(std::string(kMost, ' '), 9);
  EXPECT_THAT(post(length(bomb.size()) + "Content-Encoding: gzip\r\n", bomb),
              StartsWith("HTTP/1.1 413"));
  // The client sends its body after a word of the server.
  const std::string waited = exchange(
      server.port(), {head("POST /", kClose + "Expect: 100-continue\r\n" + length(3)), "abc"}, 50);
  EXPECT_THAT(waited, StartsWith("HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 200 OK"));
  EXPECT_THAT(waited, HasSubstr("[POST / abc]"));
}

TEST(Server, RefusesWhatIsNoHttpAtOnce) {
  const Server server(echo());
  const std::string chunked = head("POST /", kChunked);
  for (const std::string& text :
       {std::string("GET / HTTP/1.1\r\n\r\n"), std::string("GET / HTTP/1.1\nHost: a\n\n"),
        head("GET /", "A: b\r\n c\r\n"), std::string("\x16\x03\x01\x02\n"),
        head("POST /", "Content-Length: -5\r\n"), chunked + "-5\r\n", chunked + "0x5\r\nhello\r\n",
        chunked + "\r\n", chunked + "fffffffff\r\n", chunked + "2\r\nabc\r\n",
        chunked + "5\nhello\r\n", chunked + "g\r\n"}) {
    const auto began = Clock::now();
    EXPECT_THAT(exchange(server.port(), {text}, 0), StartsWith("HTTP/1.1 400 Bad Request\r\n"))
        << text;
    EXPECT_LT(Clock::now() - began, std::chrono::seconds(1)) << text;
  }
}

TEST(Server, AnExceptionIsNotTold) {
  const Server server(echo());
  const std::string response = exchange(server.port(), {head("GET /fail", kClose)}, 0);
  EXPECT_THAT(response, StartsWith("HTTP/1.1 500"));
  EXPECT_THAT(response, Not(HasSubstr("secret")));
}

// Each would hold a thread, were it given one before it is whole.
TEST(Server, HalfSentRequestsLeaveThreadsForOthers) {
  const Server server(echo());
  for (const std::string& text :
       {std::string("GET / HT"), std::string("GET / HTTP/1.1\r\nHost: a\r\n"),
        head("POST /", "Content-Length: 100\r\n") + "{",
        head("POST /", "Content-Length: 99000\r\n") + "{", head("POST /", kChunked) + "5\r\nab",
        head("POST /", "Expect: 100-continue\r\nContent-Length: 9\r\n")}) {
    const tests::HalfSent others(server.port(), 600, text);
    double seconds = 0;
    EXPECT_THAT(tests::timed_get(server.port(), "/healthz", seconds), HasSubstr("[GET /healthz ]"));
    EXPECT_LT(seconds, 1) << text;
  }
}

TEST(Server, WhatTakesTooLongEnds) {
  const Server server(echo(0.3));
  const auto slow = [&](std::string first) {
    std::vector<std::string> pieces{std::move(first)};
    pieces.resize(20, "x");
    return exchange(server.port(), pieces, 50);
  };
  EXPECT_THAT(slow("GET /"), StartsWith("HTTP/1.1 408"));
  EXPECT_THAT(slow(head("POST /", "Content-Length: 1000\r\n")), StartsWith("HTTP/1.1 408"));
  EXPECT_THAT(slow(head("POST /", "Content-Length: 20000\r\n")), StartsWith("HTTP/1.1 408"));
  EXPECT_THAT(slow(head("POST /", kChunked) + "ff\r\n"), StartsWith("HTTP/1.1 408"));
}

TEST(Server, TheConnectionThatWaitsLongestGoesWhenThereAreTooMany) {
  const Server server(echo());
  const tests::HalfSent others(server.port(), 1030, "GET / HT");
  double seconds = 0;
  EXPECT_THAT(tests::timed_get(server.port(), "/", seconds), HasSubstr("[GET / ]"));
  char byte = 0;
  EXPECT_EQ(::recv(others.socket(0), &byte, 1, MSG_DONTWAIT), 0);      // closed
  EXPECT_EQ(::recv(others.socket(1029), &byte, 1, MSG_DONTWAIT), -1);  // not yet
}

TEST(Server, WholeRequestsBeyondTheRoomAreRefused) {
  std::promise<void> end;
  const auto ended = end.get_future().share();
  ServerConfig config = echo();
  config.threads = 1;
  config.answer = [ended](const Request&, const BodyReader&) {
    ended.wait();
    return Response{};
  };
  Server server(config);
  {
    // One has the thread, 512 wait.
    const tests::HalfSent others(server.port(), 513, head("GET /"));
    double seconds = 0;
    EXPECT_THAT(tests::timed_get(server.port(), "/", seconds), StartsWith("HTTP/1.1 503"));
    EXPECT_LT(seconds, 3);  // of which 2 are for what a refused client still sends
  }
  end.set_value();
  double seconds = 0;
  EXPECT_THAT(tests::timed_get(server.port(), "/", seconds), StartsWith("HTTP/1.1 200"));
}

TEST(Server, StopsWhileClientsStillSend) {
  Server server(echo());
  const tests::HalfSent others(server.port(), 5, "GET / HT");
  const auto began = Clock::now();
  server.stop();
  EXPECT_LT(Clock::now() - began, std::chrono::seconds(1));
}

TEST(Server, APortBelongsToOneServer) {
  const Server server(echo());
  ServerConfig config = echo();
  config.port = server.port();
  EXPECT_THAT(tests::refusal<ArgumentError>([&config] { const Server second(config); }),
              HasSubstr("cannot listen there"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::net
