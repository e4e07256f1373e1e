/** Shortest ways along a scan's edges, as the navigation error measures them. */
import { norm, subtract } from '../geometry/geometry.ts';
import type { Scan } from './scan.ts';

/** Metres from a viewpoint to every other one; infinite out of reach. O(n^2). */
export function distancesFrom(scan: Scan, from: number): number[] {
  const distances = scan.viewpoints.map((_, v) => (v === from ? 0 : Infinity));
  const open = new Set(distances.keys());
  while (open.size > 0) {
    let here = -1;
    for (const v of open) if (here < 0 || distances[v]! < distances[here]!) here = v;
    open.delete(here);
    const { position, neighbours } = scan.viewpoints[here]!;
    for (const next of neighbours) {
      const length = norm(subtract(scan.viewpoints[next]!.position, position));
      distances[next] = Math.min(distances[next]!, distances[here]! + length);
    }
  }
  return distances;
}

/** Of a walk, metres. */
export function lengthOf(scan: Scan, path: readonly number[]): number {
  const at = (v: number) => scan.viewpoints[v]!.position;
  return path.slice(1).reduce((sum, v, k) => sum + norm(subtract(at(v), at(path[k]!))), 0);
}
