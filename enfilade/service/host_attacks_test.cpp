// Pages of other sites, names that are resolved to this machine, cookies of other servers, and
// secret goals where they should not be. docs/threats.md has the table.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "enfilade/core/errors.h"
#include "enfilade/service/server.h"
#include "tests/support/refusal.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Served;
using ::testing::StartsWith;

ServerConfig named_config() {
  ServerConfig config;
  config.public_names = {"vln.example.org"};
  config.open_registration = true;
  return config;
}

// DNS rebinding: a page of evil.example, whose owner has the name resolved to this machine once the
// page is there, is of the same site as this server for a browser, and may read all its answers.
TEST(HostAttacks, ASiteThatIsResolvedToThisMachineReadsNothing) {
  Served served(named_config());
  for (const char* host : {"evil.example", "evil.example:8080", "localhost.evil.example",
                           "127.0.0.1.evil.example", "vln.example.org.evil.example"}) {
    for (const char* target : {"/", "/api/v1/scans", "/api/v1/scans/row/viewpoints/v0/faces/0.jpg",
                               "/api/v1/splits/val_seen/episodes", "/metrics", "/nothing"}) {
      const auto answer = served.get(target, {{"Host", host}});
      EXPECT_EQ(answer->status, 421) << host << target;
      EXPECT_THAT(answer->body, AllOf(HasSubstr("--public-name"), Not(HasSubstr("row"))));
    }
    const auto made = served.client().Post("/api/v1/teams", {{"Host", host}}, R"({"name": "A"})",
                                           "application/json");
    EXPECT_EQ(made->status, 421) << host;
  }
  for (const char* host : {"a b", "evil.example/", "127.0.0.1@evil.example", "[::1", "x:99999"}) {
    EXPECT_EQ(served.get("/api/v1/scans", {{"Host", host}})->status, 400) << host;
  }
  for (const char* host :
       {"vln.example.org", "VLN.example.org:8443", "localhost:1", "10.9.8.7", "[::1]:8080"}) {
    EXPECT_EQ(served.get("/api/v1/scans", {{"Host", host}})->status, 200) << host;
  }
  served.team("A");  // the name is still free
}

TEST(HostAttacks, AWrongNameOfAServerIsRefusedAtTheStart) {
  ServerConfig config;
  config.public_names = {"https://vln.example.org"};
  EXPECT_THAT(tests::refusal<ArgumentError>([&config] { Served served(config); }),
              HasSubstr("\"https://vln.example.org\", not a name like"));
}

// Plain HTTP: browsers send Origin, and no Sec-Fetch-Site.
TEST(HostAttacks, APageOfAnotherSiteChangesNothing) {
  Served served(named_config());
  int made = 0;
  const auto make_team = [&](const httplib::Headers& headers) {
    const std::string body = fmt::format(R"({{"name": "team {}"}})", ++made);
    return served.client().Post("/api/v1/teams", headers, body, "text/plain")->status;
  };
  const std::string own = fmt::format("http://127.0.0.1:{}", served.port());
  const std::string neighbour = fmt::format("http://127.0.0.1:{}", served.port() - 1);
  for (const std::string& origin :
       {std::string("http://evil.example"), std::string("null"), std::string("http://127.0.0.1"),
        neighbour, own + ".evil.example", "http://localhost:" + std::to_string(served.port()),
        std::string("https://vln.example.org.evil.example")}) {
    EXPECT_EQ(make_team({{"Origin", origin}}), 403) << origin;
  }
  EXPECT_EQ(make_team({{"Origin", "null"}, {"Sec-Fetch-Site", "cross-site"}}), 403);
  EXPECT_EQ(make_team({{"Origin", own}}), 201);
  EXPECT_EQ(make_team({{"Origin", "null"}, {"Sec-Fetch-Site", "same-origin"}}), 201);
  // A proxy may ask for the server by its address.
  EXPECT_EQ(make_team({{"Origin", "https://vln.example.org"}}), 201);
  EXPECT_EQ(make_team({}), 201);  // no browser
  // Reading is no change; without CORS, the page does not get the answer.
  const auto read = served.get("/api/v1/scans", {{"Origin", "http://evil.example"}});
  EXPECT_EQ(read->status, 200);
  EXPECT_FALSE(read->has_header("Access-Control-Allow-Origin"));
}

/// Logs in as a new team. \returns "NAME=SECRET"
std::string cookie_of_team(Served& served, const std::string& team,
                           const httplib::Headers& headers = {}) {
  const std::string token = served.team(team).find("Authorization")->second.substr(7);
  const auto logged_in = served.client().Post(
      "/api/v1/session", headers, nlohmann::json{{"token", token}}.dump(), "application/json");
  const std::string set = logged_in->get_header_value("Set-Cookie");
  return set.substr(0, set.find(';'));
}

// A browser sends the cookies of a host to all its ports.
TEST(HostAttacks, TwoServersOfOneHostKeepTheirOwnCookies) {
  Served one, other;
  const std::string here = cookie_of_team(one, "here");
  const std::string there = cookie_of_team(other, "there");
  EXPECT_NE(here.substr(0, here.find('=')), there.substr(0, there.find('=')));
  const httplib::Headers both{{"Cookie", here + "; " + there}};
  EXPECT_EQ(one.json("/api/v1/session", both).at("name"), "here");
  EXPECT_EQ(other.json("/api/v1/session", both).at("name"), "there");
  // Logging out of one leaves the other.
  httplib::Headers change = both;
  change.emplace("X-Enfilade", "1");
  const auto out = one.client().Delete("/api/v1/session", change);
  EXPECT_THAT(out->get_header_value("Set-Cookie"),
              AllOf(StartsWith(here.substr(0, here.find('=')) + "=;"), HasSubstr("Max-Age=0")));
  EXPECT_EQ(one.json("/api/v1/session", both).at("role"), "stranger");
  EXPECT_EQ(other.json("/api/v1/session", both).at("name"), "there");
}

// Other hosts of the domain may set cookies for all of it, but none that begins with __Host-.
TEST(HostAttacks, ASiblingHostCannotSetTheCookieOverTls) {
  ServerConfig config = named_config();
  config.behind_proxy = true;
  Served served(config);
  const httplib::Headers proxied{{"Host", "vln.example.org"}, {"X-Forwarded-Proto", "https"}};
  const std::string cookie = cookie_of_team(served, "A", proxied);
  EXPECT_THAT(cookie, StartsWith("__Host-enfilade_session="));
  const auto asked_with = [&](const std::string& sent) {
    httplib::Headers headers = proxied;
    headers.emplace("Cookie", sent);
    return served.json("/api/v1/session", headers).at("role");
  };
  EXPECT_EQ(asked_with(cookie), "team");
  EXPECT_EQ(asked_with(cookie.substr(std::string("__Host-").size())), "stranger");
}

/// What opening the data set says, with secret goals in that file.
std::string refusal_of_goals(const fs::path& data, const fs::path& goals) {
  Phase phase;
  phase.name = "final";
  phase.split = "test";
  phase.annotations = goals;
  phase.scores = Scores::kHidden;
  return tests::refusal<InvalidInput>([&] { Site::open(data, {phase}); });
}

TEST(HostAttacks, SecretGoalsInTheDataSetAreRefusedAtTheStart) {
  const tests::TemporaryFolder folder("goals");
  const fs::path& root = folder.path();
  const fs::path data = root / "data", goals = root / "secret.json";
  testing::write_served_data(root);
  EXPECT_EQ(refusal_of_goals(data, goals), "accepted");
  fs::copy_file(goals, data / "r2r/secret.json");
  const auto refused = AllOf(HasSubstr("phase final"), HasSubstr("secret.json"),
                             HasSubstr(fs::canonical(data).string()));
  EXPECT_THAT(refusal_of_goals(data, data / "r2r/secret.json"), refused);
  EXPECT_THAT(refusal_of_goals(data, root / "data/../data/r2r/secret.json"), refused);
  fs::create_symlink(data / "r2r/secret.json", root / "link_to_inside.json");
  EXPECT_THAT(refusal_of_goals(data, root / "link_to_inside.json"), HasSubstr("phase final"));
  fs::create_symlink(goals, data / "link_to_outside.json");
  EXPECT_THAT(refusal_of_goals(data, data / "link_to_outside.json"), HasSubstr("phase final"));
  fs::create_directory_symlink(data, root / "alias");
  EXPECT_THAT(refusal_of_goals(data, root / "alias/r2r/secret.json"), refused);
  EXPECT_THAT(refusal_of_goals(root / "alias", data / "r2r/secret.json"), refused);
}

TEST(HostAttacks, SoAreThoseThatASplitOfTheDataSetIsALinkTo) {
  const tests::TemporaryFolder folder("goals");
  const fs::path& root = folder.path();
  const fs::path data = root / "data";
  testing::write_served_data(root);
  fs::remove(data / "r2r/R2R_test.json");
  fs::create_symlink(root / "secret.json", data / "r2r/R2R_test.json");
  EXPECT_THAT(refusal_of_goals(data, root / "secret.json"), HasSubstr("phase final"));
}

TEST(HostAttacks, SoAreThoseInAFolderThatThePicturesAreLinkedTo) {
  const tests::TemporaryFolder folder("goals");
  const fs::path& root = folder.path();
  const fs::path data = root / "data", pictures = root / "pictures";
  testing::write_served_data(root);
  fs::rename(data / "store", pictures);
  fs::create_directory_symlink(pictures, data / "store");
  fs::copy_file(root / "secret.json", pictures / "secret.json");
  EXPECT_EQ(refusal_of_goals(data, root / "secret.json"), "accepted");
  EXPECT_THAT(refusal_of_goals(data, pictures / "secret.json"),
              HasSubstr(fs::canonical(pictures).string()));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
