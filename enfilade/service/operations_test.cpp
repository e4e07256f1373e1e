// What the people who run a server count on: its health, its files, its memory, its answers to
// what is not there.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <csignal>
#include <fstream>
#include <limits>

#include "enfilade/core/errors.h"
#include "enfilade/scan/store.h"
#include "enfilade/service/http/routes.h"
#include "enfilade/service/server.h"
#include "tests/support/resident.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Served;

/// What a server says about its health, and what it writes into its log about it.
class Health : public ::testing::Test {
 protected:
  ServerConfig config() {
    ServerConfig config;
    config.log = [this](const RequestRecord& record) {
      if (record.method != "HEALTH") return;
      const std::scoped_lock lock(mutex_);
      told_.push_back(std::to_string(record.status) + " " + std::string(record.fault));
    };
    return config;
  }
  /// Asks until it answers with that status; it looks once a second.
  static std::string asked_until(Served& served, int status) {
    std::string body;
    for (int k = 0; k < 200; ++k) {
      const auto answer = served.get("/healthz");
      body = answer->body;
      if (answer->status == status) return body;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return "never " + std::to_string(status) + ", but " + body;
  }
  std::vector<std::string> told() {
    const std::scoped_lock lock(mutex_);
    return told_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> told_;
};

TEST_F(Health, AFullDiskIsTold) {
  EN_SKIP_ON_POSTGRES("its disk may be another machine's");
  ServerConfig full = config();
  full.least_free_bytes = std::numeric_limits<std::uint64_t>::max();
  Served served(full);
  const auto answer = served.get("/healthz");
  EXPECT_EQ(answer->status, 503);
  EXPECT_EQ(nlohmann::json::parse(answer->body).at("error").at("code"), "disk-full");
  EXPECT_THAT(answer->body, Not(HasSubstr(served.root().string())));
  EXPECT_EQ(served.get("/api/v1/scans")->status, 200);  // what can be served still is
}

TEST_F(Health, ADatabaseThatWasReplacedIsTold) {
  EN_SKIP_ON_POSTGRES("there is no file");
  Served served(config());
  EXPECT_EQ(served.get("/healthz")->status, 200);
  const fs::path file = served.config().database;
  back_up_database(file, served.root() / "copy.sqlite");
  fs::rename(served.root() / "copy.sqlite", file);
  const std::string body = asked_until(served, 503);
  EXPECT_THAT(body,
              AllOf(HasSubstr("\"database-replaced\""), Not(HasSubstr(served.root().string()))));
  EXPECT_THAT(told(),
              ElementsAre(AllOf(HasSubstr("503 database-replaced"), HasSubstr(file.string()))));
}

TEST_F(Health, ADatabaseThatWasOverwrittenIsTold) {
  EN_SKIP_ON_POSTGRES("there is no file");
  Served served(config());
  served.stop();
  served.start();  // the log of SQLite, which has everything still, is in the file now
  EXPECT_EQ(served.get("/healthz")->status, 200);
  const fs::path file = served.config().database;
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary)
      << std::string(fs::file_size(file), 'x');
  EXPECT_THAT(asked_until(served, 503), HasSubstr("\"database-unreadable\""));
}

TEST_F(Health, ATableThatWasRemovedIsTold) {
  Served served(config());
  EXPECT_EQ(served.get("/healthz")->status, 200);
  testing::run_sql(served.config().database, "DROP TABLE play_call");
  EXPECT_THAT(asked_until(served, 503),
              AllOf(HasSubstr("\"table-missing\""), HasSubstr("play_call")));
  EXPECT_THAT(told(), ElementsAre(HasSubstr("its table play_call is missing")));
}

/// While it lives, no file of this process can grow or be written beyond its first byte: like a
/// disk that fails to take more.
class NoWriting {
 public:
  NoWriting() {
    signals_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit none = before_;
    none.rlim_cur = 0;
    setrlimit(RLIMIT_FSIZE, &none);
  }
  ~NoWriting() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signals_);
  }
  NoWriting(const NoWriting&) = delete;
  NoWriting& operator=(const NoWriting&) = delete;

 private:
  rlimit before_{};
  sighandler_t signals_ = nullptr;
};

