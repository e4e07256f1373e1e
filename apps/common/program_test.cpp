#include "apps/common/program.h"

#include <gtest/gtest.h>

#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::apps {
namespace EN_UNIT {

TEST(ProcessorName, IsTheFirstOfTheSystemsList) {
  EXPECT_EQ(processor_name_in("processor\t: 0\nmodel name\t: A CPU @ 2 GHz\nflags\t\t: fpu\n\n"
                              "processor\t: 1\nmodel name\t: Another\n"),
            "A CPU @ 2 GHz");
  EXPECT_EQ(processor_name_in("model name\t: Without an end of line"), "Without an end of line");
}

TEST(ProcessorName, OfArmIsMadeOfMakerAndPart) {
  const std::string head = "processor\t: 0\nFeatures\t: fp asimd\nCPU implementer\t: ";
  const std::string middle = "\nCPU architecture: 8\nCPU variant\t: 0x0\nCPU part\t: ";
  EXPECT_EQ(processor_name_in(head + "0x41" + middle + "0xd4f\nCPU revision\t: 0\n"),
            "ARM 0x41/0xd4f (Neoverse-V2)");
  EXPECT_EQ(processor_name_in(head + "0x4e" + middle + "0xd4f\nCPU revision\t: 0\n"),
            "ARM 0x4e/0xd4f");
}

TEST(ProcessorName, IsUnknownWhereTheSystemDoesNotSay) {
  EXPECT_EQ(processor_name_in(""), "unknown processor");
  EXPECT_EQ(processor_name_in("processor\t: 0\nCPU implementer\t: 0x41\n"), "unknown processor");
  EXPECT_NE(processor_name(), "");
}

// What only a file, or a number of the command line, can cause is no fault of ours.
TEST(RunProgram, GivesInputsTheirExitCode) {
  const auto code_of = [](const auto& fault) {
    CLI::App app("", "test");
    app.callback([&] { fault(); });
    std::string name = "test";
    char* words[] = {name.data(), nullptr};
    return run_program(app, 1, words, 0);
  };
  EXPECT_EQ(code_of([] { throw FileError("a: broken"); }), kInput);
  EXPECT_EQ(code_of([] { throw std::bad_alloc(); }), kInput);
  EXPECT_EQ(code_of([] { std::vector<int>().reserve(~std::size_t{0}); }), kInput);
  EXPECT_EQ(code_of([] {
              throw std::filesystem::filesystem_error("a",
                                                      std::make_error_code(std::errc::io_error));
            }),
            kInput);
  EXPECT_EQ(code_of([] { throw std::logic_error("ours"); }), kInternal);
  EXPECT_EQ(code_of([] {}), kSuccess);
}

TEST(ReadSecret, IsShort) { EXPECT_THROW(read_secret("/dev/zero", {}), FileError); }

TEST(ReadSecret, TakesAFileAsEditorsSaveIt) {
  const tests::TemporaryFolder folder("secret");
  const auto file = folder.path() / "key.txt";
  for (const char* saved : {"sk-1", "sk-1\r\n", "\xef\xbb\xbfsk-1\n"}) {
    write_file_atomically(file, saved);
    EXPECT_EQ(read_secret(file, {}), "sk-1");
  }
  write_file_atomically(file, std::string_view("\xff\xfes\0k\0\r\0\n\0", 10));
  EXPECT_EQ(read_secret(file, {}), "sk") << "UTF-16";
}

}  // namespace EN_UNIT
}  // namespace enfilade::apps
