#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <functional>
#include <thread>

#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/jpeg_rows.h"
#include "enfilade/scan/matterport_images.h"
#include "enfilade/scan/store.h"
#include "tests/support/panoramas.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::scan {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using tests::TemporaryFolder;

PackOptions single_threaded() {
  PackOptions options;
  options.threads = 1;
  return options;
}

fs::path part_of(const fs::path& file) { return file.string() + ".part"; }

struct Stop {};

// Runs `work` in a process of its own and returns how that ended (as waitpid says it).
int in_child(const std::function<void()>& work, const std::function<void(pid_t)>& meanwhile = {}) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(0);
  }
  if (meanwhile) meanwhile(child);
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

// Eleven panoramas, and the store that an undisturbed run makes of them.
class Packing : public ::testing::Test {
 protected:
  Packing() {
    const TemporaryFolder undisturbed("store_pack_undisturbed");
    truth_ = read_file(pack(*source_, undisturbed.path(), single_threaded()).file);
  }
  PackReport run(const PackOptions& options = single_threaded()) const {
    return pack(*source_, folder_.path(), options);
  }
  // Leaves the part of a run that was ended when `done` panoramas were in it.
  void leave_part(std::size_t done) const {
    EXPECT_THROW(pack(*source_, folder_.path(), single_threaded(),
                      [&](std::size_t n, std::size_t) {
                        if (n >= done) throw Stop();
                      }),
                 Stop);
    EXPECT_TRUE(fs::exists(part_of(file_)));
    EXPECT_FALSE(fs::exists(file_));
  }
  void expect_truth() const {
    // Not EXPECT_EQ: nobody reads two stores in a log.
    EXPECT_TRUE(read_file(file_) == truth_);
    EXPECT_FALSE(fs::exists(part_of(file_)));
  }

  static constexpr std::size_t kCount = 11;
  std::shared_ptr<const MemoryPanoramas> source_ = testing::memory_panoramas("house", kCount, 16);
  TemporaryFolder folder_{"store_pack"};
  fs::path file_ = store_file(folder_.path(), "house");
  std::string truth_;
};

TEST_F(Packing, GivesTheSameBytesAtAnyNumberOfThreads) {
  for (const int threads : {0, 2, 3, 7}) {
    PackOptions options;
    options.threads = threads;
    const PackReport report = run(options);
    EXPECT_EQ(report.file, file_);
    EXPECT_EQ(report.panoramas, kCount);
    EXPECT_EQ(report.resumed, 0U);
    EXPECT_EQ(report.bytes, truth_.size());
    EXPECT_FALSE(report.was_complete);
    EXPECT_THAT(report.without, ElementsAre());
    expect_truth();
    fs::remove(file_);
  }
}

TEST_F(Packing, DoesNothingTheSecondTime) {
  run();
  const auto before = fs::last_write_time(file_);
  const PackReport report = run();
  EXPECT_TRUE(report.was_complete);
  EXPECT_EQ(report.panoramas, kCount);
  EXPECT_EQ(report.bytes, truth_.size());
  EXPECT_EQ(fs::last_write_time(file_), before);
}

TEST_F(Packing, NoticesOtherOptionsAndOtherPictures) {
  run();
  PackOptions options = single_threaded();
  options.jpeg_quality = 60;
  EXPECT_FALSE(run(options).was_complete);
  EXPECT_FALSE(run().was_complete);
  expect_truth();
  std::vector<Panorama> panoramas;
  for (std::size_t i = 0; i < kCount; ++i) panoramas.push_back(testing::panorama(16, i + 1));
  panoramas[5].instances[2].pixels[7] ^= 1;
  const MemoryPanoramas other(source_->connectivity(), std::move(panoramas));
  EXPECT_FALSE(pack(other, folder_.path(), single_threaded()).was_complete);
  Connectivity moved = source_->connectivity();
  moved.entries[3].pose[3] += 1e-9;
  std::vector<Panorama> same;
  for (std::size_t i = 0; i < kCount; ++i) same.push_back(testing::panorama(16, i + 1));
  EXPECT_FALSE(pack(MemoryPanoramas(moved, std::move(same)), folder_.path(), single_threaded())
                   .was_complete);
  EXPECT_FALSE(run().was_complete);
  expect_truth();
}

TEST_F(Packing, ReplacesADamagedStore) {
  write_file_atomically(file_, truth_.substr(0, truth_.size() - 1));
  EXPECT_FALSE(run().was_complete);
  expect_truth();
}

TEST_F(Packing, ReportsProgressUpToTheEnd) {
  std::vector<std::size_t> seen;
  pack(*source_, folder_.path(), {}, [&](std::size_t done, std::size_t total) {
    EXPECT_EQ(total, kCount);
    seen.push_back(done);
  });
  EXPECT_TRUE(std::ranges::is_sorted(seen));
  EXPECT_EQ(seen.front(), 0U);
  EXPECT_EQ(seen.back(), kCount);
}

