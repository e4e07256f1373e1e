#include "enfilade/homes/home_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/graph/check.h"
#include "enfilade/graph/corrections.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/scan/regions.h"
#include "enfilade/scan/store.h"
#include "enfilade/tasks/annotations.h"
#include "tests/support/emulated.h"
#include "tests/support/folder_content.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::homes {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using tests::content_of;
using tests::TemporaryFolder;

HomeSetOptions tiny(std::size_t homes, std::uint32_t face_size) {
  HomeSetOptions options;
  options.homes = homes;
  options.kind = HomeKind::kFlat;
  options.least_area = options.most_area = 60;
  options.face_size = face_size;
  options.samples = 1;
  return options;
}

// A folder of corrections of the first home.
void correct(const fs::path& folder, const std::vector<graph::Correction>& list) {
  fs::create_directories(folder);
  write_file_atomically(folder / "home0001_corrections.json", graph::to_json({"home0001", list}));
}

graph::NavGraph graph_of(const fs::path& folder, const std::string& scan) {
  return graph::NavGraph(scan::load_connectivity(folder / "connectivity", scan));
}

TEST(HomeSet, HasPicturesAtEveryViewpointAndTheSameBytesAgain) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  const TemporaryFolder a("homes_a"), b("homes_b");
  const auto homes = write_homes(a.path(), tiny(1, 8)).homes;
  ASSERT_EQ(homes.size(), 1U);
  EXPECT_GT(homes[0].viewpoints, 5U);
  const auto store = scan::Store::open(scan::store_file(a.path() / "store", homes[0].scan));
  EXPECT_EQ(store->size(), homes[0].viewpoints);
  EXPECT_TRUE(store->verify().empty());
  for (std::size_t v = 0; v < store->size(); ++v) {
    EXPECT_EQ(store->face_sizes(ViewpointIndex(v)), (scan::FaceSizes{8, 8, 8, 8}));
  }
  HomeSetOptions one_thread = tiny(1, 8);
  one_thread.threads = 1;
  write_homes(b.path(), one_thread);
  EXPECT_EQ(content_of(a.path()), content_of(b.path()));
}

TEST(HomeSet, GoesOnWhereItWasAndRefusesWhatIsNotItsOwn) {
  const TemporaryFolder folder("homes");
  write_homes(folder.path(), tiny(1, 0));
  const auto whole = content_of(folder.path());
  // Killed after the graph was written and before the list was.
  fs::remove(folder.path() / "homes.json");
  write_homes(folder.path(), tiny(1, 0));
  EXPECT_EQ(content_of(folder.path()), whole);
  EXPECT_THROW(write_homes(folder.path(), tiny(2, 0)), FileError);

  const TemporaryFolder other("homes_other");
  write_file_atomically(other.path() / "thesis.tex", "years of work");
  EXPECT_THROW(write_homes(other.path(), tiny(1, 0)), FileError);
  EXPECT_THROW(write_homes(other.path() / "new", tiny(0, 0)), ArgumentError);
  write_file_atomically(folder.path() / "homes.json", "{\"format\": \"enfilade-homes\"}");
  EXPECT_THROW(read_home_list(folder.path()), InvalidInput);
}

std::uint32_t face_size(const fs::path& folder, const std::string& scan) {
  const auto store = scan::Store::open(scan::store_file(folder / "store", scan));
  EXPECT_TRUE(store->verify().empty()) << scan;
  return store->face_sizes(ViewpointIndex(0))[index(scan::Layer::kColour)];
}

TEST(EnlargedPictures, AreThoseOfASetThatWasMadeWithThem) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  const TemporaryFolder small("homes"), large("homes_large");
  write_homes(small.path(), tiny(1, 8));
  write_homes(large.path(), tiny(1, 16));
  auto should = content_of(small.path());
  const auto before = scan::Store::open(scan::store_file(small.path() / "store", "home0001"));
  const auto seen = scan::read_panorama(*before, ViewpointIndex(0));
  EXPECT_THAT(enlarge_pictures(small.path(), 16, 2), ::testing::ElementsAre("home0001"));
  EXPECT_EQ(face_size(small.path(), "home0001"), 16U);
  should["store/home0001.enfilade"] = content_of(large.path()).at("store/home0001.enfilade");
  EXPECT_EQ(content_of(small.path()), should) << "nothing else changes, and nothing is left over";
  // Who had the old store open goes on reading it.
  EXPECT_EQ(scan::read_panorama(*before, ViewpointIndex(0)).colour[0].pixels,
            seen.colour[0].pixels);
  EXPECT_TRUE(enlarge_pictures(small.path(), 16, 2).empty()) << "once";
  EXPECT_TRUE(enlarge_pictures(small.path(), 8, 2).empty()) << "never smaller";
  EXPECT_EQ(write_homes(small.path(), tiny(1, 8)).homes.size(), 1U) << "its options are the same";
  EXPECT_EQ(face_size(small.path(), "home0001"), 16U);
}

