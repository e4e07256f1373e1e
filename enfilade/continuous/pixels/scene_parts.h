/// \file  Parts of a Scene.
#pragma once
#include <memory>
#include <vector>

#include "enfilade/continuous/pixels/surfaces.h"
#include "enfilade/continuous/pixels/tree.h"
#include "enfilade/continuous/scene.h"

namespace enfilade::continuous::pixels {

struct SceneParts {
  SceneParts(std::shared_ptr<const mesh::RayTracer> with, ToneTable::Curve curve, float mirrors)
      : tracer(std::move(with)),
        least_mirror(mirrors),
        surfaces(tracer->mesh(), mirrors, values_of(curve)),
        tree(tracer->mesh()),
        tone(curve),
        linear(values_of(curve)) {}

  std::shared_ptr<const mesh::RayTracer> tracer;
  float least_mirror;
  Surfaces surfaces;  ///< light and emission are scaled: 0.18 is mid-grey in pictures
  Tree tree;
  ToneTable tone;
  LinearTable linear;
  bool lit = false;
  bool habitat = false;  ///< Style::kHabitat
  mesh::Sky sky;         ///< scaled likewise; of lit scenes
  float scale = 1;       ///< that factor

 private:
  static Values values_of(ToneTable::Curve curve) {
    return curve == ToneTable::Curve::kDisplay ? Values::kDisplay : Values::kLinear;
  }
};

/// Scales emission and sky. \pre parts.scale
void apply_scale(SceneParts& parts);

/// Computes the light of all surfaces. \pre parts.scale, options are in range
void bake_light(const mesh::LitMesh& light, const SceneOptions& options, const Progress& progress,
                SceneParts& parts);

}  // namespace enfilade::continuous::pixels
