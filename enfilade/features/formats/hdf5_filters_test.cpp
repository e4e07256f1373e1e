#include "enfilade/features/formats/hdf5_filters.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/features/formats/hdf5_datasets.h"
#include "enfilade/features/hdf5_writer.h"
#include "enfilade/features/object_set.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::features::formats {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

// --- LZF ----------------------------------------------------------------------------------------

std::string unpacked(std::string_view packed, std::size_t room = 64) {
  std::string to(room, '?');
  const auto written = unpack_lzf(std::as_bytes(std::span(packed)),
                                  std::as_writable_bytes(std::span(to.data(), to.size())));
  return written ? to.substr(0, *written) : "damaged";
}

TEST(Lzf, UnpacksLiteralsAndRepetitions) {
  EXPECT_EQ(unpacked(""), "");
  EXPECT_EQ(unpacked(std::string_view("\x02"
                                      "abc",
                                      4)),
            "abc");
  // Three bytes from three back.
  EXPECT_EQ(unpacked(std::string_view("\x02"
                                      "abc\x20\x02",
                                      6)),
            "abcabc");
  // From one back: the repetition reads what it has written.
  EXPECT_EQ(unpacked(std::string_view("\0a\x60\0", 4)), "aaaaaa");
  // A length of 2 + 7 + 5.
  EXPECT_EQ(unpacked(std::string_view("\0a\xe0\x05\0", 5)), std::string(15, 'a'));
}

TEST(Lzf, DamagedBytesAreFound) {
  for (const std::string_view packed :
       {std::string_view("\x02"
                         "ab",
                         3),                                                // cut in literals
        std::string_view("\0a\x20", 3), std::string_view("\0a\xe0", 3),     // cut in a repetition
        std::string_view("\0a\xe0\x05", 4), std::string_view("\x20\0", 2),  // from before the start
        std::string_view("\0a\x20\x01", 4)}) {
    EXPECT_EQ(unpacked(packed), "damaged");
  }
  EXPECT_EQ(unpacked(std::string_view("\x02"
                                      "abc",
                                      4),
                     2),
            "damaged")
      << "no room";
  EXPECT_EQ(unpacked(std::string_view("\0a\xe0\x05\0", 5), 14), "damaged") << "no room";
}

// tests/fuzz/make_weight_seeds.py wrote it with h5py.
TEST(Lzf, FeaturesOfH5pyAreRead) {
  const FeatureSet set =
      FeatureSet::open(fs::path(EN_SOURCE_DIR) / "tests/fuzz/seeds/feature_hdf5/f32_lzf.h5");
  ASSERT_EQ(set.keys().size(), 2U);
  std::vector<float> view(3);
  set.copy_view(1, 35, view);
  EXPECT_THAT(view, ::testing::ElementsAre(126.25, 126.5, 126.75));
}

constexpr H5Z_filter_t kLzf = 32000, kBlosc = 32001;

// Packs as LZF, in literals, all but the last bytes.
template <std::size_t kCut>
std::size_t pack_lzf(unsigned /*flags*/, std::size_t /*count*/, const unsigned* /*values*/,
                     std::size_t bytes, std::size_t* buffer_bytes, void** buffer) {
  constexpr std::size_t kRun = 32;
  const std::string_view all(static_cast<const char*>(*buffer), bytes - kCut);
  std::string packed;
  for (std::size_t at = 0; at < all.size(); at += kRun) {
    const std::string_view run = all.substr(at, kRun);
    packed += static_cast<char>(run.size() - 1);
    packed += run;
  }
  void* const to = H5allocate_memory(packed.size(), false);
  std::memcpy(to, packed.data(), packed.size());
  H5free_memory(*buffer);
  *buffer = to;
  *buffer_bytes = packed.size();
  return packed.size();
}

// A dataset of one chunk, packed with a filter that is there only while it is written.
void write_packed(const fs::path& file, H5Z_filter_t id, H5Z_func_t pack, bool scaled = false) {
  const Hdf5Library library;
  H5Z_class2_t filter{};
  filter.version = H5Z_CLASS_T_VERS;
  filter.id = id;
  filter.encoder_present = filter.decoder_present = 1;
  filter.name = "blosc";
  filter.filter = pack;
  ASSERT_GE(H5Zregister(&filter), 0);
  {
    const Hdf5Handle made(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
                          H5Fclose);
    const std::array<hsize_t, 2> size{36, 2};
    const Hdf5Handle space(H5Screate_simple(2, size.data(), nullptr), H5Sclose);
    const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_chunk(layout.id(), 2, size.data());
    if (scaled) H5Pset_scaleoffset(layout.id(), H5Z_SO_FLOAT_DSCALE, 2);
    const std::array<unsigned, 3> values{4, 261, 36 * 2 * sizeof(float)};  // h5py's of LZF
    H5Pset_filter(layout.id(), id, H5Z_FLAG_MANDATORY, values.size(), values.data());
    const Hdf5Handle dataset(H5Dcreate2(made.id(), "s_a", H5T_IEEE_F32LE, space.id(), H5P_DEFAULT,
                                        layout.id(), H5P_DEFAULT),
                             H5Dclose);
    const std::array<float, 72> numbers{};
    ASSERT_GE(
        H5Dwrite(dataset.id(), H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()), 0);
  }
  ASSERT_GE(H5Zunregister(id), 0);
  register_lzf();
}

