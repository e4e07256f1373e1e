// Files of other benchmarks than R2R. All of what they say is SYNTHETIC.
#include <initializer_list>

#include "enfilade/core/gzip.h"
#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

// A good file of a benchmark, which cases damage.
struct Good {
  std::string group, task, file, text;
};

const Good kGuide{
    "RxR guides", "rxr", "rxr/rxr_made_guide.jsonl",
    R"({"path_id": 1, "split": "made", "scan": "one", "heading": 1.5, "path": ["v0", "v1", "v2"], )"
    R"("instruction_id": 7, "annotator_id": 1, "language": "en-US", "instruction": "Walk on.", )"
    R"("timed_instruction": [{"start_time": 0.4, "word": "Walk", "end_time": 1.0}, )"
    R"({"word": "on."}], "edit_distance": 0.1})"
    "\n"};
const Good kReverie{
    "REVERIE", "reverie", "reverie/REVERIE_made.json",
    R"([{"id": "1_5", "path": ["v0", "v1", "v2"], "objId": 5, "heading": 1.5, "scan": "one", )"
    R"("path_id": 1, "instructions": ["Go to the vase."]}])"};
const Good kBoxes{"REVERIE's boxes", "reverie", "reverie/BBoxes.json",
                  R"({"one_v2": {"5": {"name": "vase", "visible_pos": [0, 12], )"
                  R"("bbox2d": [[1, 2, 3, 4], [5, 6, 7, 8]]}}})"};
const Good kObjectLines{
    "HM3DAutoVLN's lines", "reverie", "reverie/REVERIE_made.json",
    R"({"instr_id": "one_000_5_0", "scan": "one", "path": ["v0", "v1"], "pos_vps": ["v1", "v2"], )"
    R"("objid": 5, "instruction": "Find the vase.", "instr_encoding": [101, 102]})"
    "\n"};
const Good kCvdn{
    "CVDN", "cvdn", "cvdn/made.json",
    R"([{"inst_idx": 12, "scan": "one", "target": "plant", "start_pano": {"heading": 1.2, )"
    R"("elevation": 0.0, "pano": "v0"}, "dialog_history": [{"nav_idx": 0, "role": "navigator", )"
    R"("message": "Left?"}], "game_idx": 3, "end_panos": ["v3"], "player_path": ["v0", "v1"], )"
    R"("planner_path": ["v0", "v1", "v2"]}])"};
const Good kEncodedCvdn{
    "CVDN as HAMT reads it", "cvdn", "CVDN/annotations/made_enc.json",
    R"([{"instr_id": "12", "scan": "one", "target": "plant", "start_pano": "v1", )"
    R"("start_heading": 1.2, "end_panos": ["v3"], "nav_steps": ["v0", "v1", "v2"], "nav_idx": 1, )"
    R"("instr_encoding": [101, 102]}])"};
const Good kSoon{
    "SOON as released", "soon", "soon/made.json",
    R"([{"path": [["v0", "v1", "v2"]], "instructions": [["vase", "blue", "on the table", )"
    R"("kitchen", "Find the blue vase."]], "bboxes": [{"scan": "one", "image_id": "v2", )"
    R"("obj_name": "vase", "target": {"center": {"heading": 0.1, "elevation": 0}, )"
    R"("left_top": {"heading": 0, "elevation": 0.1}, "right_top": {"heading": 0.2, )"
    R"("elevation": 0.1}, "right_bottom": {"heading": 0.2, "elevation": -0.1}, )"
    R"("left_bottom": {"heading": 0, "elevation": -0.1}}}]}])"};
const Good kSoonLines{
    "SOON as DUET reads it", "soon", "SOON/annotations/bert_enc/made_enc.jsonl",
    R"({"path_id": "1-0", "scan": "one", "path": ["v0", "v1", "v2"], "instructions": )"
    R"([{"full": "Find the vase.", "obj_name": "vase"}], "instr_encodings": [{"full": [101, 102]}], )"
    R"("bboxes": []})"
    "\n"};
