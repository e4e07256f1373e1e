// enfilade import-weights: a model directory of weights that others released.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <string>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/neural/released_weights.h"

namespace enfilade::apps::import_weights_verb {
namespace {

struct Options {
  std::string file, output, agent, vocabulary, letters;
  std::string subout = "max";
  std::int64_t heads = 0;
  std::size_t max_words = 0, max_steps = 0;
};

constexpr double kMillion = 1e6;

std::string sizes_of(const models::TrainConfig& training) {
  if (training.agent == models::AgentKind::kPanoramic) {
    const models::PanoramicConfig& sizes = training.panoramic;
    return fmt::format("{} hidden numbers, words of {}, {}", sizes.hidden, sizes.word_embedding,
                       sizes.bidirectional ? "read in both directions" : "read in one direction");
  }
  const models::DuetConfig& sizes = training.duet;
  return fmt::format(
      "{} numbers a token, {} heads, {} layers of text, {} of the panorama, {} of "
      "map and of viewpoint",
      sizes.hidden, sizes.heads, sizes.text_layers, sizes.panorama_layers, sizes.cross_layers);
}

std::string text_of(const models::TrainConfig& training) {
  std::string text = fmt::format("{} {}", training.network.vocabulary, to_string(training.text));
  if (training.text == models::TextKind::kWordPieces) {
    text += fmt::format(", {}", to_string(training.letters));
  }
  return text + fmt::format("; at most {} of an instruction", training.network.max_words);
}

std::string objects_of(const models::TrainConfig& training) {
  if (training.agent != models::AgentKind::kDuet || training.duet.object == 0) return "no objects";
  return fmt::format("objects: features of {} numbers each", training.duet.object);
}

void print(const Options& options, const neural::ImportedWeights& found) {
  const models::TrainConfig& training = found.config.training;
  say("{}: {}\n", options.file, found.family);
  say("  {} arrays, {:.1f} M parameters: {}\n", found.arrays,
      static_cast<double>(found.parameters) / kMillion, sizes_of(training));
  say("  reads {}\n", text_of(training));
  say("  sees features of {} numbers a view; {}\n", training.network.features,
      objects_of(training));
  say("  decides at most {} times an episode\n", training.max_steps);
  if (found.iteration > 0) say("  trained for {} iterations\n", found.iteration);
  if (!found.left_out.empty()) say("  left out: {}\n", fmt::join(found.left_out, "; "));
  say("{}: config.json, weights.safetensors, {}\n", options.output,
      found.vocabulary.filename().string());
}

void run(const Options& options) {
  neural::ReleasedWeights weights;
  weights.file = options.file;
  weights.vocabulary = options.vocabulary;
  weights.heads = options.heads;
  weights.subout = models::parse_name<models::Subout>("subout", options.subout);
  if (!options.agent.empty())
    weights.agent = models::parse_name<models::AgentKind>("agent", options.agent);
  if (!options.letters.empty())
    weights.letters = models::parse_name<models::Letters>("letters", options.letters);
  if (options.max_words > 0) weights.max_words = options.max_words;
  if (options.max_steps > 0) weights.max_steps = options.max_steps;
  print(options, neural::import_weights(weights, options.output));
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("import-weights", kImportWeightsHelp);
  const auto options = std::make_shared<Options>();
  add_value(verb, "file", options->file, "FILE",
            "PyTorch checkpoint, .safetensors or .npz, with the published names")
      ->required();
  add_value(verb, "-o,--output", options->output, "MODELDIR", "The new model directory")
      ->required();
  add_value(verb, "--vocabulary", options->vocabulary, "FILE",
            "Words of the weights: BERT's vocab.txt, XLM-R's .model, or lines");
  add_value(verb, "--letters", options->letters, "NAME",
            "cased or uncased (default: as the published vocabulary of that size)");
  add_value(verb, "--agent", options->agent, "NAME",
            "duet or panoramic (default: what the arrays' names say)");
  add_value(verb, "--heads", options->heads, "N",
            "Attention heads of DUET (default: one per 64 columns)")
      ->check(whole_number(1, 1024));
  add_value(verb, "--max-words", options->max_words, "N",
            "Most words of an instruction (default: duet 200, panoramic 80)")
      ->check(whole_number(2, 100'000));
  add_value(verb, "--max-steps", options->max_steps, "N",
            "Most decisions per episode (default: duet 15, panoramic 35)")
      ->check(whole_number(1, 100'000));
  add_setting(verb, "--subout", options->subout, "NAME",
              "Start of the panoramic agent's decoder: max or tanh");
  set_examples(verb, {"enfilade import-weights best_val_unseen --vocabulary vocab.txt -o duet",
                      "enfilade import-weights snap/agent/state_dict/best_val_unseen --vocabulary "
                      "train_vocab.txt -o envdrop",
                      "enfilade evaluate duet --features pth_vit_base_patch16_224_imagenet.hdf5"});
  verb.callback([options] { run(*options); });
}

}  // namespace enfilade::apps::import_weights_verb
