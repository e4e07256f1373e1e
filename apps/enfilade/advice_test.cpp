#include "apps/enfilade/advice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::apps {
namespace EN_UNIT {

using ::testing::HasSubstr;

constexpr std::uint64_t kMebi = std::uint64_t{1} << 20U, kGibi = kMebi << 10U;

TEST(JudgeSimd, IsContentWithAvx2AndNewerAndWithArm) {
  for (const char* target : {"AVX2", "AVX3", "AVX3_DL", "AVX3_ZEN4", "AVX3_SPR", "NEON", "SVE2"}) {
    EXPECT_TRUE(judge_simd(target, true).good) << target;
    EXPECT_EQ(judge_simd(target, true).advice, "") << target;
  }
}

TEST(JudgeSimd, TellsAnOldProcessorFromABuildThatDoesNotUseIt) {
  const Judgement old = judge_simd("SSE4", false);
  EXPECT_FALSE(old.good);
  EXPECT_EQ(old.text, "SSE4; no AVX2");
  EXPECT_THAT(old.advice, HasSubstr("-cpu host"));
  const Judgement unused = judge_simd("SSE4", true);
  EXPECT_FALSE(unused.good);
  EXPECT_EQ(unused.text, "SSE4; the processor has AVX2, this build does not use it");
  EXPECT_THAT(unused.advice, HasSubstr("build again"));
}

TEST(JudgeSimd, SaysWhereThereIsNone) {
  EXPECT_FALSE(judge_simd("EMU128", false).good);
  EXPECT_THAT(judge_simd("EMU128", false).text, HasSubstr("plain C++"));
}

neural::TorchReport torch(double speed, const std::string& blas) {
  neural::TorchReport report;
  report.threads = 2;
  report.product_speed = speed;
  report.blas = blas;
  return report;
}

TEST(JudgeBlas, IsContentWithAFastOneWhateverItIs) {
  for (const char* file :
       {"", "/opt/mkl/libmkl_rt.so", "/usr/lib/x86_64-linux-gnu/blas/libblas.so.3"}) {
    EXPECT_TRUE(judge_blas(torch(30, file)).good) << file;
  }
}

TEST(JudgeBlas, NamesThePackageWhereItIsTheReferenceBlas) {
  const Judgement slow = judge_blas(torch(4, "/usr/lib/aarch64-linux-gnu/blas/libblas.so.3.12.1"));
  EXPECT_FALSE(slow.good);
  EXPECT_EQ(slow.text, "4 GFLOP/s on 2 threads, (100, 2592) x (2592, 2048)");
  EXPECT_THAT(slow.advice, HasSubstr("reference BLAS: apt-get install libopenblas0-pthread"));
}

TEST(JudgeBlas, AsksForTheMachineWhereTheBlasIsNotToBlame) {
  const std::string file = "/usr/lib/x86_64-linux-gnu/openblas-pthread/libblas.so.3";
  const Judgement slow = judge_blas(torch(29, file));
  EXPECT_FALSE(slow.good);
  EXPECT_THAT(slow.advice, HasSubstr("Is the machine busy"));
  EXPECT_THAT(slow.advice, HasSubstr("in use now: " + file));
}

Judgement judge(const Space& space) {
  return judge_space(space, kGibi, "results", "start in another folder");
}

TEST(JudgeSpace, ComparesWithWhatIsNeeded) {
  EXPECT_TRUE(judge({"/here", kGibi, 4 * kGibi}).good);
  EXPECT_EQ(judge({"/here", kGibi, 4 * kGibi}).text, "/here: 1.0 GiB free of 4.0 GiB");
  const Judgement full = judge({"/here", 700 * kMebi, 4 * kGibi});
  EXPECT_FALSE(full.good);
  EXPECT_EQ(full.text, "/here: 700 MiB free of 4.0 GiB");
  EXPECT_EQ(full.advice,
            "results take up to 1.0 GiB: make room on that disk, or start in another folder");
}

TEST(JudgeSpace, AFolderMayBeFullInOtherWays) {
  const Judgement crowded = judge({"/here", 2 * kGibi, 4 * kGibi, false});
  EXPECT_FALSE(crowded.good);
  EXPECT_THAT(crowded.text, HasSubstr("no inodes left"));
  const Judgement foreign = judge({"/here", 2 * kGibi, 4 * kGibi, true, false});
  EXPECT_FALSE(foreign.good);
  EXPECT_THAT(foreign.advice, HasSubstr("results cannot be written there: start in another"));
}

TEST(SpaceOf, LooksAtTheDisk) {
  const tests::TemporaryFolder folder("space");
  const Space space = space_of(folder.path());
  EXPECT_EQ(space.folder, folder.path());
  EXPECT_GT(space.total, 0U);
  EXPECT_LE(space.free, space.total);
  EXPECT_TRUE(space.writable);
  EXPECT_THAT(tests::refusal<FileError>([&] { space_of(folder.path() / "none"); }),
              HasSubstr("No such file"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::apps
