/** Objects of tasks in the building that is shown. */
import type { Outline, Target } from '../collecting/collections.ts';
import { type Scan, viewpointIndex } from '../scan/scan.ts';

/** The largest outline of an object at each viewpoint that sees it. */
export function outlinesIn(scan: Scan, { outlines }: Target): Map<number, Outline> {
  const found = new Map<number, Outline>();
  for (const [id, list] of Object.entries(outlines)) {
    const viewpoint = viewpointIndex(scan, id);
    if (viewpoint >= 0 && list[0]) found.set(viewpoint, list[0]);
  }
  return found;
}
