import { describe, expect, it } from 'vitest';
import { apply, degrees, type Mat3, transpose, type Vec3 } from '../geometry/geometry.ts';
import { boxTransform, turns } from './turning_panorama.ts';

/** Where CSS takes a point by a list of turns: the last comes first, as css-transforms-2 defines them. */
function inCss(transform: string, point: Vec3): Vec3 {
  const list = [...transform.matchAll(/rotate([XYZ])\((-?[\d.]+)(rad|deg)\)/g)].reverse();
  return list.reduce<Vec3>(([x, y, z], [, axis, value, unit]) => {
    const angle = unit === 'deg' ? degrees(Number(value)) : Number(value);
    const [s, c] = [Math.sin(angle), Math.cos(angle)];
    if (axis === 'X') return [x, c * y - s * z, s * y + c * z];
    if (axis === 'Y') return [c * x + s * z, y, -s * x + c * z];
    return [c * x - s * y, s * x + c * y, z];
  }, point);
}

/** The panorama's direction (x right, y down, z forward) of a place on a face, columns and rows from -1 to 1: MatterSim's assignment. */
const directions: readonly ((u: number, v: number) => Vec3)[] = [
  (u, v) => [-u, -1, -v], (u, v) => [-u, v, -1], (u, v) => [-1, v, u], (u, v) => [u, v, 1], (u, v) => [1, v, -u], (u, v) => [-u, 1, v],
];

/** Panoramas stand upright: x right, y down, z forward, turned about the vertical. */
const panoramaAt = (front: number): Mat3 => [
  Math.cos(front), 0, Math.sin(front),
  -Math.sin(front), 0, Math.cos(front),
  0, -1, 0,
];

describe('the turning panorama', () => {
  it.each([0, 1, 2, 3, 4, 5])('has face %i where it belongs', (face) => {
    for (const [u, v] of [[0, 0], [1, 0], [0, 1], [-0.5, 0.25]] as const) {
      const [x, y, z] = directions[face]!(u, v);
      const seen = inCss(turns[face]!, [u, v, -1]);
      [x, y, -z].forEach((value, k) => expect(seen[k]).toBeCloseTo(value, 6));
    }
  });

  it.each([[0, 0, 0], [90, 0, 0], [200, -8, 130], [350, 20, 10], [10, -30, 350]])('looks to heading %d, elevation %d, front at %d', (heading, elevation, front) => {
    const [h, e] = [degrees(heading), degrees(elevation)];
    const rotation = panoramaAt(degrees(front));
    const world: Vec3 = [Math.sin(h) * Math.cos(e), Math.cos(h) * Math.cos(e), Math.sin(e)];
    const [x, y, z] = apply(transpose(rotation), world);
    const transform = boxTransform(500, { heading: h, elevation: e, vfov: 1 }, Math.atan2(rotation[2], rotation[5]));
    const seen = inCss(transform, [x, y, -z]); // CSS has z towards us
    expect(seen[0]).toBeCloseTo(0, 4);
    expect(seen[1]).toBeCloseTo(0, 4);
    expect(seen[2]).toBeCloseTo(-1, 4);
  });
});
