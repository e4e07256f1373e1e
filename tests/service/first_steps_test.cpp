// `enfilade serve` as people start it: what it prints, and what it refuses.
#include <gmock/gmock.h>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/core/gzip.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/store.h"
#include "tests/service/program.h"
#include "tests/support/emulated.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::Program;

TEST(FirstSteps, AnOrganiserIsToldWhereToGoAndCanLogIn) {
  const tests::TemporaryFolder folder("first_steps");
  testing::write_served_data(folder.path());
  const std::string database = testing::new_database(folder.path() / "service.sqlite");
  Program program(EN_PROGRAM, folder.path() / "data", database, {"--organiser", "Ada"});
  program.start();
  const std::string address = "http://127.0.0.1:" + std::to_string(program.port()) + "/";
  const std::string said = program.said_until("Ctrl-C ends it.");
  EXPECT_THAT(said, AllOf(HasSubstr("2 scans at " + address), HasSubstr(address + "organise"),
                          HasSubstr("What to do next"), HasSubstr(shown_database(database))));
  const std::size_t at = said.find("enfilade_");
  ASSERT_NE(at, std::string::npos) << said;
  const std::string token = said.substr(at, said.find('\n', at) - at);
  httplib::Client client("127.0.0.1", program.port());
  const auto who = client.Get("/api/v1/session", {{"Authorization", "Bearer " + token}});
  EXPECT_EQ(who->body, R"({"role":"organiser","name":"Ada"})");
}

TEST(FirstSteps, ResultsAndTokenAreHandedInAsFilesAreSaved) {
  const tests::TemporaryFolder folder("first_steps");
  const std::filesystem::path& root = folder.path();
  testing::write_served_data(root);
  Program program(EN_PROGRAM, root / "data", testing::new_database(root / "service.sqlite"),
                  {"--open-registration", "--accept-leak", "--phases", root / "phases.json"});
  program.start();
  const std::string bearer = testing::make_team(program.port(), "Ours").begin()->second;
  write_file_atomically(root / "token",
                        "\xef\xbb\xbf" + bearer.substr(bearer.find(' ') + 1) + "\r\n");
  const std::string results = testing::row_results(3);
  write_file_atomically(root / "r.json.gz",
                        gzip(results.substr(0, 99), 6) + gzip(results.substr(99), 6));
  for (const char* name : {"r.json.gz", "r.json"}) {
    tests::Process submit({EN_PROGRAM, "submit", root / name, "--server",
                           "http://127.0.0.1:" + std::to_string(program.port()), "--phase", "open",
                           "--method", name, "--token-file", root / "token"},
                          root / "said");
    EXPECT_EQ(submit.wait(), 0) << name;
    EXPECT_THAT(read_file(root / "said"), HasSubstr(": scored")) << name;
  }
}

// Before a port is bound, and not again with --accept-leak.
TEST(FirstSteps, APhaseThatGivesItsGoalsAwayIsRefused) {
  const tests::TemporaryFolder folder("first_steps");
  const std::filesystem::path& root = folder.path();
  testing::write_served_data(root);
  tests::Process process({EN_PROGRAM, "serve", root / "data", "--db", root / "service.sqlite",
                          "--port", "0", "--phases", root / "phases.json"},
                         root / "said", {}, root / "complaints");
  EXPECT_EQ(process.wait(), 3);
  const std::string said = read_file(root / "said") + read_file(root / "complaints");
  EXPECT_THAT(said, AllOf(HasSubstr("phases test, final share goals: their limits give away up to "
                                    "1051 bits, and the goals of test have 7"),
                          HasSubstr("[goals-given-away]"), HasSubstr("--accept-leak")));
  Program program(EN_PROGRAM, root / "data", root / "service.sqlite",
                  {"--accept-leak", "--phases", root / "phases.json"});
  program.start();
  EXPECT_GT(program.port(), 0);
}

TEST(FirstSteps, AServerBehindAProxyHasToKnowItsName) {
  const tests::TemporaryFolder folder("first_steps");
  testing::write_served_data(folder.path());
  tests::Process process({EN_PROGRAM, "serve", folder.path() / "data", "--db",
                          folder.path() / "service.sqlite", "--port", "0", "--behind-proxy"});
  EXPECT_EQ(process.wait(), 2);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "service.sqlite"));
}

