#include "enfilade/features/formats/hdf5_datasets.h"

#include <gtest/gtest.h>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/features/formats/stored_arrays.h"
#include "tests/support/refusal.h"

namespace enfilade::features::formats {
namespace EN_UNIT {

std::string refusal(const std::function<void()>& work) {
  return tests::refusal<InvalidInput>([&] { run_isolated("f.h5", "damaged", work); });
}

TEST(Isolated, SharedMemoryIsWhatComesBack) {
  SharedMemory memory("f.h5");
  int own = 0;
  run_isolated("f.h5", "damaged", [&] {
    own = 1;
    memory.write_at(2, std::as_bytes(std::span("cd", 2)));
    memory.write_at(0, std::as_bytes(std::span("ab", 2)));
  });
  EXPECT_EQ(own, 0);
  EXPECT_EQ(read_file(memory.path()), "abcd");
}

TEST(Isolated, SharedMemoryHasABound) {
  SharedMemory memory("f.h5", 3);
  memory.write_at(1, std::as_bytes(std::span("ab", 2)));
  EXPECT_THROW(memory.write_at(2, std::as_bytes(std::span("ab", 2))), FileError);
}

TEST(Isolated, WhatIsThrownIsThrown) {
  EXPECT_EQ(refusal([] { refuse("f.h5", "here", "wrong", "a fault"); }),
            "error: f.h5: here: a fault [wrong]");
  EXPECT_EQ(tests::refusal<FileError>([] {
              run_isolated("f.h5", "damaged", [] { throw FileError("f.h5: cannot open: why"); });
            }),
            "f.h5: cannot open: why");
}

TEST(Isolated, ACrashIsADamagedFile) {
  for (const auto& crash : std::vector<std::function<void()>>{
           [] { std::raise(SIGSEGV); }, [] { std::abort(); }, [] { std::raise(SIGKILL); },
           [] { std::_Exit(0); }, [] { throw std::runtime_error("something else"); }}) {
    EXPECT_EQ(refusal(crash),
              "error: f.h5: damaged: the process that read it crashed or was killed [damaged]");
  }
}

TEST(Isolated, NothingIsPrinted) {
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(refusal([] {
              std::puts("printed");
              std::fputs("printed", stderr);
              std::fflush(nullptr);
            }),
            "accepted");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

}  // namespace EN_UNIT
}  // namespace enfilade::features::formats