TEST(Lzf, AChunkThatIsCutAfterAWholeRunIsDamaged) {
  const tests::TemporaryFolder folder("lzf");
  const fs::path file = folder.path() / "f.h5";
  const auto refusal = [&](H5Z_func_t pack, bool scaled) {
    write_packed(file, kLzf, pack, scaled);
    return tests::refusal<InvalidInput>([&] { FeatureSet::open(file); });
  };
  EXPECT_EQ(refusal(pack_lzf<0>, false), "accepted");
  EXPECT_THAT(refusal(pack_lzf<32>, false), HasSubstr("[bad-hdf5]"));
  EXPECT_EQ(refusal(pack_lzf<0>, true), "accepted") << "scale-offset has shortened it";
  EXPECT_THAT(refusal(pack_lzf<32>, false), HasSubstr("[bad-hdf5]"));
}

// --- other filters ------------------------------------------------------------------------------

std::size_t unchanged(unsigned /*flags*/, std::size_t /*count*/, const unsigned* /*values*/,
                      std::size_t bytes, std::size_t* /*buffer_bytes*/, void** /*buffer*/) {
  return bytes;
}

TEST(Hdf5Filters, AMissingOneIsNamedWithTheRemedy) {
  const tests::TemporaryFolder folder("filters");
  const fs::path file = folder.path() / "f.h5";
  write_packed(file, kBlosc, unchanged);
  const auto says = AllOf(HasSubstr("\"s_a\": packed with the filter \"blosc\" (32001)"),
                          HasSubstr("h5repack -f GZIP=4"), HasSubstr("missing-filter"));
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { FeatureSet::open(file); }), says);
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { ObjectSet::open(file); }), says);
}

// --- locks --------------------------------------------------------------------------------------

class Hdf5Locks : public ::testing::Test {
 protected:
  Hdf5Locks() {
    const std::array<float, 72> numbers{};
    Hdf5Writer writer(file_);
    writer.write({"s_a",
                  {Hdf5Type::kFloat32, {36, 2}, std::as_bytes(std::span(numbers))},
                  {{"vfov", std::int64_t{60}}}});
    writer.finish();
  }
  std::string refusal() const {
    return tests::refusal<InvalidInput>([&] { FeatureSet::open(file_); });
  }

  tests::TemporaryFolder folder_{"locks"};
  fs::path file_ = folder_.path() / "f.h5";
};

TEST_F(Hdf5Locks, AFileThatAnotherWritesIsSaidToBeLocked) {
  EXPECT_EQ(refusal(), "accepted");
  const int writer = open(file_.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(flock(writer, LOCK_EX | LOCK_NB), 0);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("another program has the file open for writing"),
                               HasSubstr("HDF5_USE_FILE_LOCKING=FALSE"), HasSubstr("[locked]")));
  setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1);
  EXPECT_EQ(refusal(), "accepted");
  unsetenv("HDF5_USE_FILE_LOCKING");
  close(writer);
  EXPECT_EQ(refusal(), "accepted");
}

TEST_F(Hdf5Locks, AReaderOfAnotherProgramDoesNotMatter) {
  const int reader = open(file_.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(flock(reader, LOCK_SH | LOCK_NB), 0);
  EXPECT_EQ(refusal(), "accepted");
  close(reader);
}

// With the newest form of files the library marks one that is being written, in the file itself.
TEST_F(Hdf5Locks, AFileThatWasNotClosedIsSaidToBe) {
  const fs::path open_file = folder_.path() / "open.h5";
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const hid_t newest = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(newest, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    const hid_t file = H5Fcreate(open_file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, newest);
    H5Fflush(file, H5F_SCOPE_GLOBAL);
    _exit(0);  // as if it was killed
  }
  waitpid(child, nullptr, 0);
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { FeatureSet::open(open_file); }),
              AllOf(HasSubstr("h5clear -s"), HasSubstr("[locked]")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::features::formats