TEST(EnlargedPictures, AreOfPrettyHomesWhereThereAreAny) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  const TemporaryFolder folder("homes");
  write_homes(folder.path(), tiny(2, 8));
  const fs::path list = folder.path() / "homes.json";
  auto json = nlohmann::ordered_json::parse(read_file(list));
  json["options"]["pretty"] = 1;
  write_file_atomically(list, json.dump());
  EXPECT_THAT(enlarge_pictures(folder.path(), 12, 2), ::testing::ElementsAre("home0001"));
  EXPECT_EQ(face_size(folder.path(), "home0002"), 8U) << "it is for training";
}

TEST(EnlargedPictures, AreNotThoseOfAnotherHome) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  const TemporaryFolder folder("homes"), without("homes_without");
  write_homes(folder.path(), tiny(1, 8));
  const fs::path list = folder.path() / "homes.json";
  auto json = nlohmann::ordered_json::parse(read_file(list));
  json["homes"][0]["triangles"] = 12;
  write_file_atomically(list, json.dump());
  EXPECT_THAT(tests::refusal<FileError>([&] { enlarge_pictures(folder.path(), 16, 2); }),
              HasSubstr("makes another home0001"));
  EXPECT_EQ(face_size(folder.path(), "home0001"), 8U);
  EXPECT_THROW(enlarge_pictures(folder.path(), 0, 2), ArgumentError);
  EXPECT_THROW(enlarge_pictures(without.path(), 16, 2), FileError) << "no list of homes";
  write_homes(without.path(), tiny(1, 0));
  EXPECT_TRUE(enlarge_pictures(without.path(), 16, 2).empty()) << "without pictures";
}

// A shard that begins beside another sees its first file half written, or what is left of a kill.
TEST(HomeSet, AFolderWithNothingButUnfinishedFilesIsEmpty) {
  const TemporaryFolder folder("homes");
  write_file_atomically(folder.path() / "README.md.part999999999", "half");
  write_homes(folder.path(), tiny(1, 0));
  EXPECT_EQ(read_home_list(folder.path()).size(), 1U);
}

TEST(HomeSet, SomeHomesHaveStairsIfAskedFor) {
  const TemporaryFolder folder("homes"), flats("flats");
  HomeSetOptions options = tiny(3, 0);
  options.stairs_every = 2;
  EXPECT_EQ(write_homes(flats.path(), options).homes[1].plan.area, 60) << "flats have no stairs";
  options.kind.reset();
  options.homes = 4;
  const auto homes = write_homes(folder.path(), options).homes;
  for (std::size_t i = 0; i < homes.size(); ++i) {
    const bool upstairs = std::ranges::any_of(
        homes[i].rooms, [](const RoomEntry& r) { return r.storey == 1 && !r.viewpoints.empty(); });
    EXPECT_EQ(upstairs, i % 2 == 1) << homes[i].scan;
    if (upstairs) {
      EXPECT_TRUE(homes[i].kind == "house" || homes[i].kind == "office");
    }
  }
  EXPECT_EQ(home_set_preset("demo").stairs_every, 8U);
  options.stairs_every = 0;
  EXPECT_THROW(write_homes(folder.path(), options), FileError) << "another set";
}

TEST(HomeSet, KeepsHomesMadeBeforeAFailure) {
  const TemporaryFolder folder("homes"), whole("homes");
  struct Stopped {};
  EXPECT_THROW(write_homes(folder.path(), tiny(3, 0),
                           [](const std::string& home, std::size_t, std::size_t) {
                             if (home == "home0003") throw Stopped();
                           }),
               Stopped);
  EXPECT_EQ(read_home_list(folder.path()).size(), 2U);
  std::vector<std::string> made;
  write_homes(folder.path(), tiny(3, 0), [&](const std::string& home, std::size_t, std::size_t) {
    if (made.empty() || made.back() != home) made.push_back(home);
  });
  EXPECT_THAT(made, ::testing::ElementsAre("home0003"));
  write_homes(whole.path(), tiny(3, 0));
  EXPECT_EQ(content_of(folder.path()), content_of(whole.path()));
}