TEST(FirstSteps, ADatabaseIsNamedWithoutItsPassword) {
  const tests::TemporaryFolder folder("first_steps");
  const auto status_of = [&](const std::vector<std::string>& words) {
    std::vector<std::string> all{EN_PROGRAM, "serve", "token", "--label", "Ada"};
    all.insert(all.end(), words.begin(), words.end());
    return tests::Process(all, folder.path() / "said").wait();
  };
  EXPECT_EQ(status_of({"--db", "postgresql://u:secret@localhost/d"}), 2);
  unsetenv("ENFILADE_DATABASE");
  EXPECT_EQ(status_of({}), 2);
  const std::string database = testing::new_database(folder.path() / "service.sqlite");
  setenv("ENFILADE_DATABASE", database.c_str(), 1);
  EXPECT_EQ(status_of({}), 0);
  unsetenv("ENFILADE_DATABASE");
  EXPECT_THAT(read_file(folder.path() / "said"), HasSubstr("enfilade_"));
  if (testing::on_postgres()) {  // which has its own back-ups
    tests::Process backup({EN_PROGRAM, "serve", "backup", "--db", database, folder.path() / "c"});
    EXPECT_EQ(backup.wait(), 2);
  }
}

/// A machine that has nothing: a folder of its own, and no ENFILADE_DATA.
class FirstVisit : public ::testing::Test {
 protected:
  FirstVisit() {
    if (const char* data = std::getenv("ENFILADE_DATA"); data != nullptr) data_ = data;
    unsetenv("ENFILADE_DATA");
    std::filesystem::current_path(folder_.path());
  }
  ~FirstVisit() override {
    std::filesystem::current_path(before_);
    if (data_) setenv("ENFILADE_DATA", data_->c_str(), 1);
  }

  nlohmann::json get(const std::string& target) const {
    httplib::Client client("127.0.0.1", program_.port());
    return nlohmann::json::parse(client.Get(target)->body);
  }
  /// Of each phase: both agents, each once, by a real score.
  void expect_two_agents() const {
    const nlohmann::json phases = get("/api/v1/phases").at("phases");
    EXPECT_FALSE(phases.empty());
    for (const auto& phase : phases) {
      const auto name = phase.at("phase").get<std::string>();
      const nlohmann::json rows = get("/api/v1/leaderboards/" + name + "?all=1").at("rows");
      ASSERT_EQ(rows.size(), 2U) << name;
      EXPECT_EQ(rows[0].at("team"), "Baseline: Shortest");
      EXPECT_EQ(rows[0].at("means").at("success").at("mean"), 1.0);
      EXPECT_EQ(rows[1].at("team"), "Baseline: Random");
      EXPECT_LT(rows[1].at("means").at("success").at("mean").get<double>(), 0.9);
      for (const auto& row : rows) {
        EXPECT_THAT(row.at("method").get<std::string>(), HasSubstr("SYNTHETIC"));
      }
    }
  }

  tests::TemporaryFolder folder_{"first_visit"};
  Program program_{EN_PROGRAM, std::vector<std::string>{}};

 private:
  std::filesystem::path before_ = std::filesystem::current_path();
  std::optional<std::string> data_;
};

TEST_F(FirstVisit, HomesThatTheDemoMadeAreServedWithTwoAgents) {
  const std::filesystem::path homes = "enfilade-demo/homes";
  homes::HomeSetOptions options = homes::home_set_preset("graphs");
  options.homes = 3;
  homes::write_homes(homes, options);
  homes::HomePathOptions paths;
  paths.per_home = 20;
  homes::write_home_paths(homes, paths);
  program_.start();
  const std::string said = program_.said_until("Ctrl-C ends it.");
  EXPECT_THAT(said, AllOf(HasSubstr("3 scans (model homes: synthetic) at http://127.0.0.1:"),
                          HasSubstr("You are its organiser"), HasSubstr("What to do next")));
  EXPECT_FALSE(std::filesystem::exists("enfilade-demo/two-homes"));
  expect_two_agents();
  program_.kill();
  program_.start();  // what is there is not handed in again
  expect_two_agents();
}

TEST_F(FirstVisit, WhoseRulesNameNoDataSetIsToldSo) {
  write_file_atomically("phases.json", R"({"phases": []})");
  tests::Process process({EN_PROGRAM, "serve", "--port", "0", "--phases", "phases.json"});
  EXPECT_EQ(process.wait(), 2);
  EXPECT_FALSE(std::filesystem::exists("enfilade-demo"));
}

TEST_F(FirstVisit, APortThatIsTakenIsToldBeforeHomesAreMade) {
  httplib::Server other;
  const int port = other.bind_to_any_port("127.0.0.1");
  std::thread serving([&other] { other.listen_after_bind(); });
  tests::Process process({EN_PROGRAM, "serve", "--port", std::to_string(port)});
  EXPECT_EQ(process.wait(), 2);
  other.stop();
  serving.join();
  EXPECT_FALSE(std::filesystem::exists("enfilade-demo"));
}

