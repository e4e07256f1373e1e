/**
 * Where an agent may go from where it looks: the simulator's rule, in its precision. Checked against
 * tests/vectors, which the C++ runs too.
 */
import type { Camera, Direction } from '../geometry/geometry.ts';
import type { Scan } from './scan.ts';

/** A step that can be taken; angles are measured from the middle of the view, radians. */
export interface Step {
  /** Index into Scan.viewpoints. */
  readonly viewpoint: number;
  /** To the right is positive. */
  readonly relHeading: number;
  readonly relElevation: number;
  /** Straight line, metres. */
  readonly distance: number;
}

const f = Math.fround;

/** Half of the horizontal opening, the linear rule of MatterSim: 40 degrees at 640 x 480 and 60. */
export const halfFieldOfView = (camera: Camera): number =>
  (camera.vfov * camera.width) / camera.height / 2;

/**
 * Steps from a viewpoint, nearest to the middle of the view first, ties by index.
 * @param limit only those within that angle of the heading are navigable; none: all
 */
export function navigable(
  scan: Scan,
  from: number,
  { heading, elevation }: Direction,
  limit?: number,
): Step[] {
  const here = scan.viewpoints[from]!;
  // MatterSim keeps positions, and what is computed of them, in single precision.
  const angle = Math.PI / 2 - heading;
  const [cx, cy] = [f(Math.cos(angle)), f(Math.sin(angle))];
  const found: (Step & { order: number })[] = [];
  for (const viewpoint of [...here.neighbours].sort((a, b) => a - b)) {
    const there = scan.viewpoints[viewpoint]!;
    const dx = f(f(there.position[0]) - f(here.position[0]));
    const dy = f(f(there.position[1]) - f(here.position[1]));
    const dz = f(f(there.position[2]) - f(here.position[2]));
    const squared = f(f(dx * dx) + f(dy * dy));
    const unit = f(1 / f(Math.sqrt(squared)));
    const cosine = f(f(f(dx * unit) * cx) + f(f(dy * unit) * cy));
    if (limit !== undefined && !(cosine >= Math.cos(limit))) continue;
    const right = f(f(dx * cy) - f(dy * cx));
    const ahead = f(f(dx * cx) + f(dy * cy));
    const relHeading = f(Math.atan2(right, ahead));
    const relElevation = Math.atan2(dz, Math.sqrt(squared)) - elevation;
    found.push({
      viewpoint,
      relHeading,
      relElevation,
      distance: f(Math.sqrt(f(squared + f(dz * dz)))),
      order: Math.hypot(relHeading, relElevation),
    });
  }
  return found
    .sort((a, b) => a.order - b.order || a.viewpoint - b.viewpoint)
    .map(({ order: _order, ...step }) => step);
}
