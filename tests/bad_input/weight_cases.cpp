#include <fmt/format.h>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

struct Array {
  std::string name;
  std::vector<std::size_t> shape;
};

// A listener of EnvDrop with two hidden numbers, for features of one number a view and five words.
std::vector<Array> listener() {
  return {{"encoder.embedding.weight", {5, 1}},
          {"encoder.lstm.weight_ih_l0", {4, 1}},
          {"encoder.lstm.weight_hh_l0", {4, 1}},
          {"encoder.lstm.bias_ih_l0", {4}},
          {"encoder.lstm.bias_hh_l0", {4}},
          {"encoder.lstm.weight_ih_l0_reverse", {4, 1}},
          {"encoder.lstm.weight_hh_l0_reverse", {4, 1}},
          {"encoder.lstm.bias_ih_l0_reverse", {4}},
          {"encoder.lstm.bias_hh_l0_reverse", {4}},
          {"encoder.encoder2decoder.weight", {2, 2}},
          {"encoder.encoder2decoder.bias", {2}},
          {"decoder.embedding.0.weight", {1, 4}},
          {"decoder.embedding.0.bias", {1}},
          {"decoder.lstm.weight_ih", {8, 6}},
          {"decoder.lstm.weight_hh", {8, 2}},
          {"decoder.lstm.bias_ih", {8}},
          {"decoder.lstm.bias_hh", {8}},
          {"decoder.feat_att_layer.linear_in.weight", {5, 2}},
          {"decoder.feat_att_layer.linear_out.weight", {2, 7}},
          {"decoder.attention_layer.linear_in.weight", {2, 2}},
          {"decoder.attention_layer.linear_out.weight", {2, 4}},
          {"decoder.candidate_att_layer.linear_in.weight", {5, 2}},
          {"decoder.candidate_att_layer.linear_out.weight", {2, 7}},
          {"critic.state2value.0.weight", {2, 2}},
          {"critic.state2value.0.bias", {2}},
          {"critic.state2value.3.weight", {1, 2}},
          {"critic.state2value.3.bias", {1}}};
}

// Safetensors in which every number is `value`.
std::string file_of(const std::vector<Array>& arrays, float value = 0.5F) {
  std::string header = "{", data;
  for (const Array& array : arrays) {
    std::size_t elements = 1;
    std::string shape;
    for (const std::size_t side : array.shape) {
      elements *= side;
      shape += (shape.empty() ? "" : ",") + std::to_string(side);
    }
    header += fmt::format("{}\"{}\":{{\"dtype\":\"F32\",\"shape\":[{}],\"data_offsets\":[{},{}]}}",
                          header.size() > 1 ? "," : "", array.name, shape, data.size(),
                          data.size() + elements * sizeof(value));
    for (std::size_t i = 0; i < elements; ++i) {
      data.append(reinterpret_cast<const char*>(&value), sizeof(value));
    }
  }
  header += "}";
  const std::uint64_t length = header.size();
  std::string file(sizeof(length), '\0');
  std::memcpy(file.data(), &length, sizeof(length));
  return file + header + data;
}

constexpr const char* kVerb = "import-weights w.safetensors -o model --vocabulary words.txt";

Case weights(std::string input, std::string command, int exit_code, std::string says,
             const std::function<void(Files&)>& damage = {}) {
  Case made{"Weights that others released",
            std::move(input),
            std::move(command),
            exit_code,
            std::move(says),
            [damage](Files& files) {
              files.write("w.safetensors", file_of(listener()));
              files.write("words.txt", "<PAD>\n<UNK>\n<EOS>\ngo\n");
              if (damage) damage(files);
            }};
  made.learns = true;
  return made;
}

// The listener, changed.
template <class Change>
std::function<void(Files&)> changed(const Change& change) {
  return [=](Files& files) {
    std::vector<Array> arrays = listener();
    change(arrays);
    files.write("w.safetensors", file_of(arrays));
  };
}

std::vector<Case> arrays_that_do_not_fit() {
  return {
      weights("weights of a network that is not known", kVerb, 3,
              "the names of no agent that is known. Known are DUET's",
              [](Files& f) {
                f.write("w.safetensors", file_of({{"fc.weight", {2, 2}}}));
              }),
      weights("a pipe in the weights' place", kVerb, 3,
              "w.safetensors: cannot be read: not a plain",
              [](Files& f) { f.write("w.safetensors", kPipe); }),
      weights("an array that is missing", kVerb, 3,
              "decoder.lstm.bias_hh: not in the file; shape [8] is expected [missing-array]",
              changed([](std::vector<Array>& arrays) { arrays.erase(arrays.begin() + 16); })),
      weights("an array that the network has not", kVerb, 3,
              "decoder.gate.weight: shape [2, 2]; this network has no such array [surplus-array]",
              changed([](std::vector<Array>& arrays) {
                arrays.push_back({"decoder.gate.weight", {2, 2}});
              })),
      weights("an array of another shape", kVerb, 3,
              "decoder.lstm.weight_ih: shape [8, 7], [8, 6] is expected [wrong-shape]",
              changed([](std::vector<Array>& arrays) {
                arrays[13].shape = {8, 7};
              })),
      weights("a number that is none", kVerb, 3, "has infinities or NaN [not-finite]",
              [](Files& f) {
                f.write("w.safetensors",
                        file_of(listener(), std::numeric_limits<float>::infinity()));
              }),
      weights("another agent than was asked for", std::string(kVerb) + " --agent duet", 2,
              "weights of the agent panoramic, not of duet"),
  };
}

// Features of the viewpoints v0 to v{n - 1}.
std::string features_of(std::size_t n, std::size_t columns, float value = 0.5F) {
  std::vector<Array> arrays;
  for (std::size_t i = 0; i < n; ++i) {
    arrays.push_back({fmt::format("one_v{}", i), {36, columns}});
  }
  return file_of(arrays, value);
}

// The model that kVerb makes, with features of one number a view.
Case walks(std::string input, std::string command, int exit_code, std::string says,
           const std::function<void(Files&)>& damage = {}) {
  Case made = weights(std::move(input), std::move(command), exit_code, std::move(says),
                      [damage](Files& files) {
                        files.write("f.safetensors", features_of(5, 1));
                        if (damage) damage(files);
                      });
  made.group = "Models, and data that they do not fit";
  made.first = kVerb;
  return made;
}

constexpr const char* kWalk =
    "evaluate model --data {} --split made --features f.safetensors --threads 1";

// A seq2seq agent that learnt in one data set is to walk in another.
Case elsewhere(std::string input, std::string says, const std::function<void(Files&)>& damage) {
  Case made = walks(std::move(input), "evaluate model --data other --split made --threads 1", 0,
                    std::move(says), [damage](Files& files) {
                      for (const char* file : {kScans, kGraph, kAnnotations, kRegions}) {
                        files.write(fmt::format("other/{}", file), files.content(file));
                      }
                      damage(files);
                    });
  made.first =
      "train --data {} --splits made --validation made --inputs none --iterations 1 --batch 2 "
      "--hidden 2 --max-steps 2 -o model --threads 1";
  return made;
}

// A seq2seq agent's training is gone on with otherwise.
Case begun(std::string input, const std::string& options, std::string says) {
  const std::string train =
      "train --data {} --splits made --validation made --inputs none --iterations 1 --batch 2 "
      "--hidden 2 --max-steps 2 --threads 1 -o model ";
  Case made = walks(std::move(input), train + options, 2, std::move(says));
  made.first = train;
  return made;
}