// Takes what earlier versions did not write out of a folder's list.
void make_old(const fs::path& folder) {
  auto list = nlohmann::ordered_json::parse(read_file(folder / "homes.json"));
  for (auto& home : list["homes"]) {
    home.erase("lines");
    for (auto& room : home["rooms"]) {
      room.erase("floor");
      room.erase("elevation");
    }
  }
  write_file_atomically(folder / "homes.json", list.dump(1));
}

TEST(HomeSet, ListsHavePlansAndThoseOfEarlierVersionsAreCompleted) {
  const TemporaryFolder folder("homes");
  HomeSetOptions options = tiny(2, 0);
  options.kind = HomeKind::kHouse;
  options.least_area = options.most_area = 0;
  options.stairs_every = 2;
  const HomeEntry made = write_homes(folder.path(), options).homes[1];
  const Plan plan = make_plan(made.plan);
  ASSERT_EQ(made.rooms.size(), plan.rooms.size());
  for (std::size_t r = 0; r < plan.rooms.size(); ++r) {
    EXPECT_NEAR(made.rooms[r].floor.x0, plan.rooms[r].floor.x0, 0.0005);
    EXPECT_NEAR(made.rooms[r].floor.y1, plan.rooms[r].floor.y1, 0.0005);
    EXPECT_NEAR(made.rooms[r].elevation, plan.storeys[plan.rooms[r].storey].floor, 0.0005);
  }
  ASSERT_EQ(made.lines.storeys.size(), 2U);
  using Kind = draw::UnderlayLine::Kind;
  for (const Kind kind : {Kind::kThing, Kind::kStairs, Kind::kWindow, Kind::kDoor, Kind::kWall}) {
    EXPECT_TRUE(std::ranges::count(made.lines.storeys[0].lines, kind, &draw::UnderlayLine::kind));
  }

  const auto whole = content_of(folder.path());
  make_old(folder.path());
  const HomeEntry old = read_home_list(folder.path())[1];
  EXPECT_TRUE(old.lines.storeys.empty());
  EXPECT_EQ(old.rooms[0].floor.area(), 0);
  HomeEntry another = old;
  ++another.triangles;
  EXPECT_THAT(tests::refusal<FileError>([&] { completed(another, folder.path()); }),
              HasSubstr("home0002 has " + std::to_string(another.triangles) + " triangles"));
  const HomeEntry again = completed(old, folder.path());
  EXPECT_EQ(again.rooms[0].floor.x0, made.rooms[0].floor.x0);
  EXPECT_EQ(again.lines.storeys[0].lines.size(), made.lines.storeys[0].lines.size());
  write_homes(folder.path(), options, [](const std::string& home, std::size_t, std::size_t) {
    ADD_FAILURE() << home << " is made again";
  });
  EXPECT_EQ(content_of(folder.path()), whole);
  const auto time = fs::last_write_time(folder.path() / "homes.json");
  write_homes(folder.path(), options);
  EXPECT_EQ(fs::last_write_time(folder.path() / "homes.json"), time) << "nothing is new in it";
}

TEST(HomeSet, SharesMakeTheSameSetInAnyOrder) {
  const TemporaryFolder whole("homes"), shared("homes");
  write_homes(whole.path(), tiny(5, 0));
  HomeSetOptions share = tiny(5, 0);
  share.shard = {1, 2};
  const auto second = write_homes(shared.path(), share).homes;
  ASSERT_EQ(second.size(), 2U);
  EXPECT_EQ(second[0].scan, "home0002");
  EXPECT_EQ(second[1].scan, "home0004");
  EXPECT_TRUE(read_home_list(shared.path()).empty()) << "gathered by a run of the whole set";
  // Made by the third of three: the third home; the first is left to the run of the whole set.
  share.shard = {2, 3};
  EXPECT_EQ(write_homes(shared.path(), share).homes.size(), 1U);
  share.shard = {4, 5};
  EXPECT_EQ(write_homes(shared.path(), share).homes.size(), 1U);
  std::size_t steps = 0;
  write_homes(shared.path(), tiny(5, 0), [&](const std::string& home, std::size_t, std::size_t) {
    EXPECT_EQ(home, "home0001");
    ++steps;
  });
  EXPECT_GT(steps, 0U);
  EXPECT_EQ(content_of(shared.path()), content_of(whole.path()));
  share.shard = {2, 2};
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { write_homes(shared.path(), share); }),
              HasSubstr("shard: index 2 of 2"));
}