TEST_F(Health, ADatabaseThatCannotBeWrittenIsToldAndSoIsItsRecovery) {
  EN_SKIP_ON_POSTGRES("there is no file");
  Served served(config());
  EXPECT_EQ(served.get("/healthz")->status, 200);
  std::string body;
  {
    const NoWriting no_writing;
    body = asked_until(served, 503);
  }
  EXPECT_THAT(body, HasSubstr("\"database-unwritable\""));
  EXPECT_EQ(asked_until(served, 200), R"({"status":"ok"})");
  EXPECT_THAT(told(), ElementsAre(HasSubstr("503 database-unwritable"), "200 "));
  served.team("A");  // and it works again
}

TEST(Operations, TheDatabaseAndItsBackUpsAreTheOwnersAlone) {
  EN_SKIP_ON_POSTGRES("there is no file");
  const mode_t before = ::umask(0);
  {
    Served served;
    const fs::path file = served.config().database;
    back_up_database(file, served.root() / "copy.sqlite");
    for (const fs::path& one : {file, fs::path(file.string() + "-wal"),
                                fs::path(file.string() + "-shm"), served.root() / "copy.sqlite"}) {
      EXPECT_EQ(fs::status(one).permissions(), fs::perms::owner_read | fs::perms::owner_write)
          << one;
    }
  }
  ::umask(before);
}

constexpr const char* kBrowser = "text/html,application/xhtml+xml,*/*;q=0.8";

TEST(Operations, PeopleGetAPageWhereThereIsNothing) {
  Served served;
  const auto page = served.get("/nothing", {{"Accept", kBrowser}});
  EXPECT_EQ(page->status, 404);
  EXPECT_EQ(page->get_header_value("Content-Type"), "text/html; charset=utf-8");
  EXPECT_THAT(page->body,
              AllOf(HasSubstr("<h1>There is nothing here</h1>"), HasSubstr("<a href=\"/\""),
                    Not(HasSubstr("style=")), Not(HasSubstr("<script"))));
  if (has_web_client()) {
    const std::string begin = "rel=\"stylesheet\" href=\"";
    const std::size_t at = page->body.find(begin);
    ASSERT_NE(at, std::string::npos);
    const std::string href = page->body.substr(at + begin.size());
    const auto style = served.get(href.substr(0, href.find('"')));
    EXPECT_EQ(style->status, 200);
    EXPECT_EQ(style->get_header_value("Content-Type"), "text/css; charset=utf-8");
  }
  const auto wrong_name = served.get("/", {{"Accept", kBrowser}, {"Host", "vln.example.org"}});
  EXPECT_EQ(wrong_name->status, 421);
  EXPECT_THAT(wrong_name->body, AllOf(HasSubstr("<h1>"), HasSubstr("--public-name vln.example")));
}

TEST(Operations, ThePageWhereThereIsNothingLeadsToTheOthers) {
  Served served;
  const auto body = served.get("/nothing", {{"Accept", kBrowser}})->body;
  for (const char* link : {"/", "/episodes", "/leaderboard", "/submit", "/organise"}) {
    EXPECT_THAT(body, HasSubstr(fmt::format("<a href=\"{}\">", link)));
  }
  EXPECT_THAT(body, AllOf(Not(HasSubstr("href=\"/replay\"")), Not(HasSubstr("SYNTHETIC"))));
  http::Request request;
  request.path = "/nothing";
  request.headers.emplace("accept", kBrowser);
  http::Response error = http::error_response(404, "there is nothing here");
  http::show_to_people(request, {.synthetic = true, .runs = true}, error);
  EXPECT_THAT(*error.body,
              AllOf(HasSubstr("<a href=\"/replay\">Runs</a>"), HasSubstr("SYNTHETIC")));
}

TEST(Operations, ScriptsAndTheApisClientsGetJson) {
  Served served;
  for (const auto& [target, accept] :
       {std::pair{"/nothing", "*/*"}, {"/nothing", ""}, {"/api/v1/nothing", kBrowser}}) {
    const auto answer = served.get(target, {{"Accept", accept}});
    EXPECT_EQ(answer->status, 404);
    EXPECT_EQ(answer->get_header_value("Content-Type"), "application/json") << target << accept;
    EXPECT_THAT(answer->body, HasSubstr("\"not-found\""));
  }
}

TEST(Operations, WhatAPageQuotesIsText) {
  http::Request request;
  request.path = "/x";
  request.headers.emplace("accept", "text/html");
  http::Response error = http::error_response(400, "not <script>alert(1)</script> & \"x\"");
  http::show_to_people(request, {}, error);
  EXPECT_THAT(*error.body, AllOf(HasSubstr("not &lt;script&gt;"), Not(HasSubstr("<script"))));
}

TEST(Operations, AWrongMethodIsToldTheRightOnes) {
  Served served;
  const auto allowed = [](const httplib::Result& answer) {
    return std::to_string(answer->status) + " " + answer->get_header_value("Allow");
  };
  httplib::Client& client = served.client();
  EXPECT_EQ(allowed(client.Post("/healthz", "", "text/plain")), "405 GET, HEAD");
  EXPECT_EQ(allowed(client.Put("/api/v1/session", "", "text/plain")),
            "405 POST, GET, DELETE, HEAD");
  EXPECT_EQ(allowed(client.Post("/", "", "text/plain")), "405 GET, HEAD");
  EXPECT_EQ(allowed(client.Options("/healthz")), "405 GET, HEAD");
  EXPECT_EQ(allowed(served.get("/api/v1/collections/x/export/y")), "404 ");
  EXPECT_EQ(allowed(client.Post("/nothing", "", "text/plain")), "404 ");
  EXPECT_EQ(client.Head("/healthz")->status, 200);
}

TEST(Operations, BearerMayBeWrittenInAnyCase) {
  Served served;
  const std::string token = served.team("A").find("Authorization")->second.substr(7);
  const auto asked = [&](const std::string& authorization) {
    return served.get("/api/v1/submissions", {{"Authorization", authorization}});
  };
  for (const char* scheme : {"Bearer ", "bearer ", "BEARER ", "bEaReR  "}) {
    EXPECT_EQ(asked(scheme + token)->status, 200) << scheme;
  }
  for (const char* scheme : {"", "Bearer", "Basic ", "Bearer,", "Token "}) {
    EXPECT_EQ(asked(scheme + token)->status, 401) << scheme;
  }
  EXPECT_EQ(served.get("/api/v1/submissions")->get_header_value("WWW-Authenticate"), "Bearer");
}

// A visitor who walks through a whole building leaves none of its store in the memory.
TEST(Operations, PicturesThatWereSentAreGivenBack) {
  Served served;
  served.stop();
  const scan::Connectivity row = scan::testing::row_of_viewpoints("row", 6);
  std::vector<scan::Panorama> panoramas;
  for (std::uint64_t v = 0; v < 6; ++v) panoramas.push_back(scan::testing::panorama(256, v));
  scan::PackOptions options;
  options.colour = scan::ColourCoding::kRaw;  // 1.2 MB each
  const fs::path file = scan::pack(scan::MemoryPanoramas(row, std::move(panoramas)),
                                   served.root() / "data/store", options)
                            .file;
  served.start();
  for (int v = 0; v < 6; ++v) {
    const std::string viewpoint = "/api/v1/scans/row/viewpoints/v" + std::to_string(v);
    for (const char* face : {"/faces/0.jpg", "/depth/0.png", "/classes/0.png"}) {
      ASSERT_EQ(served.get(viewpoint + face)->status, 200) << viewpoint << face;
    }
  }
  EXPECT_GT(fs::file_size(file), 7'000'000U);
  EXPECT_LT(tests::resident_bytes_of(file), 500'000U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
