// What everybody may see, over real sockets.
#include "enfilade/service/server.h"

#include <gmock/gmock.h>
#include <algorithm>
#include <cctype>

#include "enfilade/core/errors.h"
#include "enfilade/image/codecs.h"
#include "enfilade/service/http/routes.h"
#include "tests/support/raw_socket.h"
#include "tests/support/refusal.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::Served;

TEST(Server, ListsScans) {
  Served served;
  const auto list = served.json("/api/v1/scans");
  ASSERT_EQ(list.at("scans").size(), 2U);
  EXPECT_EQ(list["scans"][0]["scan"], "row");
  EXPECT_EQ(list["scans"][0]["viewpoints"], 6);
  EXPECT_EQ(list["scans"][0]["edges"], 5);
  EXPECT_EQ(list["scans"][0]["pictures"], true);
}

TEST(Server, AScanHasAllThatAViewerDrawsWith) {
  Served served;
  const auto scan = served.json("/api/v1/scans/row");
  ASSERT_EQ(scan.at("viewpoints").size(), 6U);
  const auto& v1 = scan["viewpoints"][1];
  EXPECT_EQ(v1["id"], "v1");
  EXPECT_EQ(v1["position"], nlohmann::json({1.0, 0.0, 1.5}));
  EXPECT_EQ(v1["height"], 1.5);
  EXPECT_EQ(v1["neighbours"], nlohmann::json({0, 2}));
  EXPECT_EQ(v1["rotation"].size(), 9U);
  EXPECT_EQ(v1["layers"], nlohmann::json({"colour", "depth", "class"}));
  EXPECT_EQ(scan["storeys"].size(), 1U);
}

TEST(Server, FacesAreTheStoresOwnJpegs) {
  Served served;
  const auto face = served.get("/api/v1/scans/row/viewpoints/v2/faces/3.jpg");
  ASSERT_EQ(face->status, 200);
  EXPECT_EQ(face->get_header_value("Content-Type"), "image/jpeg");
  const auto store = scan::Store::open(served.root() / "data/store/row.enfilade");
  EXPECT_EQ(face->body, (*store->colour_jpegs(ViewpointIndex(2)))[3]);
}

TEST(Server, AFaceThatTheBrowserHasIsNotSentAgain) {
  Served served;
  const std::string target = "/api/v1/scans/row/viewpoints/v2/faces/3.jpg";
  const auto first = served.get(target);
  EXPECT_THAT(first->get_header_value("Cache-Control"), HasSubstr("public"));
  const auto again = served.get(target, {{"If-None-Match", first->get_header_value("ETag")}});
  EXPECT_EQ(again->status, 304);
  EXPECT_EQ(again->body, "");
  const auto other = served.get("/api/v1/scans/row/viewpoints/v2/faces/4.jpg",
                                {{"If-None-Match", first->get_header_value("ETag")}});
  EXPECT_EQ(other->status, 200);
}

TEST(Server, DepthAndClassesComeInColours) {
  Served served;
  for (const char* layer : {"depth", "classes"}) {
    const auto face =
        served.get(std::string("/api/v1/scans/row/viewpoints/v0/") + layer + "/2.png");
    ASSERT_EQ(face->status, 200) << layer;
    EXPECT_EQ(image::png_shape(image::bytes_of(face->body), layer), (image::Shape{32, 32, 3, 8}));
  }
}

TEST(Server, WhatIsNotThereIsNotFound) {
  Served served;
  for (const char* target : {"/api/v1/scans/none", "/api/v1/scans/row/viewpoints/v9/faces/0.jpg",
                             "/api/v1/scans/row/viewpoints/v0/faces/6.jpg",
                             "/api/v1/scans/row/viewpoints/v0/faces/0.png",
                             "/api/v1/splits/none/episodes", "/api/v1/", "/nothing"}) {
    const auto result = served.get(target);
    EXPECT_EQ(result->status, 404) << target;
    EXPECT_THAT(result->body, HasSubstr("\"error\"")) << target;
  }
}

TEST(Server, EpisodesAreFilteredAndPaged) {
  Served served;
  const auto all = served.json("/api/v1/splits/val_seen/episodes");
  EXPECT_EQ(all.at("matching"), 6);
  EXPECT_EQ(all["episodes"][0]["path"].size(), 4U);
  const auto some = served.json("/api/v1/splits/val_seen/episodes?q=END%20of&offset=1&limit=1");
  EXPECT_EQ(some.at("matching"), 3);
  ASSERT_EQ(some["episodes"].size(), 1U);
  EXPECT_EQ(some["episodes"][0]["instruction_id"], "2_0");
  EXPECT_EQ(served.get("/api/v1/splits/val_seen/episodes?limit=0")->status, 400);
  EXPECT_EQ(served.get("/api/v1/splits/val_seen/episodes?offset=1x")->status, 400);
}