TEST(HomeSet, CorrectionsAreAppliedOnTopAndTakenBack) {
  const TemporaryFolder folder("homes"), corrections("corrections"), fresh("homes");
  HomeSetOptions options = tiny(2, 0);
  write_homes(folder.path(), options);
  const auto as_found = content_of(folder.path());
  const graph::NavGraph found = graph_of(folder.path(), "home0001");
  const ViewpointIndex a(0), b = found.edges(a)[0].target;
  using Action = graph::Correction::Action;
  correct(corrections.path(),
          {{Action::kRemoveEdge, found.id(a), found.id(b), "Ada", "a rope", ""},
           {Action::kExclude, found.id(ViewpointIndex(3)), "", "Ben", "in a cupboard", ""},
           {Action::kInclude, found.id(a), "", "Ben", "it is", ""}});
  options.corrections = corrections.path();
  const HomeSetReport report = write_homes(folder.path(), options);
  ASSERT_EQ(report.notes.size(), 1U);
  EXPECT_EQ(report.notes[0].where, "$.corrections[2]");
  const graph::NavGraph corrected = graph_of(folder.path(), "home0001");
  EXPECT_EQ(corrected.edge(a, b), nullptr);
  EXPECT_FALSE(corrected.included(ViewpointIndex(3)));
  EXPECT_EQ(report.homes[0].viewpoints, found.included_count() - 1);
  EXPECT_EQ(read_home_list(folder.path())[0].edges, corrected.edge_count() / 2);
  EXPECT_EQ(read_home_list(folder.path())[1].corrections, "");
  // The same as if they had been there from the start; and without them as if they never had been.
  write_homes(fresh.path(), options);
  EXPECT_EQ(content_of(fresh.path()), content_of(folder.path()));
  const fs::path file = corrections.path() / "home0001_corrections.json";
  write_file_atomically(file.string() + ".gz", gzip("{}", 6));
  write_homes(fresh.path(), options);
  EXPECT_EQ(content_of(fresh.path()), content_of(folder.path())) << "the plain file counts";
  write_file_atomically(file.string() + ".gz", gzip(read_file(file), 6));
  fs::remove(file);
  write_homes(fresh.path(), options);
  EXPECT_EQ(content_of(fresh.path()), content_of(folder.path())) << "packed";
  options.corrections.clear();
  write_homes(folder.path(), options);
  EXPECT_EQ(content_of(folder.path()), as_found);
}

TEST(HomeSet, AHalfCorrectedGraphIsCorrectedAgain) {
  const TemporaryFolder folder("homes"), corrections("corrections");
  HomeSetOptions options = tiny(1, 0);
  write_homes(folder.path(), options);
  const auto as_found = content_of(folder.path());
  correct(corrections.path(),
          {{graph::Correction::Action::kExclude, "nobody", "", "Ada", "a rope", ""}});
  options.corrections = corrections.path();
  // What a killed run leaves, too: the list says that the graph's state is unknown.
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { write_homes(folder.path(), options); }),
              HasSubstr("$.corrections[0].from: \"nobody\" is no viewpoint of home0001"));
  EXPECT_EQ(read_home_list(folder.path())[0].corrections, "unfinished");
  write_file_atomically(folder.path() / "connectivity" / "home0001_connectivity.json", "[]");
  options.corrections.clear();
  write_homes(folder.path(), options);
  EXPECT_EQ(content_of(folder.path()), as_found);
}

TEST(HomeSet, CoarseLightIsInTheListAndMakesOtherPicturesOfTheSameHome) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  const TemporaryFolder fine("homes_fine"), coarse("homes_coarse");
  HomeSetOptions options = tiny(1, 8);
  write_homes(fine.path(), options);
  options.light = HomeLight::kCoarse;
  EXPECT_THAT(tests::refusal<FileError>([&] { write_homes(fine.path(), options); }),
              HasSubstr(R"(light: "fine" there, "coarse" asked for)"));
  write_homes(coarse.path(), options);
  write_homes(coarse.path(), options);  // the list is read again
  const auto file = [](const TemporaryFolder& folder, const char* name) {
    return read_file(folder.path() / name);
  };
  const char* graph = "connectivity/home0001_connectivity.json";
  EXPECT_EQ(file(coarse, graph), file(fine, graph));
  EXPECT_NE(file(coarse, "store/home0001.enfilade"), file(fine, "store/home0001.enfilade"));
  EXPECT_THROW(parse_home_light("bright"), ArgumentError);
}

