import { describe, expect, it } from 'vitest';
import { degrees, worldFromCamera, wrapDifference } from '../geometry/geometry.ts';
import { pointOfCube, reachOf, Surround } from './surround.ts';

/** Faces 0 up, 1 back, 2 left, 3 front, 4 right, 5 down of n x n readings, metres. */
function bytes(n: number, metres: (face: number, row: number, column: number) => number): ArrayBuffer {
  const view = new DataView(new ArrayBuffer(6 * n * n * 2));
  for (let face = 0; face < 6; ++face) {
    for (let k = 0; k < n * n; ++k) {
      view.setUint16((face * n * n + k) * 2, Math.round(metres(face, Math.floor(k / n), k % n) * 4000), true);
    }
  }
  return view.buffer;
}

/** Of headings: it looks in steps of 5 degrees. */
const apart = (a: number, b: number) => Math.abs(wrapDifference(a - b));
const step = degrees(5.1);

describe('what surrounds a viewpoint', () => {
  it('is looked up by direction: x right, y down, z forward', () => {
    const around = Surround.parse(bytes(4, (face) => face + 1));
    expect(around.at([0, -1, 0])).toBe(1);
    expect(around.at([0, 0, -1])).toBe(2);
    expect(around.at([-1, 0, 0])).toBe(3);
    expect(around.at([0, 0, 1])).toBe(4);
    expect(around.at([1, 0, 0])).toBe(5);
    expect(around.at([0, 1, 0])).toBe(6);
  });

  it('has its rows from the top and its columns from the left, on the four walls', () => {
    const around = Surround.parse(bytes(2, (_, row, column) => 1 + 2 * row + column));
    // The front face: right is +x, down is +y.
    expect(around.at([-0.5, -0.5, 1])).toBe(1);
    expect(around.at([0.5, -0.5, 1])).toBe(2);
    expect(around.at([-0.5, 0.5, 1])).toBe(3);
    expect(around.at([0.5, 0.5, 1])).toBe(4);
    // The right one: its right side is behind us.
    expect(around.at([1, -0.5, 0.5])).toBe(1);
    expect(around.at([1, -0.5, -0.5])).toBe(2);
  });

  it('has its points where it is looked up, on its faces and beyond their sides', () => {
    const around = Surround.parse(bytes(8, (face, row, column) => 1 + face + row / 10 + column / 100));
    const seen = (face: number, s: number, t: number) => {
      const [x, y, z] = pointOfCube(face, s, t);
      return around.at([-x, -y, -z]);
    };
    for (let face = 0; face < 6; ++face) {
      around.faces[face]!.forEach((metres, k) => {
        expect(seen(face, ((k % 8) + 0.5) / 4 - 1, (Math.floor(k / 8) + 0.5) / 4 - 1)).toBe(metres);
      });
    }
    expect(around.faces[0]).not.toContain(seen(0, 1.1, 0));
  });

  it('has bounds of a part, which filters do not leave', () => {
    const far = 9; // one reading, in the last column of one face
    const around = Surround.parse(bytes(8, (face, row, column) => (face === 3 && row === 2 && column === 7 ? far : 2)));
    const face = around.faces.findIndex((one) => one.includes(far));
    const at = around.faces[face]!.indexOf(far);
    const [s, t] = [((at % 8) + 0.5) / 4 - 1, (Math.floor(at / 8) + 0.5) / 4 - 1];
    expect(around.range(face, [s - 0.1, s + 0.1], [t - 0.1, t + 0.1])).toEqual([2, far]);
    expect(around.range(face, [-s - 0.1, -s + 0.1], [t - 0.1, t + 0.1])).toEqual([2, 2]);
    // It is beside an edge of the cube: a part of the face on the other side has it too.
    const parts = around.faces.map((_, k) => [-1, -0.5, 0, 0.5].flatMap((s0) => [-1, -0.5, 0, 0.5].map((t0) =>
      around.range(k, [s0, s0 + 0.5], [t0, t0 + 0.5])[1])).filter((most) => most === far).length);
    expect(parts.filter((count) => count > 0).length).toBe(2);
  });

  it('fills what is unknown from around it', () => {
    const around = Surround.parse(bytes(8, (face, row, column) => (face === 3 && row < 5 && column < 5 ? 0 : 2 + face)));
    expect(Math.min(...around.faces.flatMap((face) => [...face]))).toBeGreaterThan(0);
    expect(around.at([-0.9, -0.9, 1])).toBe(5); // of its own face
    const nothing = Surround.parse(bytes(2, () => 0));
    expect(nothing.at([0, 0, 1])).toBe(3);
  });

  it('refuses what is no six squares', () => {
    expect(() => Surround.parse(new ArrayBuffer(100))).toThrow('100 bytes');
  });

  it('is looked at where it is open, rather than at a wall', () => {
    // The panorama's front is the world's north here; only the right of it, the east, is far away.
    const worldFromPanorama = worldFromCamera({ heading: 0, elevation: 0 });
    const around = Surround.parse(bytes(16, (face) => (face === 4 ? 6 : 1)));
    expect(apart(around.openHeading(worldFromPanorama, []), Math.PI / 2)).toBeLessThan(step);
    // Turned by a quarter, it is the south.
    const turned = worldFromCamera({ heading: Math.PI / 2, elevation: 0 });
    expect(apart(around.openHeading(turned, []), Math.PI)).toBeLessThan(step);
    // Of two alike the one where one can go on.
    const both = Surround.parse(bytes(16, (face) => (face === 4 || face === 2 ? 6 : 1)));
    expect(apart(both.openHeading(worldFromPanorama, [1.5 * Math.PI]), 1.5 * Math.PI)).toBeLessThan(step);
    // Not out of the window in the west, where no viewpoint follows.
    const reach = (heading: number) => reachOf([0, 0, 0], [[0, 0, 0], [4, 0, 0]], heading);
    expect(apart(both.openHeading(worldFromPanorama, [], reach), Math.PI / 2)).toBeLessThan(step);
  });

  it('has a distance ahead, which a single post or gap does not change', () => {
    const worldFromPanorama = worldFromCamera({ heading: 0, elevation: 0 });
    // To the north 3 m, but for one column of readings, 1 degree wide; a little down, too.
    const around = Surround.parse(bytes(90, (face, _, column) => (face === 3 ? (column === 45 ? 0.4 : 3) : 1)));
    expect(around.ahead(worldFromPanorama, 0)).toBe(3);
    expect(around.ahead(worldFromPanorama, Math.PI / 2)).toBe(1);
    expect(around.ahead(worldFromCamera({ heading: Math.PI / 2, elevation: 0 }), Math.PI / 2)).toBe(3);
  });

  it('is not looked at where a pillar is in the middle of what is open', () => {
    const worldFromPanorama = worldFromCamera({ heading: 0, elevation: 0 });
    // All of the north is far away, but 30 degrees in its middle; nothing else is.
    const around = Surround.parse(bytes(90, (face, _, column) => (face === 3 ? (Math.abs(column - 44.5) < 12 ? 0.6 : 6) : 1)));
    const heading = around.openHeading(worldFromPanorama, []);
    expect(around.ahead(worldFromPanorama, heading)).toBe(6);
    expect(apart(heading, 0)).toBeGreaterThan(degrees(14));
  });

  it('ends a little beyond the outermost viewpoints', () => {
    const viewpoints = [[0, 0, 0], [4, 0, 0], [0, -3, 0]] as const;
    expect(reachOf([0, 0, 0], viewpoints, Math.PI / 2)).toBeCloseTo(5.5);
    expect(reachOf([0, 0, 0], viewpoints, 0)).toBeCloseTo(1.5);
    expect(reachOf([0, 0, 0], viewpoints, Math.PI)).toBeCloseTo(4.5);
    expect(reachOf([0, 0, 0], viewpoints, Math.PI / 4)).toBeCloseTo(1.5 * Math.SQRT2);
  });
});
