#include "enfilade/neural/ranks.h"

#include <ATen/ATen.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <exception>
#include <functional>
#include <map>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/core/gradient_sum.h"
#include "tests/support/free_port.h"

namespace enfilade::neural {
namespace EN_UNIT {

using core::BatchParts;
using core::GradientSum;
using core::share_parts;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::optional<RankPlace> place_in(const std::map<std::string, std::string>& variables) {
  return find_place([&](const char* name) -> const char* {
    const auto found = variables.find(name);
    return found != variables.end() ? found->second.c_str() : nullptr;
  });
}

TEST(RankPlace, IsNoneWithoutALauncher) {
  EXPECT_FALSE(place_in({}));
  // A batch script of Slurm, which runs once however many tasks the job has.
  EXPECT_FALSE(place_in({{"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "4"}, {"SLURM_JOB_ID", "7"}}));
  // A step of one task.
  EXPECT_FALSE(place_in({{"SLURM_PROCID", "0"},
                         {"SLURM_STEP_ID", "0"},
                         {"SLURM_STEP_NUM_TASKS", "1"},
                         {"SLURM_STEP_NODELIST", "node1"}}));
}

TEST(RankPlace, IsReadFromTorchrun) {
  const auto place = place_in({{"RANK", "5"},
                               {"WORLD_SIZE", "8"},
                               {"LOCAL_RANK", "1"},
                               {"LOCAL_WORLD_SIZE", "4"},
                               {"MASTER_ADDR", "node1"},
                               {"MASTER_PORT", "29401"},
                               {"TORCHELASTIC_USE_AGENT_STORE", "True"},
                               {"TORCHELASTIC_RESTART_COUNT", "2"}});
  ASSERT_TRUE(place);
  EXPECT_EQ(place->rank, 5);
  EXPECT_EQ(place->size, 8);
  EXPECT_EQ(place->local_rank, 1);
  EXPECT_EQ(place->local_size, 4);
  EXPECT_EQ(place->host, "node1");
  // Torchrun's own store has the named port.
  EXPECT_EQ(place->port, 20000 + (29401 + 3 * 7919) % 12000);
}

TEST(RankPlace, IsReadFromSlurmAndMpi) {
  const auto slurm = place_in({{"SLURM_PROCID", "3"},
                               {"SLURM_LOCALID", "1"},
                               {"SLURM_JOB_ID", "70000"},
                               {"SLURM_STEP_ID", "2"},
                               {"SLURM_STEP_NUM_TASKS", "8"},
                               {"SLURM_STEP_TASKS_PER_NODE", "2(x4)"},
                               {"SLURM_STEP_NODELIST", "gpu[07-09,12]"}});
  ASSERT_TRUE(slurm);
  EXPECT_EQ(slurm->rank, 3);
  EXPECT_EQ(slurm->size, 8);
  EXPECT_EQ(slurm->local_size, 2);
  EXPECT_EQ(slurm->host, "gpu07");
  EXPECT_EQ(slurm->port, 20000 + (64 * 70000 + 2) % 12000);
  const auto mpi = place_in({{"OMPI_COMM_WORLD_RANK", "1"},
                             {"OMPI_COMM_WORLD_SIZE", "2"},
                             {"OMPI_COMM_WORLD_LOCAL_RANK", "1"},
                             {"OMPI_COMM_WORLD_LOCAL_SIZE", "2"},
                             {"MASTER_PORT", "4000"}});
  ASSERT_TRUE(mpi);
  EXPECT_EQ(mpi->host, "127.0.0.1");
  EXPECT_EQ(mpi->port, 4000);
}

TEST(RankPlace, RefusesWhatCannotBe) {
  const auto refuses = [](const std::map<std::string, std::string>& variables,
                          const std::string& says) {
    EXPECT_THAT([&] { place_in(variables); }, ThrowsMessage<ArgumentError>(HasSubstr(says)));
  };
  refuses({{"RANK", "one"}, {"WORLD_SIZE", "2"}}, "RANK=one: a whole number");
  refuses({{"RANK", "-1"}, {"WORLD_SIZE", "2"}}, "RANK=-1");
  refuses({{"RANK", "2"}, {"WORLD_SIZE", "2"}, {"MASTER_ADDR", "a"}, {"MASTER_PORT", "1"}},
          "rank 2 of 2 processes");
  refuses({{"RANK", "0"}, {"WORLD_SIZE", "2"}}, "MASTER_ADDR");
  refuses({{"RANK", "0"}, {"WORLD_SIZE", "2"}, {"MASTER_ADDR", "a"}}, "MASTER_PORT is not set");
  refuses({{"RANK", "0"}, {"WORLD_SIZE", "2"}, {"MASTER_ADDR", "a"}, {"MASTER_PORT", "70000"}},
          "MASTER_PORT=70000");
  refuses({{"OMPI_COMM_WORLD_RANK", "0"},
           {"OMPI_COMM_WORLD_SIZE", "4"},
           {"OMPI_COMM_WORLD_LOCAL_SIZE", "2"}},
          "-x MASTER_ADDR");
}

TEST(FirstHost, OfSlurmsLists) {
  EXPECT_EQ(first_host("node7"), "node7");
  EXPECT_EQ(first_host("node7,node9"), "node7");
  EXPECT_EQ(first_host("node[07-12,20]"), "node07");
  EXPECT_EQ(first_host("login,node[1-2]"), "login");
  EXPECT_EQ(first_host("rack1-node[3]"), "rack1-node3");
}

// Calls body for each rank in a thread of its own, connected as processes are.
void in_ranks(int size, const std::function<void(Ranks&)>& body) {
  const std::uint16_t port = tests::free_port();
  std::vector<std::exception_ptr> failures(static_cast<std::size_t>(size));
  std::vector<std::thread> threads;
  for (int k = 0; k < size; ++k) {
    threads.emplace_back([&, k] {
      try {
        RankPlace place;
        place.rank = k;
        place.size = size;
        place.host = "127.0.0.1";
        place.port = port;
        place.launcher = "test";
        Ranks ranks(place, std::chrono::seconds(20));
        body(ranks);
      } catch (...) {
        failures[static_cast<std::size_t>(k)] = std::current_exception();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

class RanksTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const RanksReport report = examine_ranks(); !report.works) GTEST_SKIP() << report.text;
  }
};

TEST_F(RanksTest, GatherByRank) {
  in_ranks(3, [](Ranks& ranks) {
    const std::string own(static_cast<std::size_t>(ranks.rank()) * 5, "abc"[ranks.rank()]);
    EXPECT_THAT(ranks.gather(own), ElementsAre("", "bbbbb", "cccccccccc"));
    EXPECT_THAT(ranks.gather(""), ElementsAre("", "", ""));
    ranks.meet();
  });
}

TEST_F(RanksTest, AllAreToldWhoDiffersInWhat) {
  std::atomic<int> told = 0;
  in_ranks(3, [&](Ranks& ranks) {
    RankFacts facts{{"seed", "1"}, {"threads", "2"}};
    ranks.agree(facts);
    if (ranks.rank() == 2) facts = {{"seed", "7"}, {"threads", "2"}, {"extra", "x"}};
    EXPECT_THAT([&] { ranks.agree(facts); },
                ThrowsMessage<ArgumentError>(AllOf(
                    HasSubstr("rank 2: seed: 7, not 1"), HasSubstr("rank 2: extra: x, not none"),
                    Not(HasSubstr("rank 1")), Not(HasSubstr("threads")))));
    ++told;
  });
  EXPECT_EQ(told, 3);
}

TEST_F(RanksTest, BatchesAreSharedAndEachIsDoneOnce) {
  constexpr std::size_t kTotal = 23, kBatch = 4;
  std::atomic<std::size_t> done = 0;
  in_ranks(4, [&](Ranks& ranks) {
    const auto batches =
        core::share_batches(ranks, kTotal, kBatch, [&](std::span<const std::size_t> indices) {
          done += indices.size();
          return core::packed(std::vector<std::size_t>(indices.begin(), indices.end()));
        });
    std::vector<std::size_t> all;
    for (const std::string& batch : batches) {
      for (const std::size_t i : core::unpacked<std::vector<std::size_t>>(batch)) all.push_back(i);
    }
    std::vector<std::size_t> expected(kTotal);
    std::iota(expected.begin(), expected.end(), 0);
    EXPECT_EQ(all, expected);
  });
  EXPECT_EQ(done, kTotal);
}

TEST_F(RanksTest, WhoFailsIsNamedWithItsReason) {
  std::atomic<int> told = 0;
  in_ranks(3, [&](Ranks& ranks) {
    if (ranks.rank() == 1) return ranks.tell_failure("the loss is nan");
    EXPECT_THAT([&] { ranks.meet(); },
                ThrowsMessage<LostRank>(
                    AllOf(HasSubstr("rank 1 ("), HasSubstr(" failed: the loss is nan"))));
    ++told;
  });
  EXPECT_EQ(told, 2);
}

TEST_F(RanksTest, WhoEndsWithoutAWordIsNamed) {
  std::atomic<int> told = 0;
  in_ranks(3, [&](Ranks& ranks) {
    if (ranks.rank() == 2) return;
    EXPECT_THAT([&] { ranks.meet(); },
                ThrowsMessage<LostRank>(
                    AllOf(HasSubstr("rank 2 ("), HasSubstr("has died or does not answer"))));
    ++told;
  });
  EXPECT_EQ(told, 2);
}

TEST(ShareParts, OfNumbersThatFit) {
  Ranks alone;
  const BatchParts all = share_parts(6, alone);
  EXPECT_EQ(all.parts, 6U);
  EXPECT_EQ(all.count, 6U);
  EXPECT_EQ(usual_parts(1), 8U);
  EXPECT_EQ(usual_parts(4), 8U);
  EXPECT_EQ(usual_parts(3), 12U);
  EXPECT_EQ(usual_parts(16), 16U);
}

TEST(PartOf, CoversTheBatch) {
  std::vector<std::size_t> batch(10);
  std::iota(batch.begin(), batch.end(), 100);
  std::vector<std::size_t> all;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto part = core::part_of(batch, k, 4);
    EXPECT_THAT(part.size(), ::testing::AnyOf(2U, 3U));
    all.insert(all.end(), part.begin(), part.end());
  }
  EXPECT_EQ(all, batch);
  EXPECT_TRUE(core::part_of(std::span(batch).first(1), 0, 4).empty());
}

// Gradients of the parts of a batch, of weights of unlike sizes; some parts lack some.
struct Made {
  explicit Made(std::uint64_t seed) {
    Rng rng(seed);
    for (std::size_t part = 0; part < 8; ++part) {
      std::vector<at::Tensor>& gradients = parts.emplace_back();
      for (const std::int64_t size : sizes) {
        at::Tensor gradient = at::empty({size}, at::kFloat);
        for (std::int64_t i = 0; i < size; ++i) {
          gradient.data_ptr<float>()[i] = static_cast<float>(rng.uniform() - 0.5);
        }
        gradients.push_back(gradient);
      }
      gradients[3] = at::Tensor();
      if (part % 3 == 0) gradients[1] = at::Tensor();
    }
  }
  // The tree, by pairs.
  at::Tensor sum(std::size_t weight) const {
    std::vector<at::Tensor> level;
    for (const auto& part : parts) {
      level.push_back(part[weight].defined() ? part[weight] * 0.125
                                             : at::zeros({sizes[weight]}, at::kFloat));
    }
    while (level.size() > 1) {
      std::vector<at::Tensor> next;
      for (std::size_t k = 0; k < level.size(); k += 2) next.push_back(level[k] + level[k + 1]);
      level = std::move(next);
    }
    return level.front();
  }

  std::vector<std::int64_t> sizes{700, 3, 41, 8, 300};
  std::vector<std::vector<at::Tensor>> parts;
};

void expect_the_tree(Ranks& ranks, std::size_t bucket) {
  const BatchParts own = share_parts(8, ranks);
  std::optional<GradientSum> sum;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Made made(seed);
    if (!sum) sum.emplace(ranks, own, made.sizes, at::kCPU, bucket);
    for (std::size_t k = own.first; k < own.first + own.count; ++k) {
      sum->begin_part(0.125);
      // The last ones first, as autograd comes to them; one is left to end_part().
      for (const std::size_t weight : {4U, 2U, 1U, 0U}) sum->ready(weight, made.parts[k][weight]);
      sum->end_part(made.parts[k], 1.0);
    }
    const GradientSum::Sums sums = sum->finish();
    EXPECT_EQ(sums.loss, 1.0);
    for (std::size_t weight = 0; weight < made.sizes.size(); ++weight) {
      if (weight == 3) {
        EXPECT_FALSE(sums.gradients[weight].defined());
      } else {
        EXPECT_TRUE(at::equal(sums.gradients[weight], made.sum(weight))) << weight;
      }
    }
  }
}

TEST(GradientSum, OfOneProcessIsTheTree) {
  Ranks alone;
  expect_the_tree(alone, 1000);
}

TEST_F(RanksTest, SumsOfTwoFourAndEightProcessesAreTheTreeToTheBit) {
  for (const int size : {2, 4, 8}) {
    for (const std::size_t bucket : {100U, 1000U, 1U << 20U}) {
      in_ranks(size, [bucket](Ranks& ranks) { expect_the_tree(ranks, bucket); });
    }
  }
}

TEST_F(RanksTest, OtherNumbersOfPartsAreRefusedOrAdded) {
  in_ranks(3, [](Ranks& ranks) {
    EXPECT_THAT(
        [&] { share_parts(8, ranks); },
        ThrowsMessage<ArgumentError>(HasSubstr(
            "parts: 8, in 3 processes; this number of parts is shared by 1, 2, 4, 8 processes")));
    const BatchParts own = share_parts(12, ranks);
    EXPECT_EQ(own.count, 4U);
    EXPECT_EQ(own.first, 4U * static_cast<std::size_t>(ranks.rank()));
    // As they come: near the sum, in no order.
    const BatchParts any = share_parts(0, ranks);
    GradientSum sum(ranks, any, {1000});
    sum.begin_part(1.0 / 3);
    const at::Tensor gradient = at::full({1000}, 3.0F * static_cast<float>(ranks.rank() + 1));
    sum.end_part({&gradient, 1}, 3);
    const GradientSum::Sums sums = sum.finish();
    // Two roundings of float32 a process.
    EXPECT_TRUE(at::allclose(sums.gradients[0], at::full({1000}, 6.0F), 1e-6, 1e-6));
    EXPECT_NEAR(sums.loss, 3, 1e-6);
  });
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural
