// A language model walks: `enfilade ask`.
#include <string>
#include <utility>

#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

Case ask(std::string input, const std::string& options, int exit_code, std::string says,
         std::function<void(Files&)> damage = {}) {
  Case made{
      "Language models", std::move(input), "ask --data {} --split made -o {}/asked " + options,
      exit_code,         std::move(says),  std::move(damage)};
  made.asks = true;
  return made;
}

Case prompt(std::string input, std::string text, std::string says) {
  return ask(std::move(input), "--stand-in oracle --prompt {}/p.txt", 3, std::move(says),
             [text = std::move(text)](Files& files) { files.write("p.txt", text); });
}

Case subset(std::string input, std::string text, std::string says) {
  return ask(std::move(input), "--stand-in oracle --subset {}/ids.txt", 3, std::move(says),
             [text = std::move(text)](Files& files) { files.write("ids.txt", text); });
}

Case serve(std::string input, const std::string& runs) {
  Case made{"Language models",
            std::move(input),
            "serve {} --port 0 --runs " + runs,
            3,
            runs + ": not a folder; --runs names one that holds runs",
            {}};
  made.asks = true;
  return made;
}

}  // namespace

std::vector<Case> arena_cases() {
  return {
      serve("runs that are not there", "{}/none"),
      serve("runs that are a file", "{}/results.json"),
      ask("nobody to ask", "", 2, "one of --endpoint URL"),
      ask("a model and a stand-in", "--endpoint http://127.0.0.1:9/v1 --model m --stand-in oracle",
          2, "one of --endpoint URL"),
      ask("a captioner without captions", "--stand-in oracle --captioner http://127.0.0.1:9/v1", 2,
          "need --words captions"),
      ask("a model without a name", "--endpoint http://127.0.0.1:9/v1", 2,
          "--model NAME is needed"),
      ask("a rule that is none", "--stand-in clever", 2,
          "no rule \"clever\"; there are first, random, oracle, stop"),
      ask("a prompt that is none", "--stand-in oracle --prompt poem", 2,
          "no prompt \"poem\"; there are text, marks, navgpt, mapgpt"),
      ask("a form of answers that is none", "--stand-in oracle --answers songs", 2,
          "--answers songs: one of tools, json, text is expected"),
      ask("an address with a key in it", "--endpoint http://me:secret@127.0.0.1/v1 --model m", 2,
          "an address without user, password, key and blanks is expected"),
      ask("an address with a key in its query",
          "--endpoint 'http://127.0.0.1/v1?api_key=x' --model m", 2,
          "an address without user, password, key and blanks is expected"),
      ask("an address of another kind", "--endpoint 127.0.0.1:8000 --model m", 2,
          "not http://... or https://..."),
      ask("an address without http:// and with a password",
          "--endpoint me:secret@127.0.0.1/v1 --model m", 2,
          "endpoint: \"127.0.0.1/v1\", not http://... or https://..."),
      ask("a temperature in words", "--stand-in oracle --temperature warm", 2, "--temperature"),
      ask("a seed below 0", "--stand-in oracle --seed -1", 2, "--seed: \"-1\" is not"),
      ask("a field for limits that is none", "--stand-in oracle --limit-field tokens", 2,
          "--limit-field"),
      ask("further fields that are no object", "--stand-in oracle --extra '[1]'", 2,
          "extra: no JSON object"),
      ask("further fields with the model", "--stand-in oracle --extra '{\"model\": 1}'", 2,
          "extra: model is not for it"),
      ask("a window of less than no step", "--stand-in oracle --window -1", 2, "--window"),
      ask("headers without a colon",
          "--endpoint http://127.0.0.1:9/v1 --model m --headers {}/h.txt", 3,
          "{}/h.txt: line 2: not \"Name: value\"",
          [](Files& files) { files.write("h.txt", "# ours\napi-key secret\n"); }),
      ask("headers whose names have blanks",
          "--endpoint http://127.0.0.1:9/v1 --model m --headers {}/h.txt", 3,
          "{}/h.txt: line 1: not \"Name: value\"",
          [](Files& files) { files.write("h.txt", "Bearer secret: x\n"); }),
      ask("pictures that are not there", "--stand-in oracle --prompt marks", 2, "panorama"),
      ask("answers that are not in the cache", "--replay --model m", 1, "is not in the cache"),
      ask("more episodes than there are", "--stand-in oracle --subset 5000", 2, "split made has"),
      subset("an id that the split does not have",
             "\xef\xbb\xbf"
             "1_0\r\n77_0\r\n",
             "{}/ids.txt: line 2: \"77_0\" is no episode of the split"),
      subset("an id twice", "1_0\n1_0\n", "line 2: \"1_0\" is there twice"),
      subset("no id", "# none\n", "no id in it"),
      prompt("an unknown word in the head", "model: m\n---\n---\n",
             "{}/p.txt: line 1: \"model\", not pictures, answers, memory or kept_pictures"),
      prompt("a value that is none", "pictures: film\n---\n---\n",
             "line 1: \"film\", not one of none, strip, places"),
      prompt("a template of one text", "---\nGo.\n", "the texts of the start and of a step"),
      prompt("a tag that is none", "---\nGo.\n---\n{{places.name}}\n",
             "{}/p.txt: line 4: \"places.name\", not one of"),
      prompt("a tag for another file", "---\nGo.\n---\n{{> /etc/passwd}}\n",
             "{}/p.txt: line 4: \"> /etc/passwd\": partials"),
      ask("prices that are none", "--stand-in oracle --prices {}/prices.json", 3, "$: not",
          [](Files& files) { files.write("prices.json", "[[[["); }),
      ask("a wait without an end", "--stand-in oracle --longest-wait inf", 2, "--longest-wait"),
      ask("no attempt", "--stand-in oracle --attempts 0", 2, "--attempts"),
      prompt("a tag that is not closed", "---\nGo.\n---\n{{#places}} A\n", "line 4"),
      ask("another run's folder", "--stand-in oracle", 3, "$.model: \"other\"",
          [](Files& files) {
            files.write(
                "asked/run.json",
                R"({"format": "enfilade-ask", "version": 1, "task": "r2r", "split": "made",)"
                R"( "model": "other"})");
            files.write("asked/transcripts/1_0.jsonl", "");
          }),
  };
}

}  // namespace enfilade::bad_input