const Good kBack{
    "R2R-Back", "r2r-back", "r2r-back/R2R_made.json",
    R"([{"path_id": 1, "scan": "one", "heading": 1.5, "path": ["v0", "v1", "v0"], "midstop": "v1", )"
    R"("instructions": ["There and back."]}])"};
const Good kJoined{
    "R4R", "r4r", "r4r/R4R_made.json",
    R"([{"distance": 4, "first_path_id": 1, "second_path_id": 2, "heading": 1.5, "instructions": )"
    R"(["Walk.Go."], "path": ["v0", "v1", "v2"], "path_id": 0, "scan": "one", )"
    R"("shortest_path": ["v0", "v1", "v2"], "shortest_path_distance": 4}])"};
const Good kFine{
    "Fine-grained R2R", "r2r", kAnnotations,
    R"([{"path_id": 1, "scan": "one", "heading": 1.5, "path": ["v0", "v1", "v2"], "instructions": )"
    R"(["Walk on."], "new_instructions": "[[['walk'], ['on']]]", "chunk_view": [[[1, 2], [2, 3]]]}])"};
const Good kTextIds{
    "ScaleVLN's ids and lines", "r2r", kAnnotations,
    R"([{"path_id": "one_12", "scan": "one", "heading": 1.5, "path": ["v0", "v1", "v2"], )"
    R"("instructions": ["Walk on."], "instr_encodings": [[101, 102]]}, {"path_id": "one_13", )"
    R"("scan": "one", "heading": 1.5, "path": ["v0", "v1"], "instructions": ["Go."]}])"};
const Good kPretraining{"ScaleVLN's ids and lines", "r2r", kAnnotations,
                        R"({"instr_id": "one_12_0", "scan": "one", "path": ["v0", "v1", "v2"], )"
                        R"("instr_encoding": [101, 102]})"
                        "\n"};

std::string score_of(const Good& good) {
  // Of R2R, only a named file is looked at for its form.
  const std::string file = good.task == "r2r" ? " --annotations {}/" + good.file : "";
  return "score {}/results.json --data {} --split made --task " + good.task + file;
}

// The good file with one thing changed; another whole text; boxes where the task asks for them.
void lay_out(Files& files, const Good& good, const std::string& text) {
  if (good.task == "reverie") {
    files.write(kReverie.file, kReverie.text).write(kBoxes.file, kBoxes.text);
  }
  files.write(good.file, text);
}

Case whole(const Good& good, std::string input, std::string says, const std::string& text) {
  return {good.group, std::move(input), score_of(good),
          3,          std::move(says),  [good, text](Files& files) { lay_out(files, good, text); }};
}

Case edited(const Good& good, std::string input, std::string says, const std::string& from,
            const std::string& to) {
  return {good.group,
          std::move(input),
          score_of(good),
          3,
          std::move(says),
          [good, from, to](Files& files) {
            lay_out(files, good, good.text);
            files.edit(good.file, from, to);
          }};
}

std::vector<Case> guides() {
  const Good& g = kGuide;
  return {
      whole(g, "an empty file", "$: the file is empty; a list, or lines of JSON, are expected", ""),
      whole(g, "a line cut off", "rxr_made_guide.jsonl:1", g.text.substr(0, 90)),
      whole(g, "gzip that is damaged", "cannot unpack", "\x1f\x8b\x08 no more"),
      whole(g, "gzip with other bytes behind its end",
            "cannot unpack: bytes after the end of the compressed text", gzip(g.text, 6) + "more"),
      edited(g, "no instruction_id", "$[0]: has no field \"instruction_id\"", "\"instruction_id\"",
             "\"instr\""),
      edited(g, "a negative instruction_id", "$[0].instruction_id: -7 is no id", ": 7", ": -7"),
      edited(g, "a path_id in words", "$[0].path_id: string \"one\", not a whole number",
             "\"path_id\": 1", "\"path_id\": \"one\""),
      edited(g, "a language that RxR does not have", "$[0].language: \"de-DE\" is no language",
             "en-US", "de-DE"),
      edited(g, "an empty path", "$[0].path: no viewpoint; the start at least is expected",
             R"(["v0", "v1", "v2"])", "[]"),
      edited(g, "a heading in words", "$[0].heading: string \"north\", not a number", "1.5",
             "\"north\""),
      edited(g, "timed words that are a text", "$[0].timed_instruction: string", "[{\"start_time\"",
             "\"Walk\", \"x\": [{\"start_time\""),
      edited(g, "a timed word without its word", "$[0].timed_instruction[1]: has no field \"word\"",
             "{\"word\": \"on.\"}", "{}"),
      edited(g, "a time in words",
             "$[0].timed_instruction[0].start_time: string \"soon\", not a number", "0.4",
             "\"soon\""),
      edited(g, "a path that goes on where the goal is hidden", "not the start alone",
             "\"path_id\": 1, ", ""),
      edited(g, "a negative token", "$[0].instr_encoding[0]: -1 is no token id", "\"split\"",
             "\"instr_encoding\": [-1], \"split\""),
      whole(g, "two lines of one instruction", "$[1].instruction_id: \"7\" stands at $[0] already",
            g.text + g.text),
      edited(g, "a scan that is not there", "$[0].scan", "\"one\"", "\"three\""),
      edited(g, "a viewpoint that is not there", "$[0].path[2]", "\"v2\"", "\"v9\""),
      edited(g, "a step between viewpoints that are not adjacent", "$[0].path[1]", "\"v1\", ", ""),
  };
}

