#include "enfilade/neural/released_weights.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/models/subwords.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/duet/duet_network.h"
#include "enfilade/neural/panoramic/panoramic_network.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural {
namespace {

namespace fs = std::filesystem;
using features::bare_name;
using features::NamedArray;
using features::TensorFile;
using models::AgentKind;
using models::Letters;
using models::TextKind;

// A released vocabulary, by the rows of a network's table of words.
struct KnownVocabulary {
  std::size_t rows;
  std::string_view where;  // "that of bert-base-uncased: ...", or what is wanted in general
  Letters letters;
};
// Sizes of the published vocabularies; EnvDrop appends <BOS> to the 991 words of R2R's training.
constexpr std::array<KnownVocabulary, 4> kKnown{{
    {30'522, "that of bert-base-uncased: vocab.txt in https://huggingface.co/bert-base-uncased",
     Letters::kFolded},
    {28'996, "that of bert-base-cased: vocab.txt in https://huggingface.co/bert-base-cased",
     Letters::kAsWritten},
    {250'002,
     "that of xlm-roberta-base: sentencepiece.bpe.model in "
     "https://huggingface.co/xlm-roberta-base",
     Letters::kAsWritten},
    {992, "EnvDrop's 991 words, one a line: tasks/R2R/data/train_vocab.txt of its code",
     Letters::kFolded},
}};

KnownVocabulary known_vocabulary(std::size_t rows) {
  const auto* const found = std::ranges::find(kKnown, rows, &KnownVocabulary::rows);
  if (found != kKnown.end()) return *found;
  return {rows,
          "the one that the weights were trained with: vocab.txt of BERT's form, "
          "sentencepiece.bpe.model of XLM-R's, or a word a line",
          Letters::kFolded};
}

// SentencePiece's by the name `.model`, word pieces by the line "[CLS]", else words.
TextKind text_kind_of(const std::filesystem::path& file, std::string_view content) {
  if (file.extension() == ".model") return TextKind::kSentencePieces;
  for (const std::string_view mark : {"\n[CLS]\n", "\n[CLS]\r\n"}) {
    if (content.find(mark) != std::string_view::npos) return TextKind::kWordPieces;
  }
  return content.starts_with("[CLS]\n") ? TextKind::kWordPieces : TextKind::kWords;
}

// The words or pieces in a vocabulary of the training's kind of text. \throws InvalidInput
std::size_t entries_in(const std::filesystem::path& file, const std::string& content,
                       const models::TrainConfig& training) {
  switch (training.text) {
    case TextKind::kWordPieces:
      return models::Subwords::parse_word_pieces(content, file.string(), training.letters).size();
    case TextKind::kSentencePieces:
      return models::Subwords::parse_sentence_pieces(content, file.string()).size();
    case TextKind::kWords:
      break;
  }
  return tasks::Vocabulary::load(file).size();
}

// Rows of `<BOS>` and `<MASK>` beside those of words; none beside pieces.
std::size_t rows_of_marks(const models::TrainConfig& training) {
  models::TrainConfig none = training;
  none.network.vocabulary = 0;
  return training.agent == models::AgentKind::kDuet
             ? static_cast<std::size_t>(duet_sizes(none).vocabulary)
             : panoramic_sizes(none).vocabulary;
}

constexpr std::string_view kDuetWords = "vln_bert.embeddings.word_embeddings.weight";
constexpr std::string_view kDuetMap = "vln_bert.global_encoder.gmap_step_embeddings.weight";
constexpr std::string_view kPretrainedWords = "bert.embeddings.word_embeddings.weight";
constexpr std::string_view kPretrainedMap = "bert.global_encoder.gmap_step_embeddings.weight";
constexpr std::string_view kListener = "decoder.candidate_att_layer.linear_in.weight";

bool has(const TensorFile& file, std::string_view name) {
  return std::ranges::any_of(
      file.arrays(), [&](const NamedArray& array) { return bare_name(array.name) == name; });
}

bool is_pretrained_duet(const TensorFile& file) {
  return has(file, kPretrainedWords) && has(file, kPretrainedMap);
}

AgentKind recognised(const TensorFile& file) {
  if ((has(file, kDuetWords) && has(file, kDuetMap)) || is_pretrained_duet(file)) {
    return AgentKind::kDuet;
  }
  if (has(file, kListener)) return AgentKind::kPanoramic;
  constexpr std::size_t kNamed = 3;
  std::vector<std::string> first;
  for (const NamedArray& array : file.arrays()) {
    if (first.size() < kNamed) first.push_back(fmt::format("{:?}", array.name));
  }
  refuse(file.path().string(), "", "unknown-family",
         fmt::format("{} arrays, {}{}: the names of no agent that is known. Known are DUET's "
                     "(\"{}\", \"{}\"; of pretraining \"{}\") and EnvDrop's listener (\"{}\")",
                     file.arrays().size(), fmt::join(first, ", "),
                     file.arrays().size() > kNamed ? ", ..." : "", kDuetWords, kDuetMap,
                     kPretrainedMap, kListener));
}

// --- what does not fit ---

// Reports the first few faults of each kind, and their number; a network of another family has
// hundreds.
[[noreturn]] void refuse_briefly(const InvalidInput& all, const fs::path& file,
                                 std::string_view family) {
  constexpr std::size_t kNamed = 4;
  std::map<std::string, std::size_t> counts;
  std::vector<Diagnostic> kept;
  for (const Diagnostic& fault : all.diagnostics()) {
    if (++counts[fault.code] <= kNamed) kept.push_back(fault);
  }
  std::vector<std::string> sums;
  for (const auto& [code, n] : counts) sums.push_back(fmt::format("{} {}", n, code));
  if (all.diagnostics().size() > kept.size()) {
    kept.insert(
        kept.begin(),
        Diagnostic{
            Severity::kError, file.string(), "", "other-network",
            fmt::format("not the network of {}, though some names are: {}; the first of each",
                        family, fmt::join(sums, ", "))});
  }
  throw InvalidInput(std::move(kept));
}

template <class Read>
auto briefly(const fs::path& file, std::string_view family, const Read& read) {
  try {
    return read();
  } catch (const InvalidInput& faults) {
    refuse_briefly(faults, file, family);
  }
}

// --- names ---

// Checkpoints of DUET's pretraining name the network "bert" and have the heads beside it; their
// cross layers read in the other direction too, for masked words alone.
std::string name_after_pretraining(std::string_view given) {
  std::string name = bare_name(given);
  constexpr std::string_view kNetwork = "bert.";
  for (const std::string_view part : {".lang_self_att.", ".lang_inter.", ".lang_output."}) {
    if (name.find(part) != std::string::npos) return name;
  }
  if (name.starts_with(kNetwork)) return "vln_" + name;
  for (const std::string_view head :
       {"global_sap_head.", "local_sap_head.", "sap_fuse_linear.", "og_head."}) {
    if (name.starts_with(head)) return "vln_bert." + name;
  }
  return name;  // of tasks that the agent has not
}

// What the file has beside the agent's arrays.
std::vector<std::string> left_out(const TensorFile& file, AgentKind agent) {
  std::vector<std::string> found;
  for (const auto& [name, value] : file.metadata()) {
    if (value.empty()) found.push_back(name);
  }
  for (const auto& [name, reason] : file.left_out()) {
    found.push_back(fmt::format("{}: {}", name, reason));
  }
  if (agent != AgentKind::kDuet) return found;
  std::map<std::string, std::size_t> parts;
  for (const NamedArray& array : file.arrays()) {
    const std::string name = bare_name(array.name);
    if (name.starts_with("vln_bert.") || name_after_pretraining(name) != name) continue;
    ++parts[name.substr(0, name.find('.'))];
  }
  for (const auto& [part, n] : parts) found.push_back(fmt::format("{}: {} arrays", part, n));
  return found;
}

// The published code counts an epoch from 1 and subtracts 1 when it goes on.
std::uint64_t iteration_of(const TensorFile& file) {
  for (const char* name : {"vln_bert.epoch", "encoder.epoch", "epoch"}) {
    const auto found = file.metadata().find(name);
    if (found == file.metadata().end()) continue;
    const auto number = parse_number<std::uint64_t>(found->second);
    if (number && *number > 0) return *number - 1;
  }
  return 0;
}

// --- into a directory ---

class Import {
 public:
  Import(const ReleasedWeights& weights, const fs::path& folder)
      : options_(weights), files_{folder} {}

