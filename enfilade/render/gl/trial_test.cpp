#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>

#include "enfilade/render/devices.h"
#include "enfilade/render/gl/trial.h"
#include "tests/support/refusal.h"

namespace enfilade::render::gl {
namespace EN_UNIT {

using How = ChildEnd::How;

/// What a shell did with a script, and the lines it printed; those that begin with "+" count.
struct Outcome {
  ChildEnd end;
  std::vector<std::string> lines;
  double seconds = 0;
};
Outcome run(const std::vector<std::string>& command, double seconds = 20) {
  Outcome run;
  const auto start = std::chrono::steady_clock::now();
  run.end = run_child(command, seconds, [&](std::string_view line) {
    run.lines.emplace_back(line);
    return line.starts_with('+');
  });
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return run;
}
Outcome run_script(const std::string& script, double seconds = 20) {
  return run({"/bin/sh", "-c", script}, seconds);
}

TEST(Child, GivesItsLinesAndItsExitStatus) {
  const Outcome ran = run_script("echo one; echo two >&2; cat; printf 'three\\nrest'; exit 5");
  EXPECT_EQ(ran.end.how, How::kExited);
  EXPECT_EQ(ran.end.code, 5);
  EXPECT_EQ(ran.lines, (std::vector<std::string>{"one", "three"}));
}

TEST(Child, TellsTheSignalThatKilledIt) {
  const Outcome ran = run_script("kill -BUS $$");
  EXPECT_EQ(ran.end.how, How::kKilled);
  EXPECT_EQ(ran.end.code, SIGBUS);
}

TEST(Child, LeavesItNoHandlerAndNoMaskOfSignals) {
  const auto before = std::signal(SIGTERM, SIG_IGN);
  sigset_t term, old;
  sigemptyset(&term);
  sigaddset(&term, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &term, &old);
  const Outcome ran = run_script("kill -TERM $$; sleep 5");
  pthread_sigmask(SIG_SETMASK, &old, nullptr);
  std::signal(SIGTERM, before);
  EXPECT_EQ(ran.end.how, How::kKilled);
  EXPECT_EQ(ran.end.code, SIGTERM);
}

TEST(Child, IsKilledWhereItIsSilentForTooLong) {
  for (const char* script :
       {"exec sleep 60", "while :; do echo no; sleep 0.02; done", "exec >/dev/null; sleep 60"}) {
    const Outcome ran = run_script(script, 0.3);
    EXPECT_EQ(ran.end.how, How::kSilent) << script;
    EXPECT_LT(ran.seconds, 30) << script;
  }
}

TEST(Child, HasTimeAnewAfterEachLineThatCounts) {
  const Outcome ran = run_script("for i in 1 2 3 4; do sleep 0.5; echo +; done", 1.5);
  EXPECT_EQ(ran.end.how, How::kExited);
  EXPECT_EQ(ran.lines.size(), 4U);
}

TEST(Child, ThatIsNoProgramIsNotStarted) {
  const Outcome ran = run({"/nowhere/enfilade"});
  EXPECT_EQ(ran.end.how, How::kNotStarted);
  EXPECT_EQ(ran.end.code, ENOENT);
  EXPECT_EQ(run_script("exit 127").end.how, How::kNotStarted);  // as POSIX lets it be told
  EXPECT_EQ(run_script("echo; exit 127").end.how, How::kExited);
}

TEST(Child, OfAProcessThatDoesNotWaitForItsOwnEndsToo) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);  // the system then forgets exit statuses
  const Outcome ran = run_script("echo +; exit 5");
  std::signal(SIGCHLD, before);
  EXPECT_EQ(ran.end.how, How::kExited);
  EXPECT_EQ(ran.end.code, -1);
  EXPECT_EQ(ran.lines.size(), 1U);
}

TEST(TrialWords, ComeBackAsTheyWent) {
  const std::string line = line_of({"device", "", "two\nlines", "a\ttab", "C:\\new"});
  ASSERT_TRUE(line.starts_with('\n') && line.ends_with('\n'));
  EXPECT_EQ(words_of(line.substr(1, line.size() - 2)),
            (std::vector<std::string>{"device", "", "two\nlines", "a\ttab", "C:\\new"}));
}

TEST(TrialWords, AreNoneInOtherLines) {
  for (const char* line :
       {"", "MESA: error", "enfilade-gl", "enfilade-glue\tx", " enfilade-gl\tx"}) {
    EXPECT_TRUE(words_of(line).empty()) << line;
  }
}

TEST(TryGl, RefusesOtherArguments) {
  using Words = std::vector<std::string>;
  for (const Words& words : {Words{}, Words{"list"}, Words{"make", ""}, Words{"find", "", "0"}}) {
    EXPECT_EQ(try_gl(words), 2);
  }
}

TEST(Trial, ALimitThatIsNoNumberIsRefused) {
  setenv("ENFILADE_GL_SECONDS", "soon", 1);
  EXPECT_EQ(tests::refusal<ArgumentError>([] { gl_devices(); }),
            "ENFILADE_GL_SECONDS: \"soon\", not a number of seconds from 0 to 1000000 (0: drivers "
            "are not tried first)");
  unsetenv("ENFILADE_GL_SECONDS");
}

}  // namespace EN_UNIT
}  // namespace enfilade::render::gl
