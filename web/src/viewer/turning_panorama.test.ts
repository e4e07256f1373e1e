import { describe, expect, it } from 'vitest';
import { apply, degrees, type Mat3, transpose, type Vec3 } from '../geometry/geometry.ts';
import { Surround } from './surround.ts';
import { boxTransform, sweepOf, swing, turns } from './turning_panorama.ts';

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

  it.each([
    [0, 0, 0], [90, 0, 0], [200, -8, 130], [350, 20, 10], [10, -30, 350],
  ])('looks to heading %d, elevation %d, front at %d', (heading, elevation, front) => {
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

describe('the way to and fro', () => {
  /** A room of 10 x 10 m with the eye 1 m before its west wall, as /distances has it: north is +y. */
  const room = (): Surround => {
    const size = 32;
    const cells = new Uint16Array(6 * size * size);
    for (let face = 0; face < 6; ++face) {
      for (let k = 0; k < size * size; ++k) {
        const [u, v] = [((k % size) + 0.5) / size * 2 - 1, (Math.floor(k / size) + 0.5) / size * 2 - 1];
        const d = directions[face]!(u, v);
        const length = Math.hypot(...d);
        const [x, y, z] = d.map((part) => part / length) as [number, number, number]; // x east, y down, z north
        const metres = Math.min((x > 0 ? 9 : 1) / Math.abs(x), 5 / Math.abs(z), 1.2 / Math.abs(y));
        cells[face * size * size + k] = Math.round(metres * 4000);
      }
    }
    return Surround.parse(cells.buffer);
  };
  const at = (heading: number) => ({ heading: degrees(heading), elevation: 0, vfov: 1 });

  it('stays where the middle of the picture is open', () => {
    const rotation = panoramaAt(0);
    const [left, right] = sweepOf(room(), rotation, at(90)); // far away to both sides
    expect([left, right]).toEqual([-degrees(60), degrees(60)].map((x) => expect.closeTo(x, 6)));
    const [west, east] = sweepOf(room(), rotation, at(0)); // the wall is on the left
    expect(east).toBeCloseTo(degrees(60), 6);
    // 2 m away the wall is at 30 degrees; the mean of what is around is a little more.
    expect(west).toBeLessThan(-degrees(20));
    expect(west).toBeGreaterThan(-degrees(40));
    const beforeIt = sweepOf(room(), rotation, at(270));
    expect(beforeIt).toEqual([-degrees(10), degrees(10)].map((x) => expect.closeTo(x, 6)));
  });

  it.each([[-60, 60], [-10, 60], [-60, 10]])('begins straight ahead and goes from %d to %d degrees', (left, right) => {
    const { seconds, turn } = swing([degrees(left), degrees(right)]);
    expect(turn(0)).toBeCloseTo(0, 9);
    expect(turn(seconds)).toBeCloseTo(0, 9);
    const all = Array.from({ length: 1000 }, (_, k) => turn((seconds * k) / 1000));
    expect(Math.min(...all)).toBeCloseTo(degrees(left), 3);
    expect(Math.max(...all)).toBeCloseTo(degrees(right), 3);
    const fastest = Math.max(...all.slice(1).map((value, k) => Math.abs(value - all[k]!))) / (seconds / 1000);
    expect(fastest).toBeLessThan(degrees(5)); // a second
  });
});
