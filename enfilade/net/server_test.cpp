#include "enfilade/net/server.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
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
    if (request.path == "/number") throw 7;  // no std::exception
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
       head("POST /four", kChunked) + "2\r\nab\r\n1 \t;x=y\r\nc\r\n0 \r\nTrailer: 1\r\n\r\n",
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
        chunked + "5\nhello\r\n", chunked + "g\r\n", chunked + "5 garbage\r\nhello\r\n",
        chunked + "5;a\rb\r\nhello\r\n", chunked + std::string("5;\0\r\nhello\r\n", 12)}) {
    const auto began = Clock::now();
    EXPECT_THAT(exchange(server.port(), {text}, 0), StartsWith("HTTP/1.1 400 Bad Request\r\n"))
        << text;
    EXPECT_LT(Clock::now() - began, std::chrono::seconds(1)) << text;
  }
}

TEST(Server, AnExceptionIsNotTold) {
  const Server server(echo());
  for (const char* path : {"GET /fail", "GET /number"}) {
    const std::string response = exchange(server.port(), {head(path, kClose)}, 0);
    EXPECT_THAT(response, StartsWith("HTTP/1.1 500"));
    EXPECT_THAT(response, Not(HasSubstr("secret")));
  }
}

TEST(Server, ARefusalThatFailsEndsItsConnectionOnly) {
  ServerConfig config = echo();
  config.refuse = [](const HttpError&) -> Response { throw ArgumentError("no text for it"); };
  const Server server(config);
  for (const std::string& text : {head("GET /fail"), std::string("no request\r\n\r\n")}) {
    EXPECT_EQ(exchange(server.port(), {text}, 0), "");
  }
  EXPECT_THAT(exchange(server.port(), {head("GET /", kClose)}, 0), HasSubstr("[GET / ]"));
}

TEST(Server, TellsWhatItRefuses) {
  std::mutex mutex;
  std::vector<std::string> told;
  ServerConfig config = echo(0.3);
  config.refused = [&](const Request& request, const Response& response) {
    const std::scoped_lock lock(mutex);
    told.push_back(
        fmt::format("{} {} {} {}", request.address, request.method, request.path, response.status));
  };
  Server server(config);
  const std::string whole = exchange(server.port(), {head("HEAD /one") + "GET / HT"}, 0);
  EXPECT_THAT(whole, HasSubstr("HTTP/1.1 408"));
  exchange(server.port(), {head("POST /two", "Content-Length: 9\r\n")}, 0);
  exchange(server.port(), {head("GET /fail", kClose)}, 0);  // refused by `answer`
  server.stop();
  EXPECT_THAT(told, ::testing::ElementsAre("127.0.0.1   408", "127.0.0.1 POST /two 408"));
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
  std::promise<void> begun, end;
  std::once_flag once;
  const auto ended = end.get_future().share();
  ServerConfig config = echo();
  config.threads = 1;
  config.answer = [&, ended](const Request&, const BodyReader&) {
    std::call_once(once, [&begun] { begun.set_value(); });
    ended.wait();
    return Response{};
  };
  Server server(config);
  {
    const tests::HalfSent first(server.port(), 1, head("GET /"));
    begun.get_future().wait();  // it has the thread
    const tests::HalfSent others(server.port(), 512, head("GET /"));
    double seconds = 0;
    EXPECT_THAT(tests::timed_get(server.port(), "/", seconds), StartsWith("HTTP/1.1 503"));
    EXPECT_LT(seconds, 3);
    const std::string refused = exchange(server.port(), {head("HEAD /")}, 0);
    EXPECT_THAT(refused, StartsWith("HTTP/1.1 503"));
    EXPECT_THAT(refused, ::testing::EndsWith("\r\n\r\n"));  // no body
  }
  end.set_value();
  std::string last;
  const auto latest = Clock::now() + std::chrono::seconds(10);
  do {  // until the thread has taken one of those that wait
    double seconds = 0;
    last = tests::timed_get(server.port(), "/", seconds);
  } while (last.starts_with("HTTP/1.1 503") && Clock::now() < latest);
  EXPECT_THAT(last, StartsWith("HTTP/1.1 200"));
}

// Of 400 descriptors 100 are left for files, and the threads may have 200 connections.
TEST(Server, ThreadsTakeNoDescriptorsOfFiles) {
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  rlimit few = before;
  few.rlim_cur = 400;
  ::setrlimit(RLIMIT_NOFILE, &few);
  ServerConfig config = echo();
  config.threads = 200;
  const Server server(config);
  ::setrlimit(RLIMIT_NOFILE, &before);
  const tests::HalfSent others(server.port(), 110, "GET / HT");
  double seconds = 0;
  EXPECT_THAT(tests::timed_get(server.port(), "/", seconds), HasSubstr("[GET / ]"));
  char byte = 0;
  EXPECT_EQ(::recv(others.socket(0), &byte, 1, MSG_DONTWAIT), 0);     // closed
  EXPECT_EQ(::recv(others.socket(109), &byte, 1, MSG_DONTWAIT), -1);  // not yet
}

TEST(Server, StopsWhileClientsStillSend) {
  Server server(echo());
  const tests::HalfSent others(server.port(), 5, "GET / HT");
  const auto began = Clock::now();
  server.stop();
  EXPECT_LT(Clock::now() - began, std::chrono::seconds(1));
}

TEST(Server, StopsWhileAClientTakesItsResponseSlowly) {
  ServerConfig config = echo();
  config.stop_seconds = 0.2;
  std::promise<void> begun;
  config.answer = [&begun](const Request&, const BodyReader&) {
    Response response;
    response.body = std::make_shared<const std::string>(std::size_t{64} << 20U, 'x');
    begun.set_value();
    return response;
  };
  Server server(config);
  const tests::HalfSent client(server.port(), 1, head("GET /"));
  begun.get_future().wait();
  std::atomic<bool> over = false;
  std::jthread reads([&] {
    std::string piece(100'000, ' ');
    for (int k = 0; k < 400 && !over; ++k) {  // 20 s
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      (void)::recv(client.socket(0), piece.data(), piece.size(), MSG_DONTWAIT);
    }
  });
  const auto began = Clock::now();
  server.stop();
  EXPECT_LT(Clock::now() - began, std::chrono::seconds(5));
  over = true;
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
