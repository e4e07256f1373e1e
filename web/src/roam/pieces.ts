/** Puts a mesh together so that it is drawn fast: few materials, and pieces that are left out where they are out of view or turned away. */
import type { GlbMesh, Part } from './glb.ts';

/** Metres: a room has a few pieces, and from within most of a building is behind one or to the side. */
const edge = 4;
/** Cells to either side of the origin that have keys of their own. */
const most = 1 << 12;

/** A surface whose sides add up to less than this share of its area goes around something: of a closed one they add up to nothing. */
const mostOpen = 0.3;

/** A part that may be a surface around something, whose inside is never in view. */
export interface Piece extends Part {
  readonly solid: boolean;
}

const isAround = ({ name }: Part): boolean => name === 'surroundings';

/** Colours become a part of the light: then parts without a picture can have one material. */
function coloured({ positions, light }: Part, [r, g, b]: readonly [number, number, number]): Float32Array {
  const out = new Float32Array(positions.length);
  for (let k = 0; k < out.length; k += 3) {
    out[k] = r * (light?.[k] ?? 1);
    out[k + 1] = g * (light?.[k + 1] ?? 1);
    out[k + 2] = b * (light?.[k + 2] ?? 1);
  }
  return out;
}

function joined(parts: readonly Part[], mesh: GlbMesh, material: number): Part {
  const size = (array: 'positions' | 'indices') => parts.reduce((sum, part) => sum + part[array].length, 0);
  const [positions, light, indices] = [new Float32Array(size('positions')), new Float32Array(size('positions')), new Uint32Array(size('indices'))];
  let [corner, index] = [0, 0];
  for (const part of parts) {
    positions.set(part.positions, corner);
    light.set(coloured(part, mesh.materials[part.material]!.colour), corner);
    part.indices.forEach((value, k) => (indices[index + k] = value + corner / 3));
    corner += part.positions.length;
    index += part.indices.length;
  }
  return { name: parts[0]!.name, material, positions, indices, light };
}

/** Whether each triangle belongs to a surface around something: a table's leg does, a curtain does not. */
function solids({ positions, indices }: Part): readonly boolean[] {
  const corners = new Map<string, number>();
  const corner = Uint32Array.from(indices, (k) => { // corners at one place are one
    const key = `${positions[3 * k]} ${positions[3 * k + 1]} ${positions[3 * k + 2]}`;
    const known = corners.get(key) ?? corners.size;
    corners.set(key, known);
    return known;
  });
  const above = Uint32Array.from({ length: corners.size }, (_, k) => k);
  const surface = (k: number): number => {
    let at = k;
    while (above[at] !== at) at = above[at] = above[above[at]!]!;
    return at;
  };
  for (let t = 0; t < corner.length; t += 3) {
    above[surface(corner[t]!)] = surface(corner[t + 1]!);
    above[surface(corner[t + 1]!)] = surface(corner[t + 2]!);
  }
  /** For each surface the sum of its triangles' areas as vectors, and as numbers. */
  const sums = new Map<number, [number, number, number, number]>();
  for (let t = 0; t < indices.length; t += 3) {
    const [a, b, c] = [3 * indices[t]!, 3 * indices[t + 1]!, 3 * indices[t + 2]!];
    const u = [0, 1, 2].map((axis) => positions[b + axis]! - positions[a + axis]!) as [number, number, number];
    const v = [0, 1, 2].map((axis) => positions[c + axis]! - positions[a + axis]!) as [number, number, number];
    const [x, y, z] = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const key = surface(corner[t]!);
    const sum = sums.get(key) ?? [0, 0, 0, 0];
    sums.set(key, [sum[0] + x, sum[1] + y, sum[2] + z, sum[3] + Math.hypot(x, y, z)]);
  }
  return Array.from({ length: indices.length / 3 }, (_, t) => {
    const [x, y, z, all] = sums.get(surface(corner[3 * t]!))!;
    return Math.hypot(x, y, z) < mostOpen * all;
  });
}

/** Triangles whose middles lie in one cell: the corners of each in turn. */
interface Cell {
  readonly corners: readonly number[];
  readonly solid: boolean;
}

/** The triangles of a part, for each cell that has any. @param solid of each triangle */
function* cells({ positions, indices }: Part, solid: readonly boolean[]): Generator<Cell> {
  for (const kind of [false, true]) {
    const found = new Map<number, number[]>();
    for (let t = 0; t < indices.length; t += 3) {
      if ((solid[t / 3] ?? false) !== kind) continue;
      let key = 0;
      for (let axis = 0; axis < 3; ++axis) {
        const middle = (positions[3 * indices[t]! + axis]! + positions[3 * indices[t + 1]! + axis]! + positions[3 * indices[t + 2]! + axis]!) / 3;
        key = key * 2 * most + Math.min(Math.max(Math.floor(middle / edge), -most), most - 1) + most;
      }
      const cell = found.get(key);
      if (cell) cell.push(indices[t]!, indices[t + 1]!, indices[t + 2]!);
      else found.set(key, [indices[t]!, indices[t + 1]!, indices[t + 2]!]);
    }
    for (const corners of found.values()) yield { corners, solid: kind };
  }
}

/** A part with those corners only that it needs. @param corners three a triangle, of the whole part */
function taken(part: Part, corners: readonly number[]): Part {
  const places = new Map<number, number>();
  const indices = Uint32Array.from(corners, (corner) => {
    const place = places.get(corner) ?? places.size;
    places.set(corner, place);
    return place;
  });
  const pick = (values: Float32Array, width: number): Float32Array => {
    const out = new Float32Array(width * places.size);
    for (const [corner, place] of places) for (let k = 0; k < width; ++k) out[width * place + k] = values[width * corner + k]!;
    return out;
  };
  return {
    name: part.name, material: part.material, positions: pick(part.positions, 3), indices,
    ...(part.texturePoints && { texturePoints: pick(part.texturePoints, 2) }),
    ...(part.light && { light: pick(part.light, 3) }),
  };
}

/**
 * The same picture: all without a texture has the last material, and what is inside is cut into cells of 4 m.
 * @param findSolids whether surfaces around something are found; their triangles are counter-clockwise from outside
 */
export function inPieces(mesh: GlbMesh, findSolids = false): { readonly parts: readonly Piece[]; readonly materials: GlbMesh['materials'] } {
  const isPlain = ({ material }: Part) => mesh.materials[material]!.picture === undefined;
  const plain = mesh.parts.filter(isPlain);
  const groups = [plain.filter((part) => !isAround(part)), plain.filter(isAround)].filter((group) => group.length > 0);
  const parts = [...mesh.parts.filter((part) => !isPlain(part)), ...groups.map((group) => joined(group, mesh, mesh.materials.length))];
  return {
    materials: [...mesh.materials, { colour: [1, 1, 1], cutoff: 0 }],
    parts: parts.flatMap((part) => (isAround(part) ? [{ ...part, solid: false }]
      : [...cells(part, findSolids ? solids(part) : [])].map(({ corners, solid }) => ({ ...taken(part, corners), solid })))),
  };
}
