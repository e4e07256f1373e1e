#include "enfilade/arena/endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace EN_UNIT {

using ::testing::HasSubstr;
using tests::refusal;

TEST(AnswerCacheTest, KeepsWhatWasAnswered) {
  const tests::TemporaryFolder folder("answer_cache");
  AnswerCache cache(folder.path() / "cache");
  const std::string request = R"({"model":"m","messages":["Hello"]})";
  EXPECT_FALSE(cache.find(request));
  int asked = 0;
  const auto ask = [&asked]() -> KeptAnswer {
    ++asked;
    return {R"({"choices":[1]})", 0.5, 2};
  };
  EXPECT_EQ(cache.get(request, ask).answer, R"({"choices":[1]})");
  EXPECT_EQ(cache.get(request, ask).attempts, 2);
  EXPECT_EQ(asked, 1);
  const AnswerCache other(folder.path() / "cache");  // another process
  EXPECT_EQ(other.find(request)->seconds, 0.5);
  EXPECT_EQ(other.find_key(AnswerCache::key_of(request))->answer, R"({"choices":[1]})");
  EXPECT_FALSE(other.find(R"({"model":"m","messages":["Hallo"]})"));
}

TEST(AnswerCacheTest, AKeyIsNoPath) {
  const tests::TemporaryFolder folder("answer_cache");
  const AnswerCache cache(folder.path() / "deep/cache");
  write_file_atomically(folder.path() / "x.json", R"({"answer": 1, "seconds": 1, "attempts": 1})");
  for (const std::string key :
       {"../x", "../../../etc/passwd", "", "x", "../../x/../x/../x/../x/../x/../x", "ABCDEF"}) {
    EXPECT_FALSE(cache.find_key(key)) << key;
  }
}

TEST(AnswerCacheTest, AFailureIsNotKept) {
  const tests::TemporaryFolder folder("answer_cache");
  AnswerCache cache(folder.path());
  EXPECT_EQ(refusal<Error>([&] { cache.get("{}", []() -> KeptAnswer { throw Error("no"); }); }),
            "no");
  EXPECT_EQ(cache.get("{}", [] { return KeptAnswer{"1"}; }).answer, "1");
}

TEST(AnswerCacheTest, ManyWhoAskTheSameAskOnce) {
  const tests::TemporaryFolder folder("answer_cache");
  AnswerCache cache(folder.path());
  std::atomic<int> asked = 0;
  std::vector<std::jthread> threads;
  for (int k = 0; k < 16; ++k) {
    threads.emplace_back([&cache, &asked, k] {
      const std::string request = k % 2 == 0 ? "{\"a\":1}" : "{\"b\":2}";
      const KeptAnswer answer = cache.get(request, [&asked] {
        ++asked;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return KeptAnswer{"3"};
      });
      EXPECT_EQ(answer.answer, "3");
    });
  }
  threads.clear();
  EXPECT_EQ(asked, 2);
}

TEST(AnswerCacheTest, DamageIsTold) {
  const tests::TemporaryFolder folder("answer_cache");
  AnswerCache cache(folder.path());
  cache.get("{\"a\":1}", [] { return KeptAnswer{"3"}; });
  const std::string key = AnswerCache::key_of("{\"a\":1}");
  const auto file = folder.path() / key.substr(0, 2) / (key + ".json");
  const auto fault = [&] { return refusal<InvalidInput>([&] { cache.find("{\"a\":1}"); }); };
  write_file_atomically(file, "{\"request\":{\"a\":2},\"answer\":3,\"seconds\":0,\"attempts\":1}");
  EXPECT_THAT(fault(), HasSubstr("other-request"));
  write_file_atomically(file, "{\"request\":{\"a\":1}}");
  EXPECT_THAT(fault(), HasSubstr("damaged"));
  write_file_atomically(file, "{\"requ");
  EXPECT_THAT(fault(), HasSubstr(key));
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
