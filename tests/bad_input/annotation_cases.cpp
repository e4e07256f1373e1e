#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

Case refused(std::string input, std::string says, std::function<void(Files&)> damage) {
  return {"Annotations",   std::move(input), "stats --data {} --split made", 3,
          std::move(says), std::move(damage)};
}

Case edited(std::string input, std::string says, const std::string& from, const std::string& to) {
  return refused(std::move(input), std::move(says),
                 [=](Files& files) { files.edit(kAnnotations, from, to); });
}

Case regions(std::string input, std::string says, const std::string& content) {
  return {"Region maps",
          std::move(input),
          "sample --data {} -o {}/new.json",
          3,
          std::move(says),
          [=](Files& files) { files.write(kRegions, content); }};
}

}  // namespace

std::vector<Case> annotation_cases() {
  return {
      refused("an object instead of the array", "$[0]: has no field \"path_id\"",
              [](Files& f) { f.write(kAnnotations, "{}"); }),
      refused("a file cut off in the middle", "the file ends too early",
              [](Files& f) { f.write(kAnnotations, f.content(kAnnotations).substr(0, 80)); }),
      edited("no path", "$[0]: has no field \"path\"", "\"path\":", "\"way\":"),
      edited("an empty path", "$[0].path", "\"path\":[\"v0\",\"v1\",\"v2\",\"v3\",\"v4\"]",
             "\"path\":[]"),
      edited("a path_id of 1.5", "$[0].path_id: number 1.5, not a whole number", "\"path_id\":1",
             "\"path_id\":1.5"),
      edited("a negative path_id", "$[0].path_id: -1 is no id", "\"path_id\":1", "\"path_id\":-1"),
      edited("two entries of one path_id", "$[1].path_id", "\"path_id\":2", "\"path_id\":1"),
      edited("a heading in words", "$[0].heading: string \"north\", not a number",
             "\"heading\":1.5", "\"heading\":\"north\""),
      edited("a heading of 1e308", "$[0].heading: 1e+308 radians, not from -10000 to 10000",
             "\"heading\":1.5", "\"heading\":1e308"),
      edited("instructions that are no array", "$[0].instructions: string \"go\", not an array",
             "[\"Walk on.\",\"Go on and on.\",\"Straight on.\"]", "\"go\""),
      edited("an instruction that is a number", "$[0].instructions[0]: number 3, not a string",
             "\"Walk on.\"", "3"),
      edited("a scan that is a path", "$[0].scan: \"../one\" is not an id", "\"scan\":\"one\"",
             "\"scan\":\"../one\""),
      edited("a viewpoint that is a path", "$[0].path[1]: \"a/v1\" is not an id", "\"v1\"",
             "\"a/v1\""),
      edited("a scan that is not listed", "$[0].scan", "\"scan\":\"one\"", "\"scan\":\"three\""),
      edited("a viewpoint that is not in the scan", "$[0].path[1]", "\"v1\"", "\"v9\""),
      edited("an excluded viewpoint", "$[0].path[4]", "\"v4\"", "\"v5\""),
      edited("a step between viewpoints that are not adjacent", "$[0].path[1]", "\"v1\",", ""),
      regions("a region map that is an array", "$: array of 0, not an object", "[]"),
      regions("a region that is no number", "region \"kitchen\", not a whole number from 0 on",
              R"({"one": {"kitchen": []}})"),
      regions("a viewpoint that is a path", "$.one.0[0]: \"../v0\" is not an id",
              R"({"one": {"0": ["../v0"]}})"),
      regions("a viewpoint in two regions", "viewpoint \"v0\" is in region 0 already",
              R"({"one": {"0": ["v0"], "1": ["v0"]}})"),
  };
}

}  // namespace enfilade::bad_input