std::vector<Case> models_elsewhere() {
  const std::string begin =
      "train --data {} --splits made --validation made --agent duet --inputs none -o new ";
  return {
      walks("a model and features that fit", kWalk, 0, "on made: 6 episodes"),
      walks("features that are not given", "evaluate model --data {} --split made", 2,
            "the agent sees, so it needs features (--features FILE)"),
      walks("features of another width", kWalk, 2,
            "features of 2 numbers a view; the network was made for 1",
            [](Files& f) { f.write("f.safetensors", features_of(5, 2)); }),
      walks("a map with viewpoints that have no features", kWalk, 3,
            "features: none for 1 viewpoints that agents may come to in split made: one_v4",
            [](Files& f) { f.write("f.safetensors", features_of(4, 1)); }),
      walks("features that are no numbers", kWalk, 3,
            "scan \"one\", viewpoint \"v0\": a number that is infinite or NaN [not-finite]",
            [](Files& f) {
              f.write("f.safetensors", features_of(5, 1, std::numeric_limits<float>::quiet_NaN()));
            }),
      walks("a split that the data set has not",
            "evaluate model --data {} --split val --features f.safetensors", 3,
            "holds no annotations of split \"val\""),
      walks("a stage that the agent has not",
            "train --data {} --agent panoramic --stage pretrain -o new", 2,
            "stage pretrain: the agent panoramic has no such stage, duet has"),
      walks("a choice of walks where nobody walks",
            "train --data {} --agent duet --stage pretrain --feedback teacher -o new", 2,
            "--feedback: not an option of --stage pretrain"),
      walks("a batch in no parts", begin + "--parts 0", 2, "--parts: "),
      walks("parts, and a part a process", begin + "--parts 8 --all-reduce", 2,
            "--parts excludes --all-reduce"),
      begun("a model that was begun in other parts", "--parts 2", "parts: none, not 2"),
      walks("a model to begin with that is another agent's", begin + "--from model", 2,
            "model: training cannot begin with the weights of this model"),
      walks("a model to begin with that is none", begin + "--from r2r", 3,
            "r2r: no config.json in it, so it is no model"),
      elsewhere(
          "a map that is not that of training", "[other-graph]",
          [](Files& f) { f.edit("other/connectivity/one_connectivity.json", "1.5", "1.25"); }),
      elsewhere("annotations that are not those of training", "[other-annotations]",
                [](Files& f) { f.edit("other/r2r/R2R_made.json", "Walk on.", "Walk."); }),
  };
}

}  // namespace

std::vector<Case> weight_cases() {
  std::vector<Case> cases{
      weights("weights that are good", kVerb, 0, "the listener of EnvDrop (Tan et al., 2019)"),
      weights("weights that are not there", "import-weights none.pt -o model", 3,
              "none.pt: cannot be read"),
      weights("a file that is no weights", kVerb, 3, "w.safetensors",
              [](Files& f) { f.write("w.safetensors", "epoch 8"); }),
      weights("weights in PyTorch's tar form of 2017", kVerb, 3,
              "torch.save(torch.load(file, weights_only=False), new_file) [old-torch]",
              [](Files& f) {
                std::string tar(1024, '\0');
                tar.replace(0, 8, "sys_info").replace(257, 6, "ustar ");
                f.write("w.safetensors", tar);
              }),
      weights("a file cut off in the middle", kVerb, 3, "w.safetensors",
              [](Files& f) {
                const std::string whole = file_of(listener());
                f.write("w.safetensors", whole.substr(0, whole.size() - 10));
              }),
      weights(
          "no vocabulary", "import-weights w.safetensors -o model", 2,
          "its table of words has 5 rows, but no words are in the file: give --vocabulary FILE"),
      weights("a vocabulary of another size", kVerb, 3,
              "words.txt: 5 words (and 1 of marks), but the table of words in w.safetensors has 5 "
              "rows",
              [](Files& f) { f.append("words.txt", "left\n"); }),
      weights("a vocabulary that is none", kVerb, 3, "words.txt",
              [](Files& f) { f.write("words.txt", "go\nleft\nright\nup\n"); }),
      weights("a model directory that is there already",
              "import-weights w.safetensors -o r2r --vocabulary words.txt", 3,
              "r2r: is there already and not an empty folder; name a new one"),
  };
  for (const auto& more : {arrays_that_do_not_fit(), models_elsewhere()}) {
    cases.insert(cases.end(), more.begin(), more.end());
  }
  return cases;
}

}  // namespace enfilade::bad_input
