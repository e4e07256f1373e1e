// enfilade features: what an encoder says of every view of every viewpoint.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/neural/compute_features.h"
#include "enfilade/neural/device.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::apps::features_verb {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRandomWeights = "random";

struct Options {
  std::string data, output, shard, weights;
  std::vector<std::string> images, scans, merge;
  std::string preprocessing = "caffe";
  bool float16 = false;
  neural::FeatureJob job;
};

std::shared_ptr<const scan::PanoramaSet> panoramas_of(const Options& o) {
  const dataset::DatasetConfig config{
      open_data(o.data).folder(), {}, {o.images.begin(), o.images.end()}, o.scans};
  return dataset::Dataset(config).panoramas();
}

void set_encoder(Options& o) {
  neural::EncoderConfig& encoder = o.job.encoder;
  encoder.preprocessing = o.preprocessing == "caffe" ? neural::Preprocessing::kCaffe
                                                     : neural::Preprocessing::kTorchvision;
  if (o.weights.empty()) {
    throw UsageError(encoder.name == "home"
                         ? "--weights: the file that `enfilade pretrain` wrote is expected"
                         : fmt::format("--weights: a file of {}'s weights is expected "
                                       "(PyTorch's .pth, or .safetensors), or the word {}, "
                                       "which makes useless features at the same speed",
                                       encoder.name, kRandomWeights));
  }
  if (encoder.logits && encoder.name != "vit-b-16") {
    throw UsageError(
        fmt::format("--logits: --encoder {} gives no class scores; vit-b-16 does", encoder.name));
  }
  if (o.weights != kRandomWeights) encoder.weights = o.weights;
}

void print_report(const neural::FeatureReport& report, const fs::path& file) {
  say("{}: {} viewpoints\n", file.string(), report.viewpoints);
  const auto pictures = static_cast<double>(36 * (report.viewpoints - report.resumed));
  const double seconds = report.rendering_seconds + report.encoding_seconds;
  if (report.resumed > 0) say("{} of them from a run that was stopped\n", report.resumed);
  if (pictures > 0) {
    say("{:.0f} views in {:.1f} s, {:.2f} a second; {:.1f} % of the time drew them\n", pictures,
        seconds, pictures / seconds, 100 * report.rendering_seconds / seconds);
  }
  if (!report.without.empty()) {
    constexpr std::size_t kShown = 5;
    const std::size_t shown = std::min(kShown, report.without.size());
    say(stderr, "{} scans have no pictures: {}{}\n", report.without.size(),
        fmt::join(report.without.begin(),
                  report.without.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
        shown < report.without.size() ? ", ..." : "");
  }
}

void run(Options o) {
  const auto type = o.float16 ? features::DType::kFloat16 : features::DType::kFloat32;
  if (!o.merge.empty()) {
    const std::vector<fs::path> from(o.merge.begin(), o.merge.end());
    features::convert_features(from, o.output, type);
    say("{}: {} viewpoints\n", o.output, features::FeatureSet::open(o.output).keys().size());
    return;
  }
  set_encoder(o);
  neural::set_threads(o.job.threads);
  o.job.type = type;
  o.job.shard = parse_shard(o.shard);
  (void)features::format_of(o.output);  // complains before an hour's work, not after
  const fs::path file = shard_file(o.output, o.job.shard);
  const auto report =
      neural::compute_features(panoramas_of(o), o.job, file, progress_bar("features"));
  print_report(report, file);
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("features", kFeaturesHelp);
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_value(verb, "-o,--output", options->output, "FILE",
            "File .safetensors (resumable), .tsv (R2R's form) or .h5 (HAMT's, DUET's)")
      ->required();
  add_setting(verb, "--encoder", options->job.encoder.name, "NAME",
              fmt::format("Encoder: {}", fmt::join(neural::encoder_names(), ", ")),
              CLI::IsMember(neural::encoder_names()));
  add_value(verb, "--weights", options->weights, "FILE",
            "Weights .safetensors or .pth (docs/features.md), or the word random");
  verb.add_flag("--logits", options->job.encoder.logits,
                "vit-b-16: append the scores of ImageNet's 1,000 classes, for pretraining");
  add_setting(verb, "--preprocessing", options->preprocessing, "NAME",
              "Preprocessing of ResNets: caffe (R2R's features) or torchvision (other weights)",
              CLI::IsMember({"caffe", "torchvision"}));
  add_value(verb, "--scan", options->scans, "SCAN", "Scans to encode (default: all of scans.txt)");
  add_value(verb, "--images", options->images, "DIR",
            "Folder of stores or scans (default: the data set's)");
  add_value(verb, "--shard", options->shard, "N/COUNT", "Compute shard N of COUNT, such as 3/16");
  add_whole_number(verb, "--batch", options->job.batch, "Pictures per batch");
  add_setting(verb, "--device", options->job.encoder.device, "NAME", "cpu, cuda or cuda:N");
  add_threads_option(verb, options->job.threads);
  verb.add_flag("--float16", options->float16, "Half the size; three digits per number");
  add_value(verb, "--merge", options->merge, "FILE...",
            "Merge these feature files into --output, or change a file's format");
  set_examples(
      verb,
      {("enfilade features --encoder home --weights home_encoder.safetensors -o "
        "features.safetensors"),
       ("enfilade features --weights resnet152-394f9c45.pth --preprocessing torchvision --float16 "
        "-o features.safetensors"),
       ("enfilade features --weights resnet152.safetensors --shard 3/16 --device cuda --batch 36 "
        "-o features.safetensors"),
       ("enfilade features --encoder vit-b-16 --weights vit_base_patch16_224.safetensors --logits "
        "-o pth_vit_base_patch16_224_imagenet.hdf5"),
       "enfilade features --merge features.*-of-16.safetensors -o features.safetensors",
       "enfilade features --merge ResNet-152-imagenet.tsv --float16 -o resnet152.safetensors"},
      "An interrupted run resumes.");
  verb.callback([options] { run(*options); });
}

}  // namespace enfilade::apps::features_verb
