// The parts of DUET's network on random inputs.
#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/torch_device.h"
#include "tests/conformance/agents_golden.h"
#include "tests/conformance/duet_episodes.h"

namespace enfilade::tests {
namespace {

using namespace neural::duet;
using nlohmann::json;

at::Tensor tensor_of(const features::NamedArray& array) {
  const auto type = array.type == features::DType::kFloat32 ? at::kFloat
                    : array.type == features::DType::kInt64 ? at::kLong
                                                            : at::kByte;
  at::Tensor values = at::empty(array.shape, type);
  std::ranges::copy(array.bytes, static_cast<std::byte*>(values.data_ptr()));
  return values;
}

// One case of the parts of the network.
class UnitCase {
 public:
  UnitCase(const features::TensorFile& arrays, const json& about)
      : arrays_(arrays), about_(about), name_(about["name"]) {}

  at::Tensor array(const std::string& which) const {
    const auto* found = arrays_.find(name_ + "/" + which);
    return found == nullptr ? at::Tensor() : tensor_of(*found);
  }

  PanoramaInput panorama() const {
    return {array("in.view_img_fts"), array("in.view_lens"), array("in.obj_img_fts"),
            array("in.obj_lens"),     array("in.loc_fts"),   array("in.nav_types")};
  }

  NavigationInput navigation() const {
    NavigationInput in;
    in.nodes = array("in.gmap_img_embeds");
    in.steps = array("in.gmap_step_ids");
    in.node_positions = array("in.gmap_pos_fts");
    in.node_mask = array("in.gmap_masks").gt(0);
    in.visited = array("in.gmap_visited_masks").gt(0);
    in.distances = array("in.gmap_pair_dists");
    in.tokens = array("in.vp_img_embeds");
    in.token_positions = array("in.vp_pos_fts");
    in.token_mask = array("in.vp_masks").gt(0);
    in.choices = array("in.vp_nav_masks").gt(0);
    if (array("in.vp_obj_masks").defined()) in.objects = array("in.vp_obj_masks").gt(0);
    in.node_of_token = at::full(in.choices.sizes(), -1, at::kLong);
    for (std::size_t i = 0; i < about_["gmap_vpids"].size(); ++i) {
      const json& nodes = about_["gmap_vpids"][i];
      const json& tokens = about_["vp_cand_vpids"][i];
      for (std::size_t j = 1; j < tokens.size(); ++j) {
        const auto found = std::find(nodes.begin(), nodes.end(), tokens[j]);
        if (found == nodes.end()) continue;
        in.node_of_token[static_cast<std::int64_t>(i)][static_cast<std::int64_t>(j)] =
            static_cast<std::int64_t>(found - nodes.begin());
      }
    }
    return in;
  }

  // Of rows without their padding.
  void check(const std::string& which, const at::Tensor& computed, const at::Tensor& mask,
             AgentsTally& tally) const {
    const at::Tensor recorded = array(which);
    if (!recorded.defined()) throw Error(name_ + ": the recording has no " + which);
    tally.near_all(name_ + "/" + which, numbers(recorded.index({mask})),
                   numbers(computed.index({mask})));
  }

 private:
  const features::TensorFile& arrays_;
  const json& about_;
  std::string name_;
};

DuetConfig case_config(const json& about, const features::TensorFile& weights) {
  DuetConfig config = infer_config(weights, 4);
  const json& options = about["options"];
  for (std::size_t i = 0; i < options.size(); ++i) {
    if (options[i] == "avg") config.fusion = Fusion::kAverage;
    if (options[i] == "NO_SPRELS") config.map_distances = false;
    if (options[i] == "--obj_feat_size")
      config.object = std::stoll(options[i + 1].get<std::string>());
  }
  return config;
}

// A network that leaves out, or adds, what a case says.
DuetNetwork network_of(const json& about, const features::TensorFile& weights,
                       const features::TensorFile& arrays, c10::Device device) {
  const DuetConfig config = case_config(about, weights);
  DuetNetwork network(config, 1, device);
  const c10::NoGradGuard no_gradients;
  for (const auto& [name, values] : network.weights()) {
    const auto* found = weights.find(name);
    if (found == nullptr) {
      found = arrays.find(about["name"].get<std::string>() + "/weights." + name);
    }
    if (found == nullptr) throw Error("the recorded weights have no " + name);
    at::Tensor(values).copy_(tensor_of(*found));
  }
  return network;
}

}  // namespace

void check_duet_units(const AgentsFolder& folder, AgentsTally& tally) {
  tally.begin("duet_units.npz");
  const json about = folder.json("duet_units.json");
  const features::TensorFile arrays = folder.tensors("duet_units.npz");
  const c10::NoGradGuard no_gradients;
  for (const json& one : about["cases"]) {
    const features::TensorFile weights = folder.tensors(one["weights"].get<std::string>());
    const DuetNetwork network =
        network_of(one, weights, arrays, neural::core::open_agents_device(folder.device()));
    const UnitCase unit(arrays, one);
    const auto check = [&](const char* which, const at::Tensor& ours, const at::Tensor& mask) {
      unit.check(which, ours.to(at::kCPU), mask, tally);
    };
    const at::Tensor words = unit.array("in.txt_masks").gt(0);
    check("out.txt_embeds", network.encode_text(unit.array("in.txt_ids"), words.sum(1)).values,
          words);
    check("out.pano_embeds", network.encode_panorama(unit.panorama()).values,
          unit.array("out.pano_masks").gt(0));
    const NavigationInput in = unit.navigation();
    const NavigationOutput out = network.navigate({unit.array("out.txt_embeds"), words}, in);
    check("out.gmap_embeds", out.nodes, in.node_mask);
    check("out.vp_embeds", out.tokens, in.token_mask);
    check("out.global_logits", out.global_logits, in.node_mask);
    check("out.local_logits", out.local_logits, in.token_mask);
    check("out.fused_logits", out.fused_logits, in.node_mask);
    if (in.objects.defined()) check("out.obj_logits", out.object_logits, in.token_mask);
  }
}

}  // namespace enfilade::tests
