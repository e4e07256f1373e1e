// Programs write into folders where another user has put links, and read data whose names are
// paths: nothing outside of the folder changes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/core/file.h"
#include "tests/support/folder_content.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

int run(Words words) {
  words.insert(words.begin(), EN_PROGRAM);
  return Process(std::move(words)).wait();
}

/// Synthetic homes without pictures, for all tests.
const fs::path& homes() {
  static const TemporaryFolder kFolder("planted_links");
  static const fs::path kHomes = [] {
    EXPECT_EQ(run({"homes", "-o", kFolder.path() / "homes", "--preset", "graphs", "--homes", "6"}),
              0);
    return kFolder.path() / "homes";
  }();
  return kHomes;
}

class PlantedLinks : public ::testing::Test {
 protected:
  TemporaryFolder temp_{"planted_links"};
  fs::path outside_ = temp_.path() / "outside";
  fs::path out_ = temp_.path() / "p" / "out";

  PlantedLinks() {
    make_folder(outside_);
    make_folder(out_);
    write_file_atomically(outside_ / "kept.json", "kept");
  }
  void plant(const std::string& name, const std::string& target = "") const {
    make_folder((out_ / name).parent_path());
    fs::create_symlink(target.empty() ? outside_ : outside_ / target, out_ / name);
  }
  void expect_nothing_outside() const {
    EXPECT_EQ(content_of(outside_).size(), 1U);
    EXPECT_EQ(read_file(outside_ / "kept.json"), "kept");
  }
};

struct Form {
  const char* name;
  const char* link;  ///< a file that the form writes
  Words more = {};
};

// `true` stands for Python, whose half of networkx does not run.
TEST_F(PlantedLinks, AreNotFollowedByExports) {
  plant("distances");
  EXPECT_EQ(run({"export", "--as", "networkx", "--data", homes(), "-o", out_, "--python", "true"}),
            3);
  expect_nothing_outside();
  // Links in place of files are replaced.
  for (const Form& form : {Form{"navgpt", "home0001_navigable.json"},
                           Form{"duet-candidates", "scanvp_candview_relangles.json"},
                           Form{"langnav", "adj_loc_dict.json"},
                           Form{"networkx", "paths/home0001.json", {"--python", "true"}}}) {
    SCOPED_TRACE(form.name);
    fs::remove_all(out_);
    plant(form.link, "kept.json");
    Words words{"export", "--as", form.name, "--data", homes(), "-o", out_};
    words.insert(words.end(), form.more.begin(), form.more.end());
    EXPECT_EQ(run(words), 0);
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(out_ / form.link)));
    expect_nothing_outside();
  }
}

TEST_F(PlantedLinks, AreNotFollowedByAsk) {
  const Words data{"--data", homes(), "--split", "val_unseen", "--subset", "2"};
  const auto ask = [&data](Words words) {
    words.insert(words.begin(), "ask");
    words.insert(words.end(), data.begin(), data.end());
    return run(words);
  };
  if (ask({"--list"}) != 0) GTEST_SKIP() << "built without EN_WITH_WEB";
  const Words walk{"--stand-in", "oracle", "-o", out_};
  for (const char* folder : {"cache", "transcripts"}) {
    SCOPED_TRACE(folder);
    plant(folder);
    EXPECT_EQ(ask(walk), 3);
    expect_nothing_outside();
    fs::remove(out_ / folder);
  }
  // Links in place of files are replaced, those in place of the cache's folders refused.
  for (const char* file : {"run.json", "results.json", "usage.json"}) plant(file, "made.json");
  ASSERT_EQ(ask(walk), 0);
  for (const char* file : {"run.json", "results.json", "usage.json"}) {
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(out_ / file))) << file;
  }
  expect_nothing_outside();
  const Words names = [this] {
    Words all;
    for (const auto& one : fs::directory_iterator(out_ / "cache")) {
      all.push_back(one.path().filename());
    }
    return all;
  }();
  ASSERT_FALSE(names.empty());
  fs::remove_all(out_);
  for (const std::string& name : names) plant("cache/" + name);
  EXPECT_EQ(ask(walk), 3);
  expect_nothing_outside();
}

