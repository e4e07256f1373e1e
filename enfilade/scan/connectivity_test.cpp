#include "enfilade/scan/connectivity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/scan/data_root.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::scan {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Connectivity three_in_a_row() {
  Connectivity c{"row", "<memory>", {}};
  for (std::size_t i = 0; i < 3; ++i) {
    ConnectivityEntry entry;
    entry.id = std::string(1, static_cast<char>('a' + i));
    entry.pose = {1, 0, 0, 2.5 * static_cast<double>(i), 0, 1, 0, 0, 0, 0, 1, 1.5, 0, 0, 0, 1};
    entry.height = 1.5;
    c.entries.push_back(entry);
  }
  c.entries[0].unobstructed = {ViewpointIndex(1)};
  c.entries[1].unobstructed = {ViewpointIndex(0), ViewpointIndex(2)};
  c.entries[2].unobstructed = {ViewpointIndex(1)};
  c.entries[0].visible = {ViewpointIndex(1), ViewpointIndex(2)};
  c.entries[2].included = false;
  return c;
}

std::string faults_of(const std::string& text) {
  try {
    parse_connectivity(text, "s", "s.json");
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

std::string edited(const std::string& from, const std::string& to) {
  std::string text = to_json(three_in_a_row());
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Connectivity, ReadsWhatItWrites) {
  const Connectivity written = three_in_a_row();
  const Connectivity read = parse_connectivity(to_json(written), "row", "row.json");
  ASSERT_EQ(read.entries.size(), 3U);
  EXPECT_EQ(read.entries[1].position(), (Vec3d{2.5, 0, 1.5}));
  EXPECT_THAT(read.entries[1].unobstructed, ElementsAre(ViewpointIndex(0), ViewpointIndex(2)));
  EXPECT_THAT(read.entries[0].visible, ElementsAre(ViewpointIndex(1), ViewpointIndex(2)));
  EXPECT_FALSE(read.entries[2].included);
  EXPECT_EQ(read.entries[0].height, 1.5);
  EXPECT_EQ(to_json(read), to_json(written));
}

TEST(Connectivity, NamesFieldPlaceAndWhatIsAllowed) {
  EXPECT_THAT(faults_of("{}"), HasSubstr("s.json: $: object, not an array"));
  EXPECT_THAT(faults_of("[1]"), HasSubstr("$[0]: number 1, not an object"));
  EXPECT_THAT(faults_of(edited("\"included\":true,", "")), HasSubstr("$[0]: has no field"));
  EXPECT_THAT(faults_of(edited("true,\"visible\"", "1,\"visible\"")),
              HasSubstr("$[0].included: number 1, not true or false"));
  EXPECT_THAT(faults_of(edited("[1.0,", "[")), HasSubstr("$[0].pose: 15 numbers, not 16"));
  EXPECT_THAT(faults_of(edited("[1.0,", "[1e200,")), HasSubstr("$[0].pose[0]: 1e+200"));
  EXPECT_THAT(faults_of(edited("[false,true,true]", "[false,true]")),
              HasSubstr("$[0].visible: 2 flags, not 3"));
  EXPECT_THAT(faults_of(edited("[false,true,false]", "[false,true,0]")),
              HasSubstr("$[0].unobstructed[2]: number 0, not true or false"));
  EXPECT_THAT(faults_of(edited("\"image_id\":\"b\"", "\"image_id\":\"a\"")),
              HasSubstr("$[1].image_id: \"a\" stands at $[0] already"));
  EXPECT_THAT(faults_of(edited("\"image_id\":\"a\"", "\"image_id\":\"\"")), HasSubstr("empty id"));
  EXPECT_THAT(faults_of(edited("\"height\":1.5", "\"height\":\"tall\"")),
              HasSubstr("$[0].height: string \"tall\", not a number"));
}

TEST(Connectivity, ListsAllFaultsAtOnce) {
  const std::string all = faults_of("[{\"image_id\": 1}, 2]");
  EXPECT_THAT(all, HasSubstr("$[0]: has no field \"pose\""));
  EXPECT_THAT(all, HasSubstr("$[1]: number 2"));
}

TEST(Connectivity, HeightIsOptional) {
  EXPECT_EQ(faults_of(edited(",\"height\":1.5", "")), "accepted");
}

TEST(Connectivity, AScanIdIsNoPath) {
  EXPECT_THROW(load_connectivity(".", "../etc"), LookupError);
  EXPECT_THROW(load_connectivity(".", ""), LookupError);
  EXPECT_THROW(load_connectivity(tests::TemporaryFolder("empty").path(), "absent"), FileError);
}

TEST(IsScanId, IsANameThatIsSafeEverywhere) {
  // Matterport3D's, HM3D's, ours, Gibson's, ScanNet's.
  for (const char* id : {"17DRP5sb8fy", "00000-kfPV7w3FaU5", "home_0001", "Allensville",
                         "scene0000_00", "a.b", "_", "0"}) {
    EXPECT_TRUE(is_scan_id(id)) << id;
    EXPECT_NO_THROW(require_scan_id(id));
  }
  for (const std::string_view id : {"", ".", "..", ".hidden", "-", "-o", "my house", "a/b", "a\\b",
                                    "/", "../a", "h\xc3\xa4user", "a\nb"}) {
    EXPECT_FALSE(is_scan_id(id)) << id;
    EXPECT_THROW(require_scan_id(id), LookupError);
  }
  EXPECT_FALSE(is_scan_id(std::string_view("a\0b", 3)));
  EXPECT_TRUE(is_scan_id(std::string(100, 'a')));
  EXPECT_FALSE(is_scan_id(std::string(101, 'a')));
}

TEST(IsScanId, HasHm3dsName) {
  EXPECT_EQ(name_in_hm3d("00800-TEEsavR23oF"), "TEEsavR23oF");
  EXPECT_EQ(name_in_hm3d("00006-HkseAnWCgqk-2"), "HkseAnWCgqk-2");
  for (const char* other : {"", "00800", "00800-", "0800-TEEsavR23oF", "000800-TEEsavR23oF",
                            "val-T", "TEEsavR23oF", "00800_TEEsavR23oF", "12-room"}) {
    EXPECT_EQ(name_in_hm3d(other), "") << other;
  }
}

TEST(ScanList, RefusesWhatIsNoList) {
  const tests::TemporaryFolder made("scan_list");
  const fs::path& folder = made.path();
  const auto message = [&](const std::string& content) -> std::string {
    write_file_atomically(folder / "scans.txt", content);
    try {
      return std::to_string(load_scan_list(folder).size());
    } catch (const Error& error) {
      return error.what();
    }
  };
  EXPECT_EQ(message("a\nb\r\nc"), "3");
  EXPECT_EQ(message("\xEF\xBB\xBFroom\r\n\r\nhall\r\n"), "2");
  EXPECT_EQ(message(std::string("\xFF\xFEr\0\n\0h\0", 8)), "2");
  EXPECT_THAT(message("# ours\nroom # no comment"), HasSubstr("\"#\" is not an id"));
  EXPECT_THAT(message(" \n"), HasSubstr("lists no scan"));
  EXPECT_THAT(message("a b a"), HasSubstr("\"a\" stands in the list twice"));
  EXPECT_THAT(message("../a"), HasSubstr("is not an id"));
}

TEST(ScanList, IsLookedForOneFolderBelow) {
  const tests::TemporaryFolder made("scan_list_below");
  save_connectivity(made.path() / "connectivity", three_in_a_row());
  EXPECT_THAT([&] { load_scan_list(made.path()); },
              ::testing::ThrowsMessage<FileError>(HasSubstr("name that folder")));
}

TEST(Connectivity, SavesAGraphAndListsItsScanOnce) {
  const tests::TemporaryFolder made("saved_graphs");
  const fs::path folder = made.path() / "connectivity";
  Connectivity graph = three_in_a_row();
  save_connectivity(folder, graph);
  save_connectivity(folder, graph);
  EXPECT_EQ(read_file(folder / "scans.txt"), "row\n");
  EXPECT_EQ(load_connectivity(folder, "row").entries.size(), 3U);
  write_file_atomically(folder / "scans.txt", "a row");
  graph.scan = "b";
  save_connectivity(folder, graph);
  EXPECT_EQ(read_file(folder / "scans.txt"), "a row\nb\n");
  write_file_atomically(folder / "scans.txt", "\xEF\xBB\xBF# ours\r\nrow_connectivity.json\r\n");
  save_connectivity(folder, three_in_a_row());
  save_connectivity(folder, graph);
  EXPECT_EQ(load_scan_list(folder), (std::vector<std::string>{"row", "b"}));
  EXPECT_EQ(read_file(folder / "scans.txt"), "# ours\r\nrow_connectivity.json\r\nb\n");
}

TEST(Connectivity, MayBePacked) {
  const tests::TemporaryFolder made("packed_graph");
  save_connectivity(made.path(), three_in_a_row());
  const fs::path file = connectivity_file(made.path(), "row");
  write_file_atomically(file.string() + ".gz", gzip(read_file(file), 6));
  fs::remove(file);
  EXPECT_EQ(find_connectivity(made.path(), "row"), file.string() + ".gz");
  const Connectivity read = load_connectivity(made.path(), "row");
  EXPECT_EQ(read.entries.size(), 3U);
  EXPECT_EQ(read.file, file.string() + ".gz") << "messages name what was read";
  EXPECT_EQ(load_connectivity_file(file, "other").scan, "other");
  fs::remove(file.string() + ".gz");
  EXPECT_EQ(find_connectivity(made.path(), "row"), std::nullopt);
  EXPECT_THAT([&] { load_connectivity(made.path(), "row"); },
              ::testing::ThrowsMessage<FileError>(HasSubstr("row_connectivity.json: ")));
}

TEST(Connectivity, FilesHaveTheirScansName) {
  EXPECT_EQ(scan_of_file("some/a_b_connectivity.json"), "a_b");
  EXPECT_EQ(scan_of_file("00800-TEEsavR23oF_connectivity.json.gz"), "00800-TEEsavR23oF");
  EXPECT_EQ(scan_of_file("a.json"), std::nullopt);
}

TEST(Connectivity, BeginsABlankListOfScansAnew) {
  const tests::TemporaryFolder made("blank_list");
  for (const char* blank : {"", " \n\t\n"}) {
    write_file_atomically(made.path() / "scans.txt", blank);
    check_scan_list(made.path());
    save_connectivity(made.path(), three_in_a_row());
    EXPECT_EQ(read_file(made.path() / "scans.txt"), "row\n");
  }
}

TEST(Connectivity, IsNotSavedBesideABrokenListOfScans) {
  const tests::TemporaryFolder made("broken_list");
  const fs::path list = made.path() / "scans.txt";
  write_file_atomically(list, "a a");
  EXPECT_THROW(check_scan_list(made.path()), InvalidInput);
  EXPECT_THROW(save_connectivity(made.path(), three_in_a_row()), InvalidInput);
  fs::remove(list);
  fs::create_symlink(list, list);
  EXPECT_THAT([&] { save_connectivity(made.path(), three_in_a_row()); },
              ::testing::ThrowsMessage<FileError>(HasSubstr(list.string())));
  EXPECT_FALSE(fs::exists(connectivity_file(made.path(), "row")));
}

TEST(Connectivity, ReadsAllRealGraphs) {
  const auto data = DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real graphs";
  std::size_t viewpoints = 0;
  std::size_t included = 0;
  const auto scans = load_scan_list(data->connectivity());
  for (const std::string& scan : scans) {
    for (const auto& entry : load_connectivity(data->connectivity(), scan).entries) {
      ++viewpoints;
      included += entry.included ? 1 : 0;
    }
  }
  EXPECT_EQ(scans.size(), 90U);
  EXPECT_EQ(viewpoints, 10800U);  // as the paper counts panoramas
  EXPECT_EQ(included, 10567U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
