// Servers that are broken or evil: what a run makes of them, how long it takes, how much memory,
// and that the key is in none of its files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/arena/ask.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "tests/arena/evil_server.h"
#include "tests/support/base64_text.h"
#include "tests/support/grid_world.h"
#include "tests/support/memory.h"
#include "tests/support/refusal.h"
#include "tests/support/run_ends.h"
#include "tests/support/temporary_folder.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define EN_TEST_SANITIZED 1
#else
#define EN_TEST_SANITIZED 0
#endif

namespace enfilade::tests {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kMega = 1U << 20U;
constexpr double kLong = 60;    // seconds, for a limit that is met long before
constexpr double kShort = 0.2;  // for those that never answer
const std::string kKey = "sk-\"secret/1";
const std::string kLate = "no whole answer in 0.2 s";
const std::string kLarge = "an answer of more than 16 MiB";
const std::string kLine = "a first line of more than 2 KiB";
const std::string kHead = "a head of more than 64 KiB";
const std::string kDone = "all episodes are done";
const std::string kNoAnswer = "no answer in 2 attempts";  // how it is told is cpp-httplib's affair
constexpr std::string_view kOk = "HTTP/1.1 200 OK\r\nConnection: close\r\n";
constexpr std::string_view kChunks = "Transfer-Encoding: chunked\r\n\r\n";
constexpr std::string_view kEvents = "Content-Type: text/event-stream\r\n\r\n";

/// A server, and what a run of three episodes says about it.
struct Row {
  std::string name;
  EvilServer::Answer answer;
  std::string says = {};   // of each episode, or of the run
  std::string shown = {};  // is in the transcripts
  double timeout = kLong;  // seconds
};

EvilServer::Answer sends(std::string bytes) {
  return [bytes = std::move(bytes)](const Connection& to) { to.send(bytes); };
}
EvilServer::Answer answers(std::string_view body) { return sends(response(body)); }
/// And does nothing more until the client goes.
EvilServer::Answer sends_and_waits(std::string bytes) {
  return [bytes = std::move(bytes)](const Connection& to) {
    to.send(bytes);
    to.wait();
  };
}
EvilServer::Answer repeats(std::string first, std::string bytes, int pause_ms = 0) {
  return [first = std::move(first), bytes = std::move(bytes), pause_ms](const Connection& to) {
    if (to.send(first)) to.send_forever(bytes, pause_ms);
  };
}
std::string ok(std::string_view rest) { return std::string(kOk).append(rest); }
std::string events(std::string_view rest) { return ok(kEvents).append(rest); }
std::string quoted(const std::string& text) { return "\"" + text + "\""; }
std::string message(const std::string& fields) {
  return R"({"choices":[{"message":)" + fields + "}]}";
}
std::string arguments(const std::string& json) {
  return message(R"({"tool_calls":[{"id":"c","function":{"name":"go_to","arguments":)" + json +
                 "}}]}");
}
/// `count` times "prefix NUMBER suffix", with commas between.
std::string numbered(const std::string& prefix, const std::string& suffix, std::size_t count) {
  std::string text;
  for (std::size_t k = 0; k < count; ++k) {
    text += (k == 0 ? "" : ",") + prefix + std::to_string(k) + suffix;
  }
  return text;
}

std::vector<Row> bodies() {
  const std::string blanks = gzip(std::string(100 * kMega, ' '), 9);
  const std::string packed = "Content-Encoding: gzip\r\n";
  // Blocks of a deflated text that have nothing in them.
  const std::string nothing("\0\0\0\xff\xff", 5);
  return {
      {"a body without an end", repeats(ok("\r\n"), " "), kLarge},
      {"a length of 1.5 GB, and more", repeats(ok("Content-Length: 1500000000\r\n\r\n"), " "),
       kLarge},
      {"a length of 1.5 GB, and nothing", sends_and_waits(ok("Content-Length: 1500000000\r\n\r\n")),
       kLate, "", kShort},
      {"a length that is too small", sends(ok("Content-Length: 9\r\n\r\n") + stop_answer()),
       "no JSON object"},
      {"a length that is too large", sends(ok("Content-Length: 9999\r\n\r\n") + stop_answer()),
       kNoAnswer},
      {"a negative length", sends(ok("Content-Length: -1\r\n\r\n") + stop_answer()), kNoAnswer},
      {"a length in words", sends(ok("Content-Length: all\r\n\r\n") + stop_answer()), kNoAnswer},
      {"100 MB in 100 kB of gzip", sends(response(blanks, "200 OK", packed)), kLarge},
      {"gzip of nothing without an end",
       repeats(ok(packed + "\r\n") + std::string("\x1f\x8b\x08\0\0\0\0\0\0\x03", 10), nothing),
       kLarge},
      {"gzip that is none", sends(response("{}", "200 OK", packed)), kNoAnswer},
      {"30 MB of text", answers(stop_answer(quoted(std::string(30 * kMega, 'a')))), kLarge},
      {"2 MB of text", answers(stop_answer(quoted(std::string(2 * kMega, 'a')))),
       "texts of more than 1 MiB"},
      {"300,000 calls", answers(stop_answer("null", 300'000)), kLarge},
      {"3,000 calls", answers(stop_answer("null", 3'000)),
       "$.choices[0].message.tool_calls: more "
       "than 64"},
      {"200,000 choices", answers(R"({"choices":[{})" + repeated(",{}", 200'000) + "]}"),
       "an answer of more than 250000 values"},
      {"20 choices", answers(R"({"choices":[{"message":{}})" + repeated(",{}", 20) + "]}"),
       "$.choices: more than 16"},
      {"5 MB of brackets", answers(std::string(5 * kMega, '[')),
       "an answer of more than 64 levels"},
      {"300,000 lists", answers(R"({"choices":[[])" + repeated(",[]", 300'000) + "]}"),
       "an answer of more than 250000 values"},
      {"100,000 names", answers("{" + numbered("\"", "\":0", 100'000) + "}"),
       "an answer of an object of more than 1000 keys"},
      {"deep arguments", answers(arguments(quoted(repeated("[", 100'000)))), kDone, "are no JSON"},
      {"deep arguments in a text of JSON",
       answers(arguments(R"("\")" + repeated("[", 100'000) + R"(\"")")), kDone, "no JSON"},
      {"a page", answers("<html><body>Welcome!</body></html>"), "no JSON object"},
      {"not a number", answers(R"({"choices": NaN})"), "no JSON object"},
      {"bytes that are no UTF-8", answers(stop_answer("\"\xff\xfe\xc0\x80\"")), "no JSON object"},
      {"zeros", answers(std::string(1000, '\0')), "no JSON object"},
      {"zeros in a text and in a name",
       answers(message(R"({"content":"a\u0000b","tool_calls":[{"function":{"name":"\u0000"}}]})")),
       kDone, R"(a\u0000b)"},
      {"names that repeat", answers(R"({"choices":1,"choices":2,"choices":[]})"), "$.choices"},
      {"counts of tokens that are no counts",
       answers(R"({"usage":{"prompt_tokens":9223372036854775807,"completion_tokens":-1e300},)" +
               stop_answer().substr(1)),
       kDone},
      {"an answer that is a list", answers("[1]"), "no JSON object"},
      {"choices that are an object", answers(R"({"choices":{"0":{}}})"), "$.choices"},
      {"a choice that is a number", answers(R"({"choices":[1]})"), "$.choices[0].message"},
      {"a message that is a list", answers(message("[]")), "$.choices[0].message"},
      {"fields of other types",
       answers(message(R"({"content":7,"tool_calls":{},"refusal":[],"reasoning":null})")), kDone},
      {"calls of other types",
       answers(message(
           R"({"tool_calls":[1,{"function":7},{"id":[],"function":{"name":[],"arguments":7}}]})")),
       kDone},
  };
}

std::vector<Row> connections() {
  const std::string status = "429 Too Many Requests";
  const auto waits = [&status](const char* name, const char* seconds) {
    return Row{name, sends(response("{}", status, std::string("Retry-After: ") + seconds + "\r\n")),
               "status 429"};
  };
  return {
      {"nothing", sends_and_waits(""), kLate, "", kShort},
      {"an end at once", sends(""), kNoAnswer},
      {"no HTTP", sends("hello\r\n\r\n"), kNoAnswer},
      {"half a head", sends_and_waits("HTTP/1.1 200 OK\r\nContent-"), kLate, "", kShort},
      {"a head by the byte", repeats("HTTP/1.1 200 OK\r\n", "x", 50), kLate, "", kShort},
      {"a body by the byte", repeats(ok("\r\n"), " ", 50), kLate, "", kShort},
      // Newer versions of cpp-httplib have limits of their own for these.
      {"a line without an end", repeats("HTTP/1.1 200 OK\r\nX: ", "x"), kNoAnswer},
      {"headers without an end", repeats("HTTP/1.1 200 OK\r\n", "x: y\r\n"), kNoAnswer},
      {"a first line without an end", repeats("HTTP/1.1 200 ", "x"), kLine},
      // The library's reading of these would take more stack than a thread has.
      {"a first line of 60 kB", sends("HTTP/1.1 200 " + std::string(60'000, 'x') + "\r\n\r\n"),
       kLine},
      {"a line of 60 kB after 100",
       sends("HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 200 " + std::string(60'000, 'x') + "\r\n\r\n"),
       kLine},
      {"a first line of 1 kB",
       sends("HTTP/1.1 200 " + std::string(1'000, 'x') + "\r\nContent-Length: " +
             std::to_string(stop_answer().size()) + "\r\n\r\n" + stop_answer()),
       kDone},
      {"100 without an end", repeats("", "HTTP/1.1 100 Continue\r\n\r\n"), kHead},
      {"100 by the second", repeats("", "HTTP/1.1 100 Continue\r\n\r\n", 50), kLate, "", kShort},
      {"another protocol", sends("HTTP/1.1 101 Switching Protocols\r\n\r\n"), "status 101"},
      {"a chunk of -1 bytes", sends(ok(kChunks) + "-1\r\n{}\r\n0\r\n\r\n"), kNoAnswer},
      {"a chunk of 2^64 bytes", repeats(ok(kChunks) + "fffffffffffffff0\r\n", " "), kLarge},
      {"a chunk without a size", sends(ok(kChunks) + "zz\r\n{}\r\n0\r\n\r\n"), kNoAnswer},
      {"a chunk's extension without an end", repeats(ok(kChunks) + "2;x=", "x"), kNoAnswer},
      {"chunks of a byte without an end", repeats(ok(kChunks), "1\r\n \r\n"), kHead},
      {"trailers without an end", repeats(ok(kChunks) + "0\r\n", "x: y\r\n"), kNoAnswer},
      {"a redirect to itself", sends(response("", "302 Found", "Location: /v1\r\n")), "status 302"},
      {"a redirect elsewhere",
       sends(response("", "307 Temporary Redirect", "Location: http://127.0.0.1:9/\r\n")),
       "status 307"},
      waits("a wait of three years", "99999999"),
      waits("a wait without an end", "inf"),
      waits("a wait that is no number", "nan"),
      waits("a wait of less than nothing", "-1"),
      waits("a wait until a date", "Fri, 31 Dec 2999 23:59:59 GMT"),
      {"events without an end", repeats(events(""), ": wait\n\n"), kLarge},
      {"a stream by the event", repeats(events(""), ": wait\n\n", 50), kLate, "", kShort},
      {"deltas without an end",
       repeats(events(""), "data: {\"choices\":[{\"delta\":{\"content\":\"a\"}}]}\n\n"), kLarge},
      {"an event of 20 MB", sends(events("data: \"" + std::string(20 * kMega, 'a'))), kLarge},
      {"a delta of 2 MB",
       sends(events("data: {\"choices\":[{\"delta\":{\"content\":\"" + std::string(2 * kMega, 'a') +
                    "\"}}]}\n\ndata: [DONE]\n\n")),
       "texts of more than 1 MiB"},
      {"events that break off", sends(events("data: {\"choices\":[{\"delta\":{}}]}\n\n")),
       "ends too early"},
      {"calls by the event",
       sends(events("data: {\"choices\":[{\"delta\":{\"tool_calls\":[" +
                    numbered("{\"index\":", "}", 100) + "]}}]}\n\n")),
       "a response in parts of more than 64 calls"},
      {"names by the event",
       [](const Connection& to) {
         bool open = to.send(events(""));
         for (int k = 0; open && k < 200'000; ++k) {
           open =
               to.send("data: {\"choices\":[{\"delta\":{\"" + std::to_string(k) + "\":1}}]}\n\n");
         }
       },
       "a response in parts of more than 1000 keys"},
  };
}

/// Servers that say the key.
std::vector<Row> tellers() {
  const std::string escaped = R"(sk-\"secret\/1)";
  const auto delta = [](const std::string& text) {
    return "data: {\"choices\":[{\"delta\":{\"content\":\"" + text + "\"}}]}\n\n";
  };
  const std::string stop = "data: " + stop_answer() + "\n\ndata: [DONE]\n\n";
  return {
      {"the key in a text", answers(stop_answer(quoted("It is " + escaped + "."))), kDone,
       "It is (key)."},
      {"the key in escapes", answers(stop_answer(R"("It is \u0073k-\u0022secret\u002f1.")")), kDone,
       "It is (key)."},
      {"the key in a name",
       answers(R"({")" + escaped + R"(":{")" + escaped + R"(":1},)" + stop_answer().substr(1)),
       kDone},
      {"the key in base64", answers(stop_answer(quoted(base64("user:" + kKey)))), kDone, "(key)"},
      {"the key in per cents", answers(stop_answer(quoted("sk-%22secret%2F1"))), kDone, "(key)"},
      {"the key in parts of a content",
       answers(
           stop_answer(R"([{"type":"text","text":"sk-\"sec"},{"type":"text","text":"ret/1!"}])")),
       kDone, "(key)!"},
      {"the key in deltas", sends(events(delta("sk-") + delta("\\\"sec") + delta("ret/1") + stop)),
       kDone, "(key)"},
      {"the key in a tool's name",
       answers(message(R"({"tool_calls":[{"id":")" + escaped + R"(","function":{"name":")" +
                       escaped + R"(","arguments":"{\"place\":\"sk-\\\"secret/1\"}"}}]})")),
       kDone, "(key)"},
      {"the key in a page", answers("<html>sk-\"secret/1</html>"), "no JSON object"},
      {"the key in a refusal",
       sends(response(R"({"error":{"message":"wrong: )" + escaped + R"("}})", "401 Unauthorized")),
       "wrong: (key)"},
      {"the key in an error of status 200", answers(R"({"error":")" + escaped + R"("})"), "(key)"},
      {"the key in a filter's words",
       [escaped](const Connection& to) {
         const bool first = to.body.find("assistant") == std::string::npos;
         to.send(first ? response(arguments(R"("{\"place\":\"Z\"}")"))
                       : response(R"({"error":{"code":"content_filter","message":")" + escaped +
                                      R"("}})",
                                  "400 Bad Request"));
       },
       kDone, "filter: (key)"},
      {"the key in a name that repeats",
       [escaped](const Connection& to) {
         const bool first = to.body.find("assistant") == std::string::npos;
         to.send(first ? response(arguments(R"("{\"place\":\"Z\"}")"))
                       : response(R"({"error":{"code":"content_filter","message":")" + escaped +
                                      R"(","message":"never"}})",
                                  "400 Bad Request"));
       },
       kDone, "filter: never"},
  };
}

class EvilServers : public ::testing::Test {
 protected:
  EvilServers() : folder_("evil_servers") {}

  void run(const Row& row) {
    SCOPED_TRACE(row.name);
    const auto folder = folder_.path() / std::to_string(++number_);
    std::vector<std::size_t> which(3);
    std::iota(which.begin(), which.end(), 0U);
    arena::AskConfig config;
    config.chat.model = "m";
    config.attempts = 2;
    config.first_wait = config.longest_wait = 0.001;
    config.limits.mistakes = 3;
    EvilServer server(row.answer);
    const auto endpoint =
        arena::make_http_endpoint({.url = server.url(), .key = kKey, .timeout = row.timeout});
    arena::AnswerCache cache(folder / "cache");
    arena::AskReport report;
    std::string said;
    const bool peak_is_own = forget_peak() && !EN_TEST_SANITIZED;
    const std::size_t before = memory("VmRSS:");
    const auto begin = std::chrono::steady_clock::now();
    try {
      report = arena::ask(arena::GraphWorld(episodes_), {}, which, arena::Prompt::named("text"),
                          config, endpoint.get(), cache, folder / "run");
      EXPECT_EQ(report.done + report.given_up.size(), which.size()) << "each is done or named";
      arena::testing::expect_explained(folder / "run", report);
    } catch (const InvalidInput& error) {  // a refusal that waiting does not change
      said = error.what();
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    EXPECT_LT(seconds.count(), 60);
    if (peak_is_own) {
      EXPECT_LT(memory("VmHWM:"), before + 300 * kMega);
    }
    for (const std::string& one : report.given_up) said += one + "\n";
    if (row.says == kDone) {
      EXPECT_EQ(report.done, which.size()) << said;
    } else {
      EXPECT_THAT(said, HasSubstr(row.says));
      EXPECT_EQ(report.done, 0U);
    }
    expect_no_key(folder, said, row.shown);
  }

  static void expect_no_key(const std::filesystem::path& folder, std::string all,
                            const std::string& shown) {
    for (const auto& one : std::filesystem::recursive_directory_iterator(folder)) {
      if (one.is_regular_file()) all += read_file(one.path());
    }
    EXPECT_THAT(all, HasSubstr(shown));
    for (const std::string& secret :
         {std::string("secret"), base64("user:" + kKey), base64(kKey)}) {
      EXPECT_EQ(all.find(secret), std::string::npos) << secret;
    }
  }

  TemporaryFolder folder_;
  std::shared_ptr<const tasks::EpisodeSet> episodes_ =
      arena::testing::episodes(tasks::Task::kR2r, 3);
  int number_ = 0;
};

TEST_F(EvilServers, BodiesHaveLimits) {
  for (const Row& row : bodies()) run(row);
}
TEST_F(EvilServers, ConnectionsHaveLimits) {
  for (const Row& row : connections()) run(row);
}
TEST_F(EvilServers, NoFileGetsTheKey) {
  for (const Row& row : tellers()) run(row);
}

TEST(EvilHandshakes, EndInTime) {
  // A record of 16 KiB, by the byte: each comes in time.
  EvilServer server(repeats(std::string("\x16\x03\x03\x40\0", 5), "x", 50));
  server.talks_first = true;
  const auto endpoint = arena::make_http_endpoint({.url = server.url("https"), .timeout = kShort});
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(refusal<arena::EndpointError>([&] { endpoint->post("{}", {}); }), HasSubstr(kLate));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

TEST(RetryAfter, IsObeyedUpToALimitAndSaid) {
  struct Wait {
    const char* header;
    double waited;
    const char* said;  // null: nothing
  };
  const Wait rows[] = {
      {"99999999", 300, "the server asks for a wait of 99999999 s; the next attempt is in 300 s"},
      {"7", 7, "the server asks for a wait of 7 s; the next attempt is in 7 s"},
      {"inf", 1, nullptr},
      {"nan", 1, nullptr},
      {"-5", 1, nullptr},
      {"0", 1, nullptr},
      {"Fri, 31 Dec 2999 23:59:59 GMT", 1, nullptr},
  };
  for (const Wait& row : rows) {
    EvilServer server(
        sends(response("{}", "503 Busy", std::string("Retry-After: ") + row.header + "\r\n")));
    const auto endpoint = arena::make_http_endpoint({.url = server.url()});
    std::vector<double> waits;
    std::vector<std::string> said;
    arena::Patience patience{2, 1, [&waits](double seconds) {
                               waits.push_back(seconds);
                               return true;
                             }};
    patience.say = [&said](const std::string& sentence) { said.push_back(sentence); };
    EXPECT_THROW(arena::post_patiently(*endpoint, "{}", {"r2r/x/1_0", {}}, patience,
                                       [](std::string_view) {}),
                 arena::GivenUp);
    EXPECT_EQ(waits, std::vector<double>{row.waited}) << row.header;
    ASSERT_EQ(said.size(), row.said == nullptr ? 0U : 1U) << row.header;
    EXPECT_EQ(said.empty() ? "" : said[0],
              row.said == nullptr ? "" : "r2r/x/1_0: " + std::string(row.said));
  }
}

TEST(EvilAnswers, AMemoryErrorIsAnAttemptThatFailed) {
  EvilServer server(answers(stop_answer()));
  const auto endpoint = arena::make_http_endpoint({.url = server.url()});
  const arena::Patience patience{2, 0, [](double) { return true; }};
  for (const bool is_length : {false, true}) {
    try {
      arena::post_patiently(*endpoint, "{}", {"r2r/x/1_0", {}}, patience, [&](std::string_view) {
        if (is_length) throw std::length_error("string");
        throw std::bad_alloc();
      });
      FAIL();
    } catch (const arena::GivenUp& error) {
      EXPECT_THAT(error.what(), HasSubstr("takes more memory than there is"));
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