TEST(Server, APlanIsASvgThatRunsNothing) {
  Served served;
  const auto plan = served.get("/api/v1/scans/row/plan.svg");
  EXPECT_EQ(plan->get_header_value("Content-Type"), "image/svg+xml");
  EXPECT_EQ(plan->get_header_value_count("Content-Security-Policy"), 1U);
  EXPECT_THAT(plan->get_header_value("Content-Security-Policy"), Not(HasSubstr("script-src")));
}

TEST(Server, LongTextsComeCompressedToWhoTakesThem) {
  Served served;
  // Without the header, the client of newer versions of cpp-httplib asks for gzip.
  const auto plain = served.get("/api/v1/scans/row/plan.svg", {{"Accept-Encoding", "identity"}});
  EXPECT_EQ(plain->get_header_value("Content-Encoding"), "");
  const auto packed = served.get("/api/v1/scans/row/plan.svg", {{"Accept-Encoding", "gzip"}});
  EXPECT_EQ(packed->get_header_value("Content-Encoding"), "gzip");
  EXPECT_EQ(packed->body, plain->body);  // the client unpacks
}

TEST(Server, TellsHowItIs) {
  Served served;
  EXPECT_EQ(served.get("/healthz")->body, R"({"status":"ok"})");
  served.get("/api/v1/scans/row");
  const std::string metrics = served.get("/metrics")->body;
  EXPECT_THAT(metrics, HasSubstr("enfilade_requests_total{route=\"/api/v1/scans/{scan}\","
                                 "status=\"200\"} 1\n"));
  EXPECT_THAT(metrics, HasSubstr("enfilade_submissions_queued 0\n"));
}

TEST(Server, LogsEachRequest) {
  std::mutex mutex;
  std::vector<std::string> lines;
  ServerConfig config;
  config.log = [&](const RequestRecord& record) {
    const std::scoped_lock lock(mutex);
    lines.push_back(std::string(record.method) + " " + std::string(record.path) + " " +
                    std::to_string(record.status));
  };
  Served served(config);
  served.get("/healthz");
  served.get("/nothing");
  tests::exchange(served.port(), {"GET / HTTP/1.1\r\n\r\n"}, 0);  // no Host: no route sees it
  EXPECT_THAT(served.get("/metrics")->body,
              HasSubstr("enfilade_requests_total{route=\"(refused)\",status=\"400\"} 1\n"));
  served.stop();
  EXPECT_THAT(lines, ::testing::ElementsAre("GET /healthz 200", "GET /nothing 404", "-  400",
                                            "GET /metrics 200"));
}

TEST(Server, APortThatIsTakenIsRefused) {
  Served served;
  ServerConfig config = served.config();
  config.port = served.port();
  config.database = testing::new_database(served.root() / "other.sqlite");
  EXPECT_THAT(tests::refusal<ArgumentError>(
                  [&] { const Server second(Site::open(served.root() / "data"), config); }),
              HasSubstr("cannot listen there"));
}

TEST(Server, GoalsOfASecretPhaseAreHiddenEvenIfTheyLieInTheDataSet) {
  Served served;
  served.stop();
  write_file_atomically(served.root() / "data/r2r/R2R_test.json",
                        to_json(testing::row_annotations("test", true)));
  served.start();
  const std::string body = served.get("/api/v1/splits/test/episodes")->body;
  const auto episodes = nlohmann::json::parse(body);
  EXPECT_EQ(episodes.at("goals_hidden"), true);
  EXPECT_THAT(body, Not(HasSubstr("\"path\"")));
  EXPECT_THAT(body, Not(HasSubstr("distance")));
}

TEST(Server, TheDescriptionNamesEveryRouteAndNoOther) {
  Served served;
  std::vector<std::string> described;
  const auto description = served.json("/api/v1/openapi.json");
  for (const auto& [path, methods] : description.at("paths").items()) {
    for (const auto& [method, about] : methods.items()) {
      std::string upper = method;
      std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return std::toupper(c); });
      if (method != "parameters") described.push_back(upper + " " + path);
    }
  }
  served.stop();
  const http::App app(Site::open(served.root() / "data"), served.config());
  std::vector<std::string> routes;
  for (const http::HttpRoute& route : app.router().routes()) {
    routes.push_back(route.method + " " + route.pattern);
  }
  EXPECT_THAT(described, ::testing::UnorderedElementsAreArray(routes));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