std::vector<Case> reverie() {
  const Good& g = kReverie;
  return {
      whole(g, "a file cut off in the middle", "the file ends too early", g.text.substr(0, 60)),
      edited(g, "no id", "$[0]: has no field \"id\"", "\"id\"", "\"name\""),
      edited(g, "an id of another object", "$[0].id: \"1_6\", not \"1_5\", its path_id and objId",
             "1_5", "1_6"),
      edited(g, "a negative objId", "$[0].objId: -5 is no id", "\"objId\": 5", "\"objId\": -5"),
      edited(g, "an objId that is a text", "$[0].objId: string \"5\"", "\"objId\": 5",
             "\"objId\": \"5\""),
      edited(g, "an objId without a path_id", "$[0]: has \"objId\", but no field \"path_id\"",
             "\"path_id\": 1, ", ""),
      edited(g, "a path that goes on where the goal is hidden", "not the start alone",
             "\"objId\": 5, ", ""),
      edited(g, "an empty path", "$[0].path: no viewpoint", R"(["v0", "v1", "v2"])", "[]"),
      edited(g, "an instruction that is a number", "$[0].instructions[0]: number 3, not a string",
             "\"Go to the vase.\"", "3"),
      edited(g, "token ids of other instructions",
             "$[0].instr_encodings: 2 lists of tokens; 1 are expected", "\"scan\"",
             "\"instr_encodings\": [[1], [2]], \"scan\""),
      edited(g, "an object that nobody sees", "$[0].objId: no viewpoint of scan one sees object 6",
             R"("1_5", "path": ["v0", "v1", "v2"], "objId": 5)",
             R"("1_6", "path": ["v0", "v1", "v2"], "objId": 6)"),
      edited(g, "a viewpoint that is not there", "$[0].path[0]", "\"v0\"", "\"v9\""),
  };
}

std::vector<Case> boxes() {
  const Good& g = kBoxes;
  return {
      whole(g, "a list instead of the object", "$: array of 0, not an object", "[]"),
      edited(g, "a viewpoint without a scan", "BBoxes.json: $", "one_v2", "v2"),
      edited(g, "an object that is no number", "$.one_v2", "\"5\"", "\"vase\""),
      edited(g, "an object without a name", "has no field \"name\"", "\"name\"", "\"title\""),
      edited(g, "views that are a number", ".visible_pos: number 0, not an array", "[0, 12]", "0"),
      edited(g, "a view beyond 35", ".visible_pos[1]", "12]", "36]"),
      edited(g, "a view given twice", ".visible_pos[1]", "12]", "0]"),
      edited(g, "a box of three numbers", ".bbox2d[0]", "[1, 2, 3, 4]", "[1, 2, 3]"),
      edited(g, "a box with a text", ".bbox2d[0][0]: string \"left\"", "[1, 2, 3, 4]",
             "[\"left\", 2, 3, 4]"),
      edited(g, "a box of negative width", ".bbox2d[0]", "[1, 2, 3, 4]", "[1, 2, -3, 4]"),
      edited(g, "fewer boxes than views", ".bbox2d", "[1, 2, 3, 4], ", ""),
  };
}

