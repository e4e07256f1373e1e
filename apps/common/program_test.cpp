#include "apps/common/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

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

TEST(RunCommand, TellsHowItEndedOrWhyItDidNotStart) {
  EXPECT_EQ(run_command({"sh", "-c", "exit 7"}), 7);
  EXPECT_EQ(run_command({"sh", "-c", "kill -9 $$"}), kInternal);
  EXPECT_EQ(run_command({"/nowhere/program"}), -ENOENT);
}

/// Whether a process runs, or did and nobody has asked how it ended.
bool runs(const std::string& pid) {
  try {
    return read_file("/proc/" + pid + "/stat").find(") Z") == std::string::npos;
  } catch (const FileError&) {  // it is gone, perhaps since the file was opened
    return false;
  }
}

// A step of a study that goes on alone would write where the next run does.
TEST(RunCommand, EndsWithAProgramThatIsKilled) {
  const tests::TemporaryFolder folder("run_command");
  const std::string file = folder.path() / "pid";
  const pid_t program = fork();
  if (program == 0) {
    run_command({"sh", "-c",
                 "echo $$ > " + file + ".part; mv " + file + ".part " + file + "; exec sleep 60"});
    _exit(0);
  }
  const auto wait_for = [](const auto& is_so) {
    for (int k = 0; k < 1000 && !is_so(); ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return is_so();
  };
  ASSERT_TRUE(wait_for([&] { return std::filesystem::exists(file); }));
  std::string pid = read_file(file);
  pid.pop_back();
  EXPECT_TRUE(runs(pid));
  ::kill(program, SIGKILL);
  ::waitpid(program, nullptr, 0);
  EXPECT_TRUE(wait_for([&] { return !runs(pid); }));
}

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

// A program of one verb, run with these words behind it.
int run(const std::function<void(CLI::App&)>& add, std::vector<std::string> words) {
  CLI::App app("", "made");
  CLI::App& verb = *app.add_subcommand("verb");
  add(verb);
  app.require_subcommand(1);
  words.insert(words.begin(), {"made", "verb"});
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  const int status = kSuccess;
  return run_program(app, static_cast<int>(pointers.size()), pointers.data(), status);
}

TEST(RunProgram, RefusesEmptyNamesOfFilesAndFolders) {
  std::string value, text;
  std::vector<std::string> list;
  const auto add = [&](CLI::App& verb) {
    add_value(verb, "-o,--output", value, "FILE", "");
    add_data_option(verb, value);
    add_value(verb, "--either", value, "DIR|FILE", "");
    add_value(verb, "files", list, "FILE...", "");
    add_value(verb, "--title", text, "TEXT", "");
  };
  EXPECT_EQ(run(add, {"-o", "x", "--title", ""}), kSuccess);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"-o", ""}, {"--data", ""}, {"--either", ""}, {"x", ""}, {""}}) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(run(add, words), kUsage) << words[0];
    EXPECT_THAT(::testing::internal::GetCapturedStderr(),
                ::testing::HasSubstr("the name of a file or folder is empty"));
  }
}

TEST(RunProgram, PrintsNothingThatControlsATerminal) {
  const std::string name = "a\x1b]0;x\x07\u202e", shown = "a\\x1b]0;x\\x07\\u{202e}";
  const std::array<std::function<void()>, 3> ends{
      [&] { throw FileError(name); }, [&] { throw UsageError(name); },
      [&] {
        throw InvalidInput({{Severity::kError, name, "$", "code", name}});
      }};
  for (const auto& end : ends) {
    ::testing::internal::CaptureStderr();
    EXPECT_NE(run([&](CLI::App& verb) { verb.callback(end); }, {}), kSuccess);
    const std::string printed = ::testing::internal::GetCapturedStderr();
    EXPECT_THAT(printed, ::testing::HasSubstr(shown));
    EXPECT_EQ(printed, printable(printed));
  }
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run([](CLI::App&) {}, {name}), kUsage);
  const std::string refused = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(refused, printable(refused));
  ::testing::internal::CaptureStdout();
  say("{}\n", name);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), shown + "\n");
}

}  // namespace EN_UNIT
}  // namespace enfilade::apps
