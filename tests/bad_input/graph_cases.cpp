#include <string>

#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

constexpr const char* kCheck = "graph check {}/connectivity";

Case refused(std::string input, std::string says, std::function<void(Files&)> damage) {
  return {"Graphs that are refused", std::move(input), kCheck, 1,
          std::move(says),           std::move(damage)};
}

Case odd(std::string input, std::string says, std::function<void(Files&)> damage) {
  return {"Graphs that are odd", std::move(input), kCheck, 0, std::move(says), std::move(damage)};
}

Case list(std::string input, std::string says, std::function<void(Files&)> damage) {
  return {"Lists of scans", std::move(input), kCheck, 3, std::move(says), std::move(damage)};
}

// As editors, spreadsheets and shells save them: nothing is wrong.
Case good_list(std::string input, std::string text) {
  return {"Lists of scans",
          std::move(input),
          kCheck,
          0,
          "0 errors, 0 warnings",
          [text = std::move(text)](Files& f) { f.write(kScans, text); }};
}

std::function<void(Files&)> edited(const std::string& from, const std::string& to) {
  return [=](Files& files) { files.edit(kGraph, from, to); };
}

std::function<void(Files&)> replaced(const std::string& content) {
  return [=](Files& files) { files.write(kGraph, content); };
}

std::vector<Case> broken_json() {
  return {
      refused("an empty file", "$: line 1, column 1: the file is empty, not JSON", replaced("")),
      refused("a file cut off in the middle", "the file ends too early",
              [](Files& f) { f.write(kGraph, f.content(kGraph).substr(0, 500)); }),
      refused("NaN in a pose", "$[0].pose[1]: line 1, column 31: NaN and Infinity are not JSON",
              edited("[1.0,0.0,", "[1.0,NaN,")),
      refused("a number past the range of doubles", "$[0].pose[0]", edited("[1.0,", "[1e999,")),
      refused("bytes that are not UTF-8", "one_connectivity.json: $",
              edited("\"v0\"", "\"\xff\xfe\"")),
      refused("brackets nested 5,000 deep", "one_connectivity.json: $",
              replaced(std::string(5000, '['))),
      refused("text after the end", "not JSON at", [](Files& f) { f.append(kGraph, "}"); }),
      refused("a picture in its place", "not JSON at", replaced("\x89PNG\r\n\x1a\n")),
  };
}

std::vector<Case> broken_fields() {
  return {
      refused("an object instead of the array", "$: object, not an array", replaced("{}")),
      refused("an entry that is no object", "$[0]: number 7, not an object", replaced("[7]")),
      refused("no image_id", "$[0]: has no field \"image_id\" [missing-field]",
              edited("\"image_id\":\"v0\",", "")),
      refused("an image_id that is a number", "$[0].image_id: number 5, not a string",
              edited("\"v0\"", "5")),
      refused("an empty image_id", "$[0].image_id: an empty id [bad-id]", edited("\"v0\"", "\"\"")),
      refused("an image_id that leads out of its folder",
              "$[0].image_id: \"../../x\" is not an id: 1 to 100 of the characters",
              edited("\"v0\"", "\"../../x\"")),
      refused("an image_id of 1 MB", "\"... (1000000 bytes) is not an id",
              edited("\"v0\"", "\"" + std::string(1'000'000, 'a') + "\"")),
      refused("an image_id with an escape sequence", "\"\\x1b[2J\" is not an id",
              edited("\"v0\"", "\"\\u001b[2J\"")),
      refused("two viewpoints of one id", "$[1].image_id: \"v0\" stands at $[0] already",
              edited("\"v1\"", "\"v0\"")),
      refused("a field given twice", "$[0].included: given twice in one object",
              edited("\"included\":true", "\"included\":true,\"included\":false")),
      refused("a pose of 15 numbers", "$[0].pose: 15 numbers, not 16 (a 4 x 4 matrix)",
              edited("[1.0,", "[")),
      refused("a pose with a string", "$[0].pose[0]: string \"1\", not a number",
              edited("[1.0,", "[\"1\",")),
      refused("a position of 1e200 m", "$[0].pose[3]: 1e+200 is no length in metres",
              edited("[1.0,0.0,0.0,0.0,", "[1.0,0.0,0.0,1e200,")),
      refused("included: 1", "$[0].included: number 1, not true or false",
              edited("\"included\":true", "\"included\":1")),
      refused("unobstructed one flag short",
              "$[0].unobstructed: 5 flags, not 6 (one for each viewpoint of the file)",
              edited("\"unobstructed\":[false,", "\"unobstructed\":[")),
      refused("visible one flag long", "$[0].visible: 7 flags, not 6",
              edited("\"visible\":[", "\"visible\":[true,")),
      refused("a flag that is null", "$[0].unobstructed[0]: null, not true or false",
              edited("\"unobstructed\":[false,", "\"unobstructed\":[null,")),
      refused("a height of 1e9 m", "$[0].height: 1000000000 is no length in metres [bad-height]",
              edited("\"height\":1.5", "\"height\":1e9")),
      refused("a height in words", "$[0].height: string \"tall\", not a number",
              edited("\"height\":1.5", "\"height\":\"tall\"")),
      refused("a listed scan whose file is not there", "one_connectivity.json: cannot open",
              [](Files& f) { f.remove(kGraph); }),
      refused("a folder in the file's place", "cannot read: Is a directory",
              [](Files& f) { f.remove(kGraph).write(std::string(kGraph) + "/x", ""); }),
  };
}