TEST_F(Packing, GoesOnAfterBeingKilled) {
  std::size_t most_resumed = 0;
  for (const std::size_t place : {0U, 1U, 5U, 9U, 11U}) {
    const int status = in_child([&] {
      pack(*source_, folder_.path(), single_threaded(), [&](std::size_t done, std::size_t) {
        if (done >= place) raise(SIGKILL);
      });
    });
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    EXPECT_FALSE(fs::exists(file_));
    const PackReport report = run();
    EXPECT_GE(report.resumed, place);
    most_resumed = std::max(most_resumed, report.resumed);
    expect_truth();
    fs::remove(file_);
  }
  EXPECT_EQ(most_resumed, kCount);
}

TEST_F(Packing, GoesOnAfterBeingKilledAtAnyMoment) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  run();
  const auto whole_run =
      std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start);
  Rng rng(5);
  std::size_t kills = 0;
  for (int round = 0; round < 40; ++round) {
    fs::remove(file_);  // a run that came to its end; parts stay
    const std::chrono::microseconds delay(rng.below(static_cast<std::uint64_t>(whole_run.count())));
    const int status = in_child([&] { run(); },
                                [&](pid_t child) {
                                  std::this_thread::sleep_for(delay);
                                  kill(child, SIGKILL);
                                });
    if (WIFSIGNALED(status)) ++kills;
  }
  EXPECT_GT(kills, 0U);
  run();
  expect_truth();
}

TEST_F(Packing, GoesOnFromAPartThatWasCutAnywhere) {
  leave_part(kCount);
  const std::string part = read_file(part_of(file_));
  Rng rng(3);
  for (int round = 0; round < 40; ++round) {
    const std::size_t length = rng.below(part.size());
    write_file_atomically(part_of(file_), part.substr(0, length));
    const PackReport report = run();
    EXPECT_LT(report.resumed, kCount);
    expect_truth();
    fs::remove(file_);
  }
}

TEST_F(Packing, CutsOffWhatIsDamaged) {
  leave_part(kCount);
  const std::string part = read_file(part_of(file_));
  Rng rng(4);
  for (int round = 0; round < 40; ++round) {
    std::string damaged = part;
    damaged[rng.below(part.size())] ^= 4;
    if (round % 2 == 0) damaged += "rest of a record";
    write_file_atomically(part_of(file_), damaged);
    EXPECT_LT(run().resumed, kCount);
    expect_truth();
    fs::remove(file_);
  }
}

TEST_F(Packing, FinishesAPartThatLackedOnlyItsNewName) {
  write_file_atomically(part_of(file_), truth_);
  EXPECT_EQ(run().resumed, kCount);
  expect_truth();
}

TEST_F(Packing, BeginsAnewWithOtherOptions) {
  leave_part(5);
  PackOptions options = single_threaded();
  options.colour = ColourCoding::kRaw;
  EXPECT_EQ(run(options).resumed, 0U);
  EXPECT_EQ(run().resumed, 0U);
  expect_truth();
}

TEST_F(Packing, KeepsThePartWhenTheSourceFails) {
  // A store as the source, one face of which is damaged for a while.
  const TemporaryFolder broken("store_pack_broken"), undisturbed("store_pack_sound");
  const fs::path input = pack(*source_, broken.path(), single_threaded()).file;
  const std::string sound =
      read_file(pack(*Store::open(input), undisturbed.path(), single_threaded()).file);
  const auto flip = [&](std::size_t at) {
    std::string bytes = read_file(input);
    bytes[at] ^= 1;
    write_file_atomically(input, bytes);
  };
  const std::size_t late = truth_.rfind("PANORAMA") + 900;
  flip(late);
  EXPECT_THAT([&] { pack(*Store::open(input), folder_.path(), single_threaded()); },
              ThrowsMessage<InvalidInput>(HasSubstr("\"v10\"")));
  EXPECT_TRUE(fs::exists(part_of(file_)));
  flip(late);
  EXPECT_EQ(pack(*Store::open(input), folder_.path(), single_threaded()).resumed, 8U);
  EXPECT_TRUE(read_file(file_) == sound);
}

TEST_F(Packing, IsForOneProcessAtATime) {
  bool tried = false;
  pack(*source_, folder_.path(), single_threaded(), [&](std::size_t, std::size_t) {
    if (std::exchange(tried, true)) return;
    EXPECT_THAT([&] { run(); }, ThrowsMessage<FileError>(HasSubstr("another process")));
  });
  EXPECT_TRUE(tried);
  expect_truth();
}

