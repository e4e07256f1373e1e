#include "enfilade/core/gzip.h"
#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

constexpr const char* kScore = "score {}/results.json --data {} --split made";

Case refused(std::string input, std::string says, std::function<void(Files&)> damage) {
  return {"Results", std::move(input), kScore, 1, std::move(says), std::move(damage)};
}

Case edited(std::string input, std::string says, const std::string& from, const std::string& to) {
  return refused(std::move(input), std::move(says),
                 [=](Files& files) { files.edit(kResults, from, to); });
}

void empty_split(Files& files) {
  files.write(kAnnotations, "[]");
  files.write(kResults, "[]");
}

// Halves, each a gzip of its own.
void pack(Files& files) {
  const std::string text = files.content(kResults);
  files.write("results.json.gz", gzip(text.substr(0, 99), 6) + gzip(text.substr(99), 6));
  files.remove(kResults);
}

}  // namespace

std::vector<Case> result_cases() {
  const std::string first =
      "{\"instr_id\": \"1_0\", \"trajectory\": [[\"v0\", 1.5, 0], [\"v1\", 1.5, 0], "
      "[\"v2\", 1.5, 0]]},\n ";
  return {
      refused("an empty file", "the file is empty, not JSON",
              [](Files& f) { f.write(kResults, ""); }),
      refused("a file cut off in the middle", "the file ends too early",
              [](Files& f) { f.write(kResults, f.content(kResults).substr(0, 150)); }),
      refused("an object instead of the array", "$: object, not an array",
              [](Files& f) { f.write(kResults, "{}"); }),
      edited("a heading that is NaN",
             "$[0].trajectory[0][1]: line 1, column 44: NaN and Infinity are not JSON",
             "[\"v0\", 1.5, 0]", "[\"v0\", NaN, 0]"),
      edited("a heading in words", "$[0].trajectory[0][1]: string \"left\", not a number",
             "[\"v0\", 1.5, 0]", "[\"v0\", \"left\", 0]"),
      edited("no trajectory", "$[0]: has no field \"trajectory\"", "\"trajectory\"", "\"path\""),
      edited("a trajectory that is a string", "$[0].trajectory: string \"v0\", not an array",
             "[[\"v0\", 1.5, 0], [\"v1\", 1.5, 0], [\"v2\", 1.5, 0]]", "\"v0\""),
      edited("an empty trajectory", "$[0].trajectory",
             "[[\"v0\", 1.5, 0], [\"v1\", 1.5, 0], [\"v2\", 1.5, 0]]", "[]"),
      edited("an entry of two", "$[0].trajectory[0]", "[\"v0\", 1.5, 0]", "[\"v0\", 1.5]"),
      edited("an entry that is a number", "$[0].trajectory[0]", "[\"v0\", 1.5, 0]", "7"),
      edited("an instr_id that is a number", "$[0].instr_id: number 10, not a string", "\"1_0\"",
             "10"),
      edited("an instr_id that is a path", "$[0].instr_id: \"../1_0\" is not an id", "\"1_0\"",
             "\"../1_0\""),
      edited("a viewpoint that is a path", "$[0].trajectory[1][0]: \"../v1\" is not an id",
             "\"v1\"", "\"../v1\""),
      edited("a heading of 1e308",
             "$[0].trajectory[0][1]: 1e+308 radians, not from -10000 to 10000", "1.5", "1e308"),
      edited("an unknown instr_id", "$[0].instr_id", "\"1_0\"", "\"7_0\""),
      edited("an instr_id twice", "$[1].instr_id", "\"1_1\"", "\"1_0\""),
      edited("a missing instr_id", "1_0", first, ""),
      edited("a wrong start", "$[0].trajectory[0]", "[\"v0\", 1.5, 0], [\"v1\", 1.5, 0]",
             "[\"v1\", 1.5, 0]"),
      edited("an unknown viewpoint", "$[0].trajectory[1]", "\"v1\"", "\"v9\""),
      edited("an excluded viewpoint", "$[0].trajectory[2]", "\"v2\"", "\"v5\""),
      edited("a jump", "$[0].trajectory[1]", "[\"v1\", 1.5, 0], ", ""),
      {"Results", "a fourth instruction, which is not scored", kScore, 0, "warning",
       [](Files& f) {
         f.edit(kResults, "[{", "[{\"instr_id\": \"2_3\", \"trajectory\": [\"v0\"]}, {");
       }},
      {"Results", "a packed file of two members", "score {}/results.json.gz --data {} --split made",
       0, "made: 6 episodes", pack},
      {"Results", "a packed file, named without .gz", kScore, 0, "made: 6 episodes", pack},
      {"Results",
       "a device without an end",
       "score /dev/zero --data {} --split made",
       3,
       "/dev/zero: cannot read: more than 67108864 bytes",
       {}},
      {"Results", "a pipe that no program writes to", kScore, 3,
       "{}/results.json: cannot read: a pipe that no program writes to",
       [](Files& f) { f.write(kResults, kPipe); }},
      {"Results",
       "no file",
       "score {}/none.json --data {} --split made",
       3,
       "{}/none.json: cannot open: No such file or directory",
       {}},
      {"Results",
       "a split whose goals are hidden",
       "score {}/results.json --data {} --split hidden",
       2,
       "hidden",
       {}},
      {"Results", "annotations without an episode",
       "score {}/results.json --data {} --annotations {}/r2r/R2R_made.json", 3,
       "split \"R2R_made\": the annotations have no episode, so there is nothing to run or score",
       empty_split},
      {"Results", "a split without an episode, scored", kScore, 3, "[no-episodes]", empty_split},
      {"Results", "a split without an episode, run", "run --data {} --split made --agent shortest",
       3, "[no-episodes]", empty_split},
  };
}

}  // namespace enfilade::bad_input