std::vector<Case> odd_graphs() {
  return {
      odd("a byte-order mark before the JSON", "0 errors, 0 warnings",
          [](Files& f) { f.write(kGraph, "\xEF\xBB\xBF" + f.content(kGraph)); }),
      odd("an edge in one direction only", "[one-way-edge]",
          edited("\"unobstructed\":[false,true,", "\"unobstructed\":[false,false,")),
      odd("an edge of 10 m", "[long-edge]", edited("0.0,0.0,8.0,", "0.0,0.0,16.0,")),
      odd("a viewpoint that is its own neighbour", "[self-edge]",
          edited("\"unobstructed\":[false,", "\"unobstructed\":[true,")),
      odd("a viewpoint with no edge, and a graph in parts", "[isolated-viewpoint]",
          [](Files& f) {
            f.edit(kGraph, "\"unobstructed\":[false,true,", "\"unobstructed\":[false,false,")
                .edit(kGraph, "\"unobstructed\":[true,", "\"unobstructed\":[false,");
          }),
      odd("a pose that stretches", "[bad-pose]", edited("[1.0,", "[2.0,")),
      odd("two neighbours at one point", "[same-position]", edited("0.0,0.0,2.0,", "0.0,0.0,0.0,")),
      odd("a file that scans.txt does not name", "[unlisted-file]",
          [](Files& f) { f.write("connectivity/three_connectivity.json", "[]"); }),
  };
}

std::vector<Case> scan_lists() {
  return {
      good_list("a byte-order mark, CR LF, blank lines and a comment",
                "\xef\xbb\xbf# ours\r\none\r\n\r\ntwo\r\n\r\n"),
      good_list("UTF-16, as Windows PowerShell writes it", utf16("one\r\ntwo")),
      good_list("the files' names, as `ls` prints them",
                "one_connectivity.json\ntwo_connectivity.json\n"),
      list("an empty scans.txt", "lists no scan; one id a line is expected",
           [](Files& f) { f.write(kScans, "\n"); }),
      list("a scan listed twice", "\"one\" stands in the list twice",
           [](Files& f) { f.append(kScans, "one\n"); }),
      list("a line of 1 MB", "\"... (1000000 bytes) is not an id",
           [](Files& f) { f.append(kScans, std::string(1'000'000, 'a') + "\n"); }),
      list("a scan id that is a path", "\"../one\" is not an id",
           [](Files& f) { f.append(kScans, "../one\n"); }),
  };
}

}  // namespace

std::vector<Case> graph_cases() {
  std::vector<Case> all;
  for (const auto& part : {broken_json(), broken_fields(), odd_graphs(), scan_lists()}) {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

}  // namespace enfilade::bad_input