TEST(Pack, LeavesOutPicturesOfExcludedViewpoints) {
  const TemporaryFolder folder("store_pack_excluded");
  Connectivity graph = testing::row_of_viewpoints("house", 4);
  graph.entries[1].included = graph.entries[3].included = false;
  const MemoryPanoramas source(
      graph, {testing::panorama(4, 1), testing::panorama(4, 2), {}, testing::panorama(4, 4)});
  PackOptions options;
  PackReport report = pack(source, folder.path(), options);
  EXPECT_EQ(report.panoramas, 1U);
  EXPECT_THAT(report.without, ElementsAre("v2"));
  auto store = Store::open(report.file);
  ASSERT_EQ(store->size(), 4U);
  EXPECT_FALSE(store->poses()[3].included);
  EXPECT_EQ(store->face_sizes(ViewpointIndex(3)), FaceSizes{});
  EXPECT_THAT(pack(source, folder.path(), options).without, ElementsAre("v2"));
  options.included_only = false;
  report = pack(source, folder.path(), options);
  EXPECT_EQ(report.panoramas, 3U);
  store = Store::open(report.file);
  EXPECT_EQ(read_panorama(*store, ViewpointIndex(3)).depth, testing::panorama(4, 4).depth);
}

TEST(Pack, KeepsTheJpegsOfFilesAndNoticesWhenTheyChange) {
  const TemporaryFolder input("store_pack_files"), output("store_pack_files_packed");
  const fs::path images = input.path() / "house" / "matterport_skybox_images";
  fs::create_directories(images);
  const auto write_strip = [&](const std::string& viewpoint, std::uint64_t seed) {
    const std::vector<std::uint8_t> jpeg =
        image::encode_jpeg(image::join_strip(testing::panorama(16, seed).colour), 90);
    write_file_atomically(images / (viewpoint + "_skybox_small.jpg"),
                          {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
  };
  write_strip("v0", 1);
  write_strip("v1", 2);
  write_file_atomically(connectivity_file(input.path(), "house"),
                        to_json(testing::row_of_viewpoints("house", 3)));
  const auto run = [&](const PackOptions& options) {
    return pack(*open_matterport_images(input.path(), input.path(), "house"), output.path(),
                options);
  };
  PackReport report = run({});
  EXPECT_EQ(report.panoramas, 2U);
  EXPECT_THAT(report.without, ElementsAre("v2"));
  const auto source = open_matterport_images(input.path(), input.path(), "house");
  const auto kept = Store::open(report.file)->colour_jpegs(ViewpointIndex(1));
  const auto given = source->colour_jpegs(ViewpointIndex(1));
  ASSERT_TRUE(kept.has_value() && given.has_value());
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const auto theirs = image::bytes_of((*given)[k]);
    const auto ours = image::bytes_of((*kept)[k]);
    EXPECT_EQ(image::decode_jpeg(ours, "store"), image::decode_jpeg(theirs, "file"));
    // The same coefficients, with restart markers.
    EXPECT_EQ(image::mark_rows(theirs, "file"),
              (std::vector<std::uint8_t>(ours.begin(), ours.end())));
  }
  EXPECT_TRUE(run({}).was_complete);
  write_strip("v2", 3);
  report = run({});
  EXPECT_EQ(report.panoramas, 3U);
  EXPECT_THAT(report.without, ElementsAre());
  EXPECT_TRUE(run({}).was_complete);
  write_strip("v0", 4);
  EXPECT_FALSE(run({}).was_complete);
}

TEST(Pack, ShrinksLargerFaces) {
  const TemporaryFolder folder("store_pack_shrink");
  Panorama large = testing::panorama(8, 1);
  large.depth = testing::panorama(2, 1).depth;  // is smaller already
  PackOptions options;
  options.colour = ColourCoding::kRaw;
  options.face_size = 4;
  const auto store = Store::open(
      pack(MemoryPanoramas(testing::row_of_viewpoints("house", 1), {large}), folder.path(), options)
          .file);
  EXPECT_EQ(store->face_sizes(ViewpointIndex(0)), (FaceSizes{4, 2, 4, 4}));
  const Panorama small = read_panorama(*store, ViewpointIndex(0));
  EXPECT_EQ(small.colour[2], image::shrink(large.colour[2], 4, 4));
  EXPECT_EQ(small.depth, large.depth);
  EXPECT_EQ(*small.classes[3].at(1, 2), *large.classes[3].at(3, 5));
  EXPECT_EQ(*small.instances[5].at(3, 0), *large.instances[5].at(7, 1));
}

TEST(Pack, RefusesWhatItCannotDo) {
  const TemporaryFolder folder("store_pack_refused");
  const auto source = testing::memory_panoramas("house", 1, 4);
  PackOptions options;
  for (const int quality : {0, 101}) {
    options.jpeg_quality = quality;
    EXPECT_THROW(pack(*source, folder.path(), options), ArgumentError);
  }
  options = {};
  options.threads = -1;
  EXPECT_THROW(pack(*source, folder.path(), options), ArgumentError);
  const MemoryPanoramas dark(testing::row_of_viewpoints("house", 1), {{}});
  EXPECT_THAT([&] { pack(dark, folder.path(), {}); },
              ThrowsMessage<ArgumentError>(HasSubstr("no panorama has colour")));
  EXPECT_THROW(pack(*testing::memory_panoramas("../house", 1, 4), folder.path(), {}), LookupError);
  write_file_atomically(folder.path() / "file", "no folder");
  EXPECT_THROW(pack(*source, folder.path() / "file", {}), FileError);
  EXPECT_THROW(pack(*source, "/proc", {}), FileError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