TEST(HomeSet, PrettyHomesAreThoseOfValUnseenFirst) {
  const TemporaryFolder folder("homes");
  HomeSetOptions options = home_set_preset("graphs");
  EXPECT_TRUE(pretty_homes(options).empty());
  options.pretty = 1;
  EXPECT_TRUE(pretty_homes(options).empty()) << "there are no pictures";
  write_homes(folder.path(), options);
  EXPECT_EQ(read_home_options(folder.path()).pretty, 1U);
  write_home_paths(folder.path(), {.per_home = 5, .tasks = {}});
  const scan::DataRoot data(folder.path());
  const auto scans_of = [&](const char* split) {
    std::set<std::string> scans;
    for (const auto& path : tasks::load_annotations(data.annotations(split), split).paths) {
      scans.insert(path.scan);
    }
    return scans;
  };
  options.face_size = 8;
  const auto pretty = [&](std::size_t n) {
    options.pretty = n;
    const std::vector<std::string> scans = pretty_homes(options);
    EXPECT_TRUE(std::ranges::is_sorted(scans));
    return std::set<std::string>(scans.begin(), scans.end());
  };
  std::set<std::string> expected = scans_of("val_unseen");
  ASSERT_EQ(expected.size(), 1U);
  EXPECT_EQ(pretty(1), expected);
  expected.merge(scans_of("train"));
  EXPECT_EQ(pretty(expected.size()), expected) << "those of test come last";
  EXPECT_EQ(pretty(6).size(), 6U);
}

TEST(HomeSet, APrettyHomeIsFinerThanTheOthers) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  const TemporaryFolder folder("homes");
  HomeSetOptions options = tiny(2, 8);
  options.light = HomeLight::kCoarse;
  options.pretty = 1;
  write_homes(folder.path(), options);
  const auto faces = [&](const char* scan) {
    return scan::Store::open(scan::store_file(folder.path() / "store", scan))
        ->face_sizes(ViewpointIndex(0))[0];
  };
  EXPECT_EQ(pretty_homes(options), std::vector<std::string>{"home0001"});
  EXPECT_EQ(faces("home0001"), kPrettyFaceSize);
  EXPECT_EQ(faces("home0002"), 8U);
  EXPECT_THAT(read_file(folder.path() / "README.md"),
              HasSubstr("but of 256 and finer light in home0001"));
  options.pretty = 0;
  EXPECT_THROW(write_homes(folder.path(), options), FileError) << "another set";
}

TEST(HomeSet, TheDemosSetHasManyHomesToLearnFromAndSomeToLookAt) {
  const HomeSetOptions demo = home_set_preset("demo"), training = home_set_preset("training");
  EXPECT_GE(demo.homes, 60U);
  EXPECT_EQ(demo.face_size, training.face_size);
  EXPECT_EQ(demo.light, HomeLight::kCoarse);
  EXPECT_EQ(pretty_homes(demo).size(), 3U);
  const HomeSetOptions pretty = home_set_preset("pretty");
  EXPECT_EQ(pretty.face_size, kPrettyFaceSize);
  EXPECT_EQ(pretty.samples, kPrettySamples);
  EXPECT_EQ(pretty.light, HomeLight::kFine);
}

TEST(HomeSet, RefusesOptionsOutOfRangeBeforeItMakesAFolder) {
  const TemporaryFolder made("homes");
  const fs::path folder = made.path() / "new";
  const auto refused = [&](auto change) {
    HomeSetOptions options = tiny(1, 0);
    change(options);
    return tests::refusal<ArgumentError>([&] { write_homes(folder, options); });
  };
  EXPECT_EQ(refused([](auto& o) { o.homes = 10001; }), "homes: 10001, not from 1 to 10000");
  EXPECT_EQ(refused([](auto& o) { o.most_area = 3001; }),
            "area: 60 to 3001 m2, not a range within 60 to 3000, or 0");
  EXPECT_THAT(refused([](auto& o) { o.least_area = 59; }), HasSubstr("area: 59 to 60 m2"));
  EXPECT_EQ(refused([](auto& o) { o.samples = 3; }), "samples: 3, not 1, 4, 9 or 16");
  EXPECT_EQ(refused([](auto& o) { o.face_size = 4097; }), "face_size: 4097, not from 0 to 4096");
  EXPECT_EQ(refused([](auto& o) { o.pretty = 2; }), "pretty: 2, not from 0 to 1");
  EXPECT_FALSE(fs::exists(folder));
}