// Texels of a face as the server sends it, and how long a browser keeps it.
std::pair<std::uint32_t, std::string> sent_face(int port) {
  httplib::Client client("127.0.0.1", port);
  const auto scan = nlohmann::json::parse(client.Get("/api/v1/scans/home0001")->body);
  const auto id = scan.at("viewpoints").at(0).at("id").get<std::string>();
  const auto face = client.Get("/api/v1/scans/home0001/viewpoints/" + id + "/faces/0.jpg");
  const auto picture = image::decode_jpeg(image::bytes_of(face->body), "face");
  return {picture.width, face->get_header_value("Cache-Control")};
}

// Two homes as a first visit makes them, with pictures that are quickly made.
void write_first_homes(std::uint32_t face_size) {
  homes::HomeSetOptions options = homes::home_set_preset("small");
  options.face_size = face_size;
  const std::filesystem::path folder = "enfilade-demo/two-homes";
  homes::write_homes(folder, options);
  homes::HomePathOptions paths;
  paths.test_split = false;
  paths.tasks = {"r2r"};
  homes::write_home_paths(folder, paths);
}

TEST_F(FirstVisit, LargerPicturesComeWhileItServes) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  write_first_homes(8);
  Program program(EN_PROGRAM, std::vector<std::string>{"--faces", "96"});
  program.start();
  const std::string said = program.said_until("Ctrl-C ends it.");
  EXPECT_THAT(said, HasSubstr("Larger pictures of 2 homes are being made beside"));
  EXPECT_THAT(said, HasSubstr("--faces 8 leaves that out")) << "the size that they have";
  const auto [first, kept] = sent_face(program.port());
  EXPECT_TRUE(first == 8 || first == 96) << first;
  std::string told;
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  while (told.find("load a page again") == std::string::npos &&
         std::chrono::steady_clock::now() < end) {
    const auto [size, header] = sent_face(program.port());
    EXPECT_TRUE(size == 8 || size == 96) << size << ": never a part of one";
    told = program.said_until("load a page again");
  }
  EXPECT_EQ(sent_face(program.port()), std::pair(96U, std::string("public, max-age=86400")));
  if (first == 8) {
    EXPECT_EQ(kept, "no-cache") << "or browsers would show it for a day";
  }
  // Once they are there nothing is made.
  program.kill();
  program.start();
  EXPECT_THAT(program.said_until("Ctrl-C ends it."), ::testing::Not(HasSubstr("Larger pictures")));
}

TEST_F(FirstVisit, LargerPicturesGoOnAfterAKill) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  write_first_homes(8);
  Program program(EN_PROGRAM, std::vector<std::string>{"--faces", "96"});
  const std::filesystem::path store = "enfilade-demo/two-homes/store/home0002.enfilade";
  const std::filesystem::path part = store.string() + ".part";
  program.start();
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(10);
  const auto wait_for = [&end](const auto& ready) {
    while (!ready() && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  wait_for([&] { return std::filesystem::exists(part); });
  program.kill();
  const auto size = [&store] {
    const auto opened = scan::Store::open(store);
    EXPECT_TRUE(opened->verify().empty());
    return opened->face_sizes(ViewpointIndex(0))[scan::index(scan::Layer::kColour)];
  };
  EXPECT_EQ(size(), 8U) << "usable as it was";
  program.start();
  EXPECT_THAT(program.said_until("Ctrl-C ends it."), HasSubstr("Larger pictures of 1 home "));
  wait_for([&] { return !std::filesystem::exists(part) && size() == 96; });
  EXPECT_EQ(size(), 96U);
}

TEST_F(FirstVisit, TwoHomesAreMadeAlsoAfterAKill) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the light of homes takes too long with a sanitizer";
#endif
  const std::filesystem::path first = "enfilade-demo/two-homes/store/home0001.enfilade";
  program_.add({"--faces", "64"});  // and none beside
  program_.launch();
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(10);
  while (!std::filesystem::exists(first) && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  program_.kill();
  const auto made = std::filesystem::last_write_time(first);
  program_.start(std::chrono::minutes(10));
  EXPECT_EQ(std::filesystem::last_write_time(first), made) << "made again";
  EXPECT_THAT(program_.said_until("Ctrl-C ends it."),
              AllOf(HasSubstr("home 1 of 2 is made\nhome 2 of 2 is made\n"),
                    ::testing::Not(HasSubstr("Larger pictures"))));
  const nlohmann::json scans = get("/api/v1/scans");
  EXPECT_EQ(scans.at("synthetic"), true);
  EXPECT_EQ(scans.at("scans").size(), 2U);
  for (const char* split : {"train", "val_seen", "val_unseen"}) {
    EXPECT_FALSE(get("/api/v1/splits/" + std::string(split) + "/episodes").at("episodes").empty());
  }
  expect_two_agents();
  program_.kill();
  const auto before = std::chrono::steady_clock::now();
  program_.start();
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(20)) << "at once";
  expect_two_agents();
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
