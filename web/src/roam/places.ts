/** A position as a part of an address, and the viewpoint near it. */
import type { Vec3 } from '../geometry/geometry.ts';
import type { Scan } from '../scan/scan.ts';

/** "@1.25,-3.4,0": in the place of a viewpoint's id in `#scan/viewpoint/heading/elevation`. */
export const formatPoint = (point: Vec3): string => `@${point.map((x) => Math.round(x * 100) / 100).join(',')}`;

/** Its inverse; nothing if it is none. */
export function parsePoint(text: string | undefined): Vec3 | undefined {
  const parts = /^@(-?\d+(?:\.\d+)?),(-?\d+(?:\.\d+)?),(-?\d+(?:\.\d+)?)$/.exec(text ?? '');
  return parts ? [Number(parts[1]), Number(parts[2]), Number(parts[3])] : undefined;
}

/** The floor under a viewpoint. */
export function footOf(scan: Scan, viewpoint: number): Vec3 {
  const { position: [x, y, z], height } = scan.viewpoints[viewpoint]!;
  return [x, y, z - height];
}

/** The factor of heights: what is above or below is not near. */
const upwards = 4;

/** The viewpoint with pictures that is nearest to a point on the floor; undefined without one. */
export function nearestViewpoint(scan: Scan, [x, y, z]: Vec3): number | undefined {
  let best: number | undefined;
  let least = Infinity;
  scan.viewpoints.forEach(({ rotation }, v) => {
    if (!rotation) return;
    const [vx, vy, vz] = footOf(scan, v);
    const away = Math.hypot(vx - x, vy - y, upwards * (vz - z));
    if (away < least) [best, least] = [v, away];
  });
  return best;
}