  ImportedWeights run() {
    const TensorFile file = TensorFile::open(options_.file);
    const AgentKind agent = recognised(file);
    if (options_.agent && *options_.agent != agent) {
      throw ArgumentError(fmt::format("{}: weights of the agent {}, not of {}",
                                      options_.file.string(), to_string(agent),
                                      to_string(*options_.agent)));
    }
    imported_.config.training = models::recipe(agent);
    imported_.iteration = iteration_of(file);
    imported_.left_out = left_out(file, agent);
    if (options_.max_words) training().network.max_words = *options_.max_words;
    if (options_.max_steps) training().max_steps = *options_.max_steps;
    prepare_folder(file);
    try {
      agent == AgentKind::kDuet ? read_duet(file) : read_listener(file);
      write_file(files_, files_.config(), to_json(imported_.config));
    } catch (...) {
      clean();
      throw;
    }
    return std::move(imported_);
  }

 private:
  models::TrainConfig& training() { return imported_.config.training; }

  void prepare_folder(const TensorFile& file) {
    std::error_code error;
    was_there_ = fs::exists(files_.folder, error);
    if (was_there_ &&
        !(fs::is_directory(files_.folder, error) && fs::is_empty(files_.folder, error))) {
      throw FileError(fmt::format("{}: is there already and not an empty folder; name a new one",
                                  files_.folder.string()));
    }
    make_folder(files_.folder);
    std::uintmax_t needed = 0;
    for (const NamedArray& array : file.arrays()) needed += array.elements() * sizeof(float);
    const fs::space_info room = fs::space(files_.folder, error);
    if (!error && room.available < needed) {
      clean();
      throw FileError(fmt::format("{}: {} MB free, the weights take {}", files_.folder.string(),
                                  room.available >> 20, (needed >> 20) + 1));
    }
  }