std::vector<Case> object_lines() {
  const Good& g = kObjectLines;
  return {
      edited(g, "no object", "$[0]: has no field \"objid\"", "\"objid\": 5, ", ""),
      edited(g, "an object in words", "$[0].objid: \"vase\", not the number of an object",
             "5, \"in", "\"vase\", \"in"),
      edited(g, "no viewpoint that sees the object", "$[0].pos_vps: no viewpoint that sees",
             R"(["v1", "v2"])", "[]"),
      edited(g, "a viewpoint that is not there", "$[0].pos_vps[1]: viewpoint \"v9\"", "\"v2\"",
             "\"v9\""),
      whole(g, "an instr_id given twice", "$[1].instr_id: \"one_000_5_0\" stands at $[0] already",
            g.text + g.text),
  };
}

std::vector<Case> cvdn() {
  const Good &g = kCvdn, &e = kEncodedCvdn;
  return {
      edited(g, "a negative inst_idx", "$[0].inst_idx: -12 is no id", ": 12", ": -12"),
      edited(g, "a target that is a number", "$[0].target: number 3, not a string", "\"plant\"",
             "3"),
      edited(g, "a start that is no object", "$[0].start_pano: string \"v0\", not an object",
             R"({"heading": 1.2, "elevation": 0.0, "pano": "v0"})", "\"v0\""),
      edited(g, "a start without a viewpoint", "$[0].start_pano: has no field \"pano\"",
             ", \"pano\": \"v0\"", ""),
      edited(g, "somebody else who speaks", "neither \"navigator\" nor \"oracle\"", "\"navigator\"",
             "\"guide\""),
      edited(g, "a negative step", "$[0].dialog_history[0].nav_idx: -1 is no number of steps",
             "\"nav_idx\": 0", "\"nav_idx\": -1"),
      edited(g, "an empty region", "$[0].end_panos: no viewpoint; one at least is expected",
             R"(["v3"])", "[]"),
      edited(g, "a player who begins elsewhere", "$[0].player_path[0]: \"v1\", not \"v0\"",
             R"(["v0", "v1"], "planner)", R"(["v1", "v1"], "planner)"),
      edited(g, "a region without the planner's path",
             "has \"end_panos\", but no field \"planner_path\"", "\"planner_path\"", "\"planner\""),
      edited(g, "a player's path without a region", "but no field \"end_panos\"", "\"end_panos\"",
             "\"ends\""),
      edited(g, "a viewpoint of the region that is not there", "$[0].end_panos[0]", "\"v3\"",
             "\"v9\""),
      edited(e, "a place beyond the steps", "$[0].nav_idx: 9, not 0 to 2", "\"nav_idx\": 1",
             "\"nav_idx\": 9"),
      edited(e, "another start than the steps'", "$[0].nav_steps[1]: \"v1\", not \"v2\", the start",
             "\"start_pano\": \"v1\"", "\"start_pano\": \"v2\""),
      edited(e, "an empty instr_id", "$[0].instr_id: an empty id", "\"12\"", "\"\""),
  };
}

