/** A trajectory of a submission, and which of the server's pictures shows what its agent saw. */
import { directionTo, type Mat3, wrapDifference } from '../geometry/geometry.ts';
import { type Scan, viewpointIndex } from '../scan/scan.ts';

/** [viewpoint id, heading, elevation], radians. */
export type Entry = readonly [string, number, number];

/** The numbers of the server's faces around the horizon, from the front clockwise: front, right, back, left. */
const aroundHorizon = [3, 4, 1, 2] as const;

/** The face whose middle is nearest to a heading. */
export function faceTowards(worldFromPanorama: Mat3, heading: number): number {
  const front = Math.atan2(worldFromPanorama[2], worldFromPanorama[5]);
  const quarter = Math.round(wrapDifference(heading - front) / (Math.PI / 2));
  return aroundHorizon[(quarter + 4) % 4]!;
}

/** Where a path of viewpoint ids arrives, an index, and how one looks then. */
export function arrival(scan: Scan, path: readonly string[]): { at: number; heading: number } | undefined {
  const at = viewpointIndex(scan, path.at(-1));
  if (at < 0) return undefined;
  const from = scan.viewpoints[viewpointIndex(scan, path.at(-2))];
  return { at, heading: from ? directionTo(from.position, scan.viewpoints[at]!.position).heading : 0 };
}