  void clean() {
    std::error_code ignored;
    for (const fs::path& file :
         {files_.config(), files_.weights(), files_.vocabulary(),
          files_.text(TextKind::kWordPieces), files_.text(TextKind::kSentencePieces)}) {
      fs::remove(file, ignored);
    }
    if (!was_there_) fs::remove(files_.folder, ignored);
  }

  void read_duet(const TensorFile& released) {
    imported_.family = "DUET (Chen et al., 2022)";
    const bool pretrained = is_pretrained_duet(released);
    if (pretrained) imported_.family += ", from its pretraining";
    const TensorFile file = pretrained ? released.renamed(name_after_pretraining) : released;
    const auto network = briefly(options_.file, imported_.family, [&] {
      return duet::DuetNetwork(duet::infer_config(file, options_.heads), file);
    });
    const models::DuetConfig& sizes = network.config();
    training().duet = sizes;
    training().network.features = static_cast<std::size_t>(sizes.image);
    check_words(sizes.positions);
    take_vocabulary(static_cast<std::size_t>(sizes.vocabulary));
    write(network.weights());
  }

  void check_words(std::int64_t positions) {
    const auto most = static_cast<std::size_t>(positions);
    if (options_.max_words && *options_.max_words > most) {
      throw ArgumentError(
          fmt::format("words: {}, but the network has places for {}", *options_.max_words, most));
    }
    training().network.max_words = std::min(training().network.max_words, most);
  }

  void read_listener(const TensorFile& file) {
    imported_.family = "the listener of EnvDrop (Tan et al., 2019)";
    models::PanoramicConfig defaults = training().panoramic;
    defaults.subout = options_.subout;
    const auto network = briefly(options_.file, imported_.family, [&] {
      return panoramic::PanoramicNetwork(panoramic::config_of(file, defaults), file);
    });
    const models::PanoramicConfig& sizes = network.config();
    training().panoramic = sizes;
    training().network.features = sizes.image;
    training().network.inputs.vision = sizes.image > 0;
    take_vocabulary(sizes.vocabulary);
    write(network.weights());
  }

  void take_vocabulary(std::size_t rows) {
    const KnownVocabulary known = known_vocabulary(rows);
    if (options_.vocabulary.empty()) {
      throw ArgumentError(
          fmt::format("{}: its table of words has {} rows, but no words are in the "
                      "file: give --vocabulary FILE, {}",
                      options_.file.string(), rows, known.where));
    }
    const bool pieces = options_.vocabulary.extension() == ".model";  // no text
    const std::string content =
        pieces ? read_file(options_.vocabulary) : read_plain_text(options_.vocabulary);
    training().text = text_kind_of(options_.vocabulary, content);
    training().letters = options_.letters.value_or(known.letters);
    const std::size_t entries = entries_in(options_.vocabulary, content, training());
    const std::size_t marks = rows_of_marks(training());
    if (entries + marks != rows) {
      refuse(options_.vocabulary.string(), "", "wrong-size",
             fmt::format("{} {}, but the table of words in {} has {} rows: {}", entries,
                         training().text == TextKind::kWords
                             ? fmt::format("words (and {} of marks)", marks)
                             : std::string("pieces"),
                         options_.file.string(), rows, known.where));
    }
    training().network.vocabulary = entries;
    imported_.vocabulary = files_.text(training().text);
    write_file(files_, imported_.vocabulary, content);
  }

  void write(const core::Weights& weights) {
    const std::vector<NamedArray> arrays = core::as_arrays(weights);
    imported_.arrays = arrays.size();
    for (const NamedArray& array : arrays) imported_.parameters += array.elements();
    models::write_state(files_.weights(), arrays, imported_.iteration);
  }

  const ReleasedWeights& options_;
  models::ModelFiles files_;
  bool was_there_ = false;
  ImportedWeights imported_;
};

}  // namespace

ImportedWeights import_weights(const ReleasedWeights& weights, const fs::path& folder) {
  return Import(weights, folder).run();
}

}  // namespace enfilade::neural
