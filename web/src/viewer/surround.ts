/** How far it is from a viewpoint in every direction. */
import { apply, type Mat3, transpose, type Vec3, worldFromCamera, wrapDifference } from '../geometry/geometry.ts';

/**
 * With g = -(direction in the panorama frame), these faces are OpenGL's +X -X +Y -Y +Z -Z as they
 * are: no picture has to be turned. It is MatterSim's assignment.
 */
export const cubeOrder = [2, 4, 0, 5, 1, 3] as const;

const unitsPerMetre = 4000;
/** Radians: of rays around the middle of a view, to the side and up. People look a little down (arrival.ts). */
const aside = 0.09;
const heights = [-0.25, -0.1, 0.05] as const;
/** Metres, where nothing at all is known: a room. */
const usual = 3;

/** Readings of a face, halved until no hole is left: what is unknown takes the mean around it. */
function fill(face: Float32Array, n: number, otherwise: number): void {
  if (!face.includes(0)) return;
  if (n === 1) {
    face[0] = otherwise;
    return;
  }
  const half = Math.ceil(n / 2);
  const coarse = new Float32Array(half * half);
  for (let y = 0; y < half; ++y) {
    for (let x = 0; x < half; ++x) {
      let [sum, known] = [0, 0];
      for (const [row, column] of [[2 * y, 2 * x], [2 * y, 2 * x + 1], [2 * y + 1, 2 * x], [2 * y + 1, 2 * x + 1]] as const) {
        const value = row < n && column < n ? face[row * n + column]! : 0;
        sum += value;
        known += value > 0 ? 1 : 0;
      }
      coarse[y * half + x] = known > 0 ? sum / known : 0;
    }
  }
  fill(coarse, half, otherwise);
  for (let k = 0; k < face.length; ++k) {
    if (face[k] === 0) face[k] = coarse[(Math.floor(k / n) >> 1) * half + ((k % n) >> 1)]!;
  }
}

/** From the outermost viewpoints to where a building ends, in metres; the server's pictures of buildings have the same. */
const beyondViewpoints = 1.5;

/** Metres from a position along a heading to the end of the box around all viewpoints. */
export function reachOf(from: Vec3, viewpoints: readonly Vec3[], heading: number): number {
  const ahead = [Math.sin(heading), Math.cos(heading)] as const;
  return Math.min(...([0, 1] as const).filter((axis) => Math.abs(ahead[axis]) > 1e-9).map((axis) => {
    const room = Math.max(0, ...viewpoints.map((at) => (at[axis] - from[axis]) * Math.sign(ahead[axis])));
    return (room + beyondViewpoints) / Math.abs(ahead[axis]);
  }));
}

/** A point of a face, in OpenGL's table of cube maps: s to the right and t down, -1 to 1, and beyond on the faces beside it. */
export function pointOfCube(face: number, s: number, t: number): Vec3 {
  return ([[1, -t, -s], [-1, -t, s], [s, 1, t], [s, -1, -t], [s, -t, 1], [-s, -t, -1]] as const)[face]!;
}

export class Surround {
  /** Points of a face's edge. */
  readonly size: number;
  /** Metres, n x n a face, in cubeOrder; nothing is unknown. */
  readonly faces: readonly Float32Array[];

  constructor(size: number, faces: readonly Float32Array[]) {
    this.size = size;
    this.faces = faces;
  }

  /** What /distances answers. Throws Error if it is of another length. */
  static parse(bytes: ArrayBuffer): Surround {
    const size = Math.sqrt(bytes.byteLength / 12);
    if (!Number.isInteger(size) || size === 0) throw new Error(`${bytes.byteLength} bytes are not six square faces`);
    const view = new DataView(bytes);
    const count = size * size;
    const faces = cubeOrder.map((face) => {
      const metres = new Float32Array(count);
      for (let k = 0; k < count; ++k) metres[k] = view.getUint16((face * count + k) * 2, true) / unitsPerMetre;
      return metres;
    });
    const known = faces.flatMap((face) => [...face.filter((d) => d > 0)]);
    const mean = known.length > 0 ? known.reduce((a, b) => a + b, 0) / known.length : usual;
    for (const face of faces) fill(face, size, mean);
    return new Surround(size, faces);
  }

