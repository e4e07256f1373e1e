import { describe, expect, it } from 'vitest';
import type { GlbMesh, Part } from './glb.ts';
import { inPieces } from './pieces.ts';

/** A triangle of 1 m with its middle near a place. */
const triangle = (x: number, y: number, more: Partial<Part> = {}): Part => ({
  name: 'building', material: 0, positions: new Float32Array([x, y, 0, x + 1, y, 0, x, y + 1, 0]), indices: new Uint32Array([0, 1, 2]), ...more,
});
const materials: GlbMesh['materials'] = [
  { colour: [0.5, 1, 0.25], cutoff: 0 }, { colour: [1, 1, 1], cutoff: 0 }, { colour: [1, 1, 1], cutoff: 0.5, picture: new Blob(['x']) }];

/** Each triangle as its corners' positions, light and texture points, whatever the order. */
const triangles = ({ parts }: GlbMesh): string[] => parts.flatMap(({ positions, indices, light, texturePoints }) =>
  Array.from({ length: indices.length / 3 }, (_, t) => [0, 1, 2].map((k) => {
    const corner = indices[3 * t + k]!;
    return [...positions.slice(3 * corner, 3 * corner + 3), ...(light?.slice(3 * corner, 3 * corner + 3) ?? []),
      ...(texturePoints?.slice(2 * corner, 2 * corner + 2) ?? [])].join(',');
  }).join(' '))).sort();

describe('a mesh in pieces', () => {
  it('has one material for all without a picture, and its colours in the light', () => {
    const { parts, materials: made } = inPieces({ materials, parts: [
      triangle(0, 0, { light: new Float32Array([1, 1, 1, 2, 2, 2, 4, 4, 4]) }), triangle(1, 0, { material: 1 })] });
    expect(parts.map(({ material }) => material)).toEqual([3]);
    expect(made[3]).toEqual({ colour: [1, 1, 1], cutoff: 0 });
    expect([...parts[0]!.light!]).toEqual([0.5, 1, 0.25, 1, 2, 0.5, 2, 4, 1, ...new Array<number>(9).fill(1)]);
    expect([...parts[0]!.indices]).toEqual([0, 1, 2, 3, 4, 5]);
  });

  it('is cut where rooms are, and loses no triangle', () => {
    const texturePoints = new Float32Array([0, 0, 1, 0, 0, 1]);
    const parts = [[0, 0], [1, 1], [9, 0], [9, -7], [-3, 0]].map(([x, y]) =>
      triangle(x!, y!, { material: 2, texturePoints, light: new Float32Array(9).fill(x!) }));
    const cut = inPieces({ materials, parts });
    expect(triangles(cut)).toEqual(triangles({ materials, parts }));
    for (const { positions } of cut.parts) {
      const xs = positions.filter((_, k) => k % 3 === 0);
      expect(Math.max(...xs) - Math.min(...xs)).toBeLessThan(6);
    }
    const one = inPieces({ materials, parts: [triangle(0, 0, { material: 2, texturePoints,
      positions: new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 20, 0, 0, 21, 0, 0, 20, 1, 0]), indices: new Uint32Array([0, 1, 2, 3, 4, 5]) })] });
    expect(one.parts.map(({ positions }) => positions.length)).toEqual([9, 9]); // each with its own corners alone
  });

  it('leaves what lies around as it is', () => {
    const around = triangle(0, 0, { name: 'surroundings', material: 2, positions: new Float32Array([0, 0, 0, 100, 0, 0, 0, 100, 0]) });
    expect(inPieces({ materials, parts: [around] }).parts).toEqual([{ ...around, solid: false }]);
    const both = inPieces({ materials, parts: [triangle(0, 0), triangle(0, 0, { name: 'surroundings' })] });
    expect(both.parts.map(({ name }) => name)).toEqual(['building', 'surroundings']);
  });

  it('tells surfaces around something from sheets', () => {
    /** A box without its bottom, as what stands on the floor has: each side with corners of its own. */
    const box = [[[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]], [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]],
      [[1, 1, 0], [0, 1, 0], [0, 1, 1], [1, 1, 1]], [[0, 1, 0], [0, 0, 0], [0, 0, 1], [0, 1, 1]], [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]];
    /** Cloth in folds, and a wall. */
    const folds = Array.from({ length: 8 }, (_, k) => {
      const [x0, x1, y0, y1] = [3 + 0.03 * k, 3.03 + 0.03 * k, k % 2 === 0 ? -0.02 : 0.02, k % 2 === 0 ? 0.02 : -0.02];
      return [[x1, y1, 0], [x0, y0, 0], [x0, y0, 2], [x1, y1, 2]];
    });
    const wall = [[[0, 3, 0], [3, 3, 0], [3, 3, 2.5], [0, 3, 2.5]]];
    const part = (quads: readonly (readonly (readonly number[])[])[]): Part => ({
      name: 'building', material: 2, positions: new Float32Array(quads.flat(2)),
      indices: Uint32Array.from(quads.flatMap((_, k) => [0, 1, 2, 0, 2, 3].map((c) => 4 * k + c))),
    });
    const { parts } = inPieces({ materials, parts: [part([...box, ...folds, ...wall])] }, true);
    const count = (solid: boolean) => parts.filter((one) => one.solid === solid).reduce((sum, { indices }) => sum + indices.length / 3, 0);
    expect([count(true), count(false)]).toEqual([2 * box.length, 2 * (folds.length + wall.length)]);
    expect(inPieces({ materials, parts: [part(box)] }).parts.map(({ solid }) => solid)).toEqual([false]);
  });
});