TEST_F(PlantedLinks, AreNotFollowedByHomes) {
  fs::copy(homes(), out_, fs::copy_options::recursive);
  for (const char* folder : {"connectivity", "regions", "r2r"}) {
    SCOPED_TRACE(folder);
    fs::rename(out_ / folder, out_.parent_path() / folder);
    plant(folder);
    EXPECT_EQ(run({"homes", "-o", out_, "--preset", "graphs", "--homes", "6"}), 3);
    expect_nothing_outside();
    fs::remove(out_ / folder);
    fs::rename(out_.parent_path() / folder, out_ / folder);
  }
  // The list of another's annotations names files outside, by their path and through a link.
  const std::string list = read_file(out_ / "annotations.txt");
  plant("link");
  for (const char* name : {"../../outside/kept.json", "link/kept.json"}) {
    write_file_atomically(out_ / "annotations.txt", list + name + "\n");
    EXPECT_EQ(run({"homes", "-o", out_, "--preset", "graphs", "--homes", "6"}), 3) << name;
    expect_nothing_outside();
  }
}

/// A room of 6 x 5 x 3 m, and a graph of one viewpoint in it.
void write_room(const fs::path& folder, const std::string& viewpoint) {
  write_file_atomically(folder / "room.obj",
                        "v 0 0 0\nv 6 0 0\nv 6 5 0\nv 0 5 0\nv 0 0 3\nv 6 0 3\nv 6 5 3\nv 0 5 3\n"
                        "f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n");
  write_file_atomically(
      folder / "room_connectivity.json",
      "[{\"image_id\": \"" + viewpoint +
          "\", \"pose\": [1,0,0,3, 0,0,1,2.5, 0,-1,0,1.5, 0,0,0,1], \"included\": true, "
          "\"visible\": [false], \"unobstructed\": [false], \"height\": 1.5}]");
}

TEST_F(PlantedLinks, AndIdsThatArePathsAreNotFollowedByScanMesh) {
  const Words scan{"scan-mesh", temp_.path() / "room.obj",
                   "--up",      "z",
                   "--scan",    "room",
                   "--graph",   temp_.path() / "room_connectivity.json",
                   "-o",        out_,
                   "--parts",   "skybox",
                   "--size",    "16"};
  write_room(temp_.path(), "../../../../../../outside/x");
  EXPECT_NE(run(scan), 0);
  expect_nothing_outside();
  EXPECT_TRUE(fs::is_empty(out_));

  write_room(temp_.path(), "a");
  plant("v1/scans/room/matterport_skybox_images");
  EXPECT_EQ(run(scan), 3);
  expect_nothing_outside();
  fs::remove_all(out_);
  EXPECT_EQ(run(scan), 0) << "without the link";
}

TEST_F(PlantedLinks, AreNotFollowedInModels) {
  const fs::path model = temp_.path() / "model";
  const Words train{"train",    "--data",           homes(), "-o",      model, "--inputs",
                    "language", "--iterations",     "1",     "--batch", "2",   "--hidden",
                    "8",        "--evaluate-every", "1"};
  if (run(train) != 0) GTEST_SKIP() << "this build has no libtorch";
  fs::remove_all(model / "results");
  fs::create_directory_symlink(outside_, model / "results");
  const Words evaluate{"evaluate", model, "--data", homes(), "--split", "val_unseen"};
  EXPECT_EQ(run(evaluate), 3);
  expect_nothing_outside();
  fs::remove(model / "results");
  EXPECT_EQ(run(evaluate), 0) << "without the link";
}

// Kills while networkx's files are written, and what they leave.
TEST_F(PlantedLinks, AndPartsOfKilledExportsAreNotKept) {
  const Words words{"export", "--as", "networkx", "--data", homes(),
                    "-o",     out_,   "--python", "true"};
  ASSERT_EQ(run(words), 0);
  const auto whole = content_of(out_);
  const fs::path half = out_ / "distances" / "home0004.json.part999999999";
  write_file_atomically(half, "half");
  write_file_atomically(out_ / "data.tar.part999999999", "a user's");
  ASSERT_EQ(run(words), 0);
  EXPECT_FALSE(fs::exists(half));
  EXPECT_EQ(content_of(out_).size(), whole.size() + 1) << "the user's stays";
}

TEST_F(PlantedLinks, AndAnEmptyNameIsNoFile) {
  for (const Words& words : {Words{"run", "--data", homes(), "--split", "val_unseen", "-o", ""},
                             Words{"stats", "--data", ""}, Words{"score", "", "--data", homes()},
                             Words{"export", "--as", "navgpt", "--data", homes(), "-o", ""}}) {
    EXPECT_EQ(run(words), 2) << words[0];
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