std::vector<Case> soon() {
  const Good &g = kSoon, &l = kSoonLines;
  return {
      edited(g, "no path", "$[0]: has no field \"path\"", "\"path\"", "\"way\""),
      edited(g, "no alternative", "$[0].path", R"([["v0", "v1", "v2"]])", "[]"),
      edited(g, "an empty alternative", "$[0].path[0]: no viewpoint", R"(["v0", "v1", "v2"])",
             "[]"),
      edited(g, "an instruction of four texts", "$[0].instructions[0]", "\"vase\", \"blue\"",
             "\"blue vase\""),
      edited(g, "an instruction that is one text", "$[0].instructions[0]: string",
             R"(["vase", "blue", "on the table", "kitchen", "Find the blue vase."])",
             "\"Find it.\""),
      edited(g, "a box without a corner", "$[0].bboxes[0].target: has no field \"left_bottom\"",
             "left_bottom", "bottom"),
      edited(g, "a corner in words",
             "$[0].bboxes[0].target.center.heading: string \"left\", not a number",
             "\"heading\": 0.1", "\"heading\": \"left\""),
      edited(g, "a box at a viewpoint that is not there", "$[0].bboxes[0].image_id: viewpoint",
             "\"image_id\": \"v2\"", "\"image_id\": \"v9\""),
      edited(g, "neither boxes nor a scan", "$[0]", "\"scan\": \"one\", \"image_id\"",
             "\"image_id\""),
      edited(l, "a path_id that is one number", "$[0].path_id", "\"1-0\"", "\"10\""),
      edited(l, "an instruction without its whole", "$[0].instructions[0]: has no field \"full\"",
             "{\"full\": \"Find", "{\"text\": \"Find"),
      edited(l, "token ids of other instructions", "$[0].instr_encodings",
             "[{\"full\": [101, 102]}]", "[]"),
      whole(l, "a path_id given twice", "$[1].path_id: \"1-0\" stands at $[0] already",
            l.text + l.text),
  };
}

std::vector<Case> family() {
  const Good &b = kBack, &j = kJoined, &f = kFine, &t = kTextIds, &p = kPretraining;
  Good last = kBack;
  last.group = "R2R-Last";
  last.task = "r2r-last";
  last.file = "r2r-last/R2R_made.json";
  return {
      edited(b, "no turning point", "$[0]: has no field \"midstop\"", "\"midstop\": \"v1\", ", ""),
      edited(b, "a turning point that is not there", "$[0].midstop: viewpoint \"v9\"",
             "\"midstop\": \"v1\"", "\"midstop\": \"v9\""),
      edited(b, "a turning point that is a number", "$[0].midstop: number 1, not a string",
             "\"midstop\": \"v1\"", "\"midstop\": 1"),
      whole(last, "a turning point in another benchmark's file",
            "$[0].midstop: a turning point, as R2R-Back has them", last.text),
      edited(j, "a step between viewpoints that are not adjacent", "$[0].path[1]",
             R"("path": ["v0", "v1")", R"("path": ["v0")"),
      edited(j, "a length below zero", "$[0].distance: -4 is no length in metres", ": 4, \"first",
             ": -4, \"first"),
      edited(j, "no instruction", "$[0].instructions: path 0 has none to follow", R"(["Walk.Go."])",
             "[]"),
      edited(f, "sub-instructions that are no list", "$[0].new_instructions",
             "[[['walk'], ['on']]]", "walk on"),
      edited(f, "a word that does not end", "$[0].new_instructions", "'on'", "'on"),
      edited(f, "more chunks than sub-instructions", "$[0].chunk_view[0]", "[2, 3]",
             "[2, 3], [3, 3]"),
      edited(f, "a chunk beyond the path", "$[0].chunk_view[0][1]", "[2, 3]", "[2, 4]"),
      edited(f, "a chunk that goes back", "$[0].chunk_view[0][1]", "[2, 3]", "[3, 2]"),
      edited(t, "a path_id given twice", "$[1].path_id: \"one_12\" stands at $[0] already",
             "one_13", "one_12"),
      edited(t, "an empty path_id", "$[0].path_id: an empty id", "\"one_12\"", "\"\""),
      edited(t, "a token that is a text", "$[0].instr_encodings[0][1]: string \"end\"", "102",
             "\"end\""),
      edited(p, "an instr_id without a number at its end", "not <path_id>_<k>", "one_12_0",
             "one_12_x"),
      whole(p, "an instr_id given twice", "$[1].instr_id: \"one_12_0\" stands at $[0] already",
            p.text + p.text),
      edited(p, "no token ids", "$[0]: has no field \"instr_encoding\"", "instr_encoding",
             "encoding"),
  };
}

// What was handed in for a good file.
Case handed_in(const Good& good, std::string input, std::string says, const std::string& results) {
  return {"Results of other benchmarks",
          std::move(input),
          score_of(good),
          1,
          std::move(says),
          [good, results](Files& files) {
            lay_out(files, good, good.text);
            files.write(kResults, results);
          }};
}

