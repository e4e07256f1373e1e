// Enfilade's own scorer: the metrics of metrics.h, by the goal that there is.
#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks::scorers {

void own(const Scored& scored, Out out) {
  const EpisodeMetrics metrics =
      compute_metrics(scored.graph, scored.reference, scored.trajectory, scored.options);
  std::size_t k = 0;
  for (const MetricField& field : metric_fields()) out[k++] = metrics.*field.field;
}

}  // namespace enfilade::tasks::scorers
