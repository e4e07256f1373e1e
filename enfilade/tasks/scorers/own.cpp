// Enfilade's own scorer: the metrics of metrics.h.
#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks::scorers {

void own(const Scored& scored, Out out) {
  const EpisodeMetrics metrics = compute_metrics(scored.graph, viewpoints_of(scored.trajectory),
                                                 scored.reference.viewpoints, scored.options);
  std::size_t k = 0;
  for (const MetricField& field : metric_fields()) out[k++] = metrics.*field.field;
}

}  // namespace enfilade::tasks::scorers