std::vector<Case> results() {
  const std::string walk = R"("trajectory": [["v0", 0, 0], ["v1", 0, 0], ["v2", 0, 0]])";
  const std::string soon =
      R"([{"instr_id": "9-0_0", "trajectory": {"path": [["v0"], ["v1"]], "obj_heading": [0.3], )"
      R"("obj_elevation": [0.5]}}])";
  const auto soon_with = [soon](const std::string& from, const std::string& to) {
    std::string text = soon;
    return text.replace(text.find(from), from.size(), to);
  };
  return {
      handed_in(kReverie, "no object named", "$[0]: neither predObjId nor pred_objid",
                R"([{"instr_id": "1_5_0", )" + walk + "}]"),
      handed_in(kReverie, "an object that is a list", "$[0].predObjId",
                R"([{"instr_id": "1_5_0", "predObjId": [5], )" + walk + "}]"),
      handed_in(kReverie, "an instruction that is not there", "$[0].instr_id",
                R"([{"instr_id": "1_6_0", "predObjId": 5, )" + walk + "}]"),
      handed_in(kReverie, "no result for an instruction", "1_5_0", "[]"),
      handed_in(kBack, "no turning point", "$[0]: has no field \"midstop\"",
                R"([{"instr_id": "1_0", "trajectory": [["v0"], ["v1"], ["v0"]]}])"),
      handed_in(kBack, "a turning point that is not there", "$[0].midstop",
                R"([{"instr_id": "1_0", "midstop": "v9", "trajectory": [["v0"], ["v1"]]}])"),
      handed_in(kGuide, "another start", "$[0].trajectory[0]",
                R"([{"instr_id": "1_7", "trajectory": [["v1"], ["v2"]]}])"),
      handed_in(kGuide, "an empty trajectory", "$[0].trajectory",
                R"([{"instr_id": "1_7", "trajectory": []}])"),
      handed_in(kCvdn, "a dialogue that is not there", "$[0].inst_idx",
                R"([{"inst_idx": 13, )" + walk + "}]"),
      handed_in(kCvdn, "two results for one dialogue", "$[1].inst_idx",
                R"([{"inst_idx": 12, )" + walk + R"(}, {"inst_idx": 12, )" + walk + "}]"),
      handed_in(kJoined, "a step between viewpoints that are not adjacent", "$[0].trajectory[1]",
                R"([{"instr_id": "0_0", "trajectory": [["v0"], ["v2"]]}])"),
      handed_in(kSoon, "no path", "$[0].trajectory: has no field \"path\"",
                soon_with("\"path\"", "\"way\"")),
      handed_in(kSoon, "a direction that is a bare number", "$[0].trajectory.obj_heading",
                soon_with("[0.3]", "0.3")),
      handed_in(kSoon, "a direction of two numbers", "$[0].trajectory.obj_elevation",
                soon_with("[0.5]", "[0.5, 1]")),
      handed_in(kSoon, "a viewpoint that is not there", "$[0].trajectory.path[1]",
                soon_with("\"v1\"", "\"v9\"")),
  };
}

std::vector<Case> joins() {
  const auto refused = [](std::string input, std::string command, int code, std::string says,
                          std::function<void(Files&)> damage = {}) {
    return Case{"Paths to join", std::move(input), std::move(command), code,
                std::move(says), std::move(damage)};
  };
  return {
      refused("hidden goals", "r4r --data {} --split hidden -o {}/out.json", 2,
              "path 1: its goal is hidden; nothing can be joined to it"),
      refused("a path without its length", "r4r --data {} --split made -o {}/out.json", 2,
              "path 1: has no distance, which joined ones are sums of",
              [](Files& f) { f.edit(kAnnotations, "\"distance\":8.0,", ""); }),
      refused("five paths to one", "r4r --data {} --split made --paths 5 -o {}/out.json", 2,
              "--paths"),
  };
}

}  // namespace

std::vector<Case> task_cases() {
  std::vector<Case> all;
  for (const auto& group : {guides(), reverie(), boxes(), object_lines(), cvdn(), soon(), family(),
                            results(), joins()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace enfilade::bad_input