  /** Metres along a direction of the panorama frame, of any length. */
  at(direction: Vec3): number {
    const [x, y, z] = [-direction[0], -direction[1], -direction[2]];
    const [ax, ay, az] = [Math.abs(x), Math.abs(y), Math.abs(z)];
    // OpenGL's table of cube maps: face, and the two coordinates in it.
    const [face, s, t, most] =
      ax >= ay && ax >= az ? (x > 0 ? [0, -z, -y, ax] : [1, z, -y, ax])
      : ay >= az ? (y > 0 ? [2, x, z, ay] : [3, x, -z, ay])
      : z > 0 ? [4, x, -y, az] : [5, -x, -y, az];
    const cell = (k: number) => Math.min(Math.floor(((k / most + 1) / 2) * this.size), this.size - 1);
    return this.faces[face]![cell(t) * this.size + cell(s)]!;
  }

  /**
   * The least and the greatest distance that linear filters find in a part of a face.
   * @param s0, s1, t0, t1 its sides, as pointOfCube() has them
   */
  range(face: number, [s0, s1]: readonly [number, number], [t0, t1]: readonly [number, number]): readonly [number, number] {
    const n = this.size;
    // With the readings around it, which may lie on other faces.
    const [first, last] = [(at: number) => Math.floor(((at + 1) / 2) * n) - 1, (at: number) => Math.ceil(((at + 1) / 2) * n)];
    const middle = (k: number) => ((k + 0.5) / n) * 2 - 1;
    let [least, most] = [Infinity, 0];
    for (let row = first(t0); row <= last(t1); ++row) {
      for (let column = first(s0); column <= last(s1); ++column) {
        const inside = row >= 0 && row < n && column >= 0 && column < n;
        const [x, y, z] = inside ? [0, 0, 0] : pointOfCube(face, middle(column), middle(row));
        const metres = inside ? this.faces[face]![row * n + column]! : this.at([-x, -y, -z]);
        least = Math.min(least, metres);
        most = Math.max(most, metres);
      }
    }
    return [least, most];
  }

  /** Metres along a heading, level and a little down: of nine rays within 5 degrees the middle one. */
  ahead(worldFromPanorama: Mat3, heading: number): number {
    const panoramaFromWorld = transpose(worldFromPanorama);
    const metres = [-aside, 0, aside].flatMap((turn) => heights.map((elevation) =>
      this.along(panoramaFromWorld, heading + turn, elevation)));
    return metres.sort((a, b) => a - b)[4]!;
  }

  private along(panoramaFromWorld: Mat3, heading: number, elevation: number): number {
    const m = worldFromCamera({ heading, elevation });
    return this.at(apply(panoramaFromWorld, [m[2], m[5], m[8]]));
  }

  /**
   * The heading in which there is most to see: far away, and a way to go.
   * @param steps headings of where one can go
   * @param reach metres along a heading to where the building ends: what is seen through windows doesn't count
   */
  openHeading(worldFromPanorama: Mat3, steps: readonly number[], reach: (heading: number) => number = () => Infinity): number {
    const panoramaFromWorld = transpose(worldFromPanorama);
    const rays = 72; // 5 degrees: half of a door 5 m away
    const turn = (2 * Math.PI) / rays;
    const far = 7; // farther away it makes no difference
    const near = 2; // nearer there is nothing to see
    const open = Array.from({ length: rays }, (_, k) => {
      const most = Math.min(far, reach(k * turn));
      const seen = heights.map((elevation) => Math.min(this.along(panoramaFromWorld, k * turn, elevation), most));
      return seen.reduce((a, b) => a + b, 0) / seen.length / far;
    });
    const window = 9; // 45 degrees to either side: what is in view
    let [best, most] = [0, -1];
    for (let k = 0; k < rays; ++k) {
      let score = 0;
      // What is in the middle counts most, so that one looks into the middle of what is open.
      for (let d = -window; d <= window; ++d) {
        score += (open[(k + d + rays) % rays]! * (window + 1 - Math.abs(d))) / (window + 1) ** 2;
      }
      const nearest = Math.min(...steps.map((step) => Math.abs(wrapDifference(step - k * turn))), Math.PI);
      score += nearest < window * turn ? 0.4 * (1 - nearest / (window * turn)) : 0;
      // A pillar or a door leaf in the middle spoils the view, however open it is beside it.
      score -= Math.max(0, 1 - this.ahead(worldFromPanorama, k * turn) / near);
      if (score > most) [best, most] = [k, score];
    }
    return best * turn;
  }
}