TEST(HomeSet, WithoutPicturesReadsBackWithNothingOdd) {
  const TemporaryFolder folder("homes");
  HomeSetOptions options = home_set_preset("graphs");
  options.homes = 3;
  write_homes(folder.path(), options);
  write_home_paths(folder.path(), {});
  const scan::DataRoot data(folder.path());
  const auto reports = graph::check_folder(data.connectivity());
  ASSERT_EQ(reports.size(), 4U);  // the last is the graph that other code asks for by name
  for (const auto& report : std::span(reports).first(3)) {
    EXPECT_TRUE(report.diagnostics.empty()) << report.scan;
  }
  EXPECT_EQ(reports[3].scan, "ZMojNkEp431");
  ASSERT_EQ(reports[3].diagnostics.size(), 1U);
  EXPECT_EQ(reports[3].diagnostics[0].code, "unlisted-file");
  EXPECT_FALSE(fs::exists(folder.path() / "store"));
  const auto graphs = graph::GraphSet::open(data.connectivity());
  const scan::RegionMap regions = scan::RegionMap::load(data.regions());
  for (const char* split : {"train", "val_seen", "val_unseen"}) {
    SCOPED_TRACE(split);
    const auto episodes =
        tasks::make_episodes(tasks::load_annotations(data.annotations(split), split), graphs);
    EXPECT_FALSE(episodes.paths.empty());
    for (const tasks::ReferencePath& path : episodes.paths) {
      const graph::NavGraph& graph = graphs->graph(path.scan);
      const ViewpointIndex from = path.viewpoints.front(), to = path.viewpoints.back();
      EXPECT_EQ(path.viewpoints.size(), std::clamp<std::size_t>(path.viewpoints.size(), 5, 7));
      EXPECT_GE(graph.distance(from, to), 5.0);
      EXPECT_NE(regions.find(graph.scan(), graph.id(from)),
                regions.find(graph.scan(), graph.id(to)));
    }
  }
}

TEST(HomeSet, PathsHaveThreeInstructionsAndHiddenGoals) {
  const TemporaryFolder folder("homes");
  write_homes(folder.path(), tiny(3, 0));
  HomePathOptions options;
  options.per_home = 6;
  const HomePathReport report = write_home_paths(folder.path(), options);
  EXPECT_GT(report.paths, 6U);
  EXPECT_EQ(report.instructions, 3 * report.paths);
  const scan::DataRoot data(folder.path());
  const auto test = tasks::load_annotations(data.annotations("test"), "test");
  const auto hidden = tasks::load_annotations(folder.path() / "hidden" / "R2R_test.json", "test");
  ASSERT_EQ(test.paths.size(), hidden.paths.size());
  for (std::size_t i = 0; i < test.paths.size(); ++i) {
    EXPECT_EQ(test.paths[i].path.size(), 1U);
    EXPECT_GT(hidden.paths[i].path.size(), 4U);
    EXPECT_EQ(test.paths[i].instructions, hidden.paths[i].instructions);
    EXPECT_EQ(test.paths[i].instructions.size(), 3U);
  }
}

TEST(HomeSet, TwoHomesAreEnoughWithoutATestSplit) {
  const TemporaryFolder folder("homes");
  HomeSetOptions two = home_set_preset("graphs");
  two.homes = 2;
  write_homes(folder.path(), two);
  HomePathOptions options;
  options.per_home = 20;
  EXPECT_THROW(write_home_paths(folder.path(), options), FileError);
  options.test_split = false;
  write_home_paths(folder.path(), options);
  const scan::DataRoot data(folder.path());
  std::map<std::string, std::set<std::string>> scans;
  for (const char* split : {"train", "val_seen", "val_unseen"}) {
    for (const auto& path : tasks::load_annotations(data.annotations(split), split).paths) {
      scans[split].insert(path.scan);
      EXPECT_EQ(path.instructions.size(), 3U);
    }
  }
  EXPECT_EQ(scans["train"].size(), 1U);
  EXPECT_EQ(scans["val_seen"], scans["train"]);
  EXPECT_EQ(scans["val_unseen"].size(), 1U);
  EXPECT_NE(scans["val_unseen"], scans["train"]);
  EXPECT_FALSE(fs::exists(folder.path() / "r2r" / "R2R_test.json"));
  EXPECT_FALSE(fs::exists(folder.path() / "hidden"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes
