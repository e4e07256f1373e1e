/** The floor that a body can walk on: convex polygons with heights, and how one slides along their rim. World frame, metres. */
import type { Vec3 } from '../geometry/geometry.ts';

/** What the server tells of a floor (components/schemas/Floor). */
export interface FloorData {
  readonly scan: string;
  readonly body: { readonly radius: number; readonly height: number; readonly step: number };
  readonly walker: { readonly eye: number; readonly forward: number; readonly turn: number; readonly look: number; readonly most_elevation: number };
  readonly polygons: readonly {
    readonly area: number;
    readonly beyond: readonly number[];
    readonly points: readonly number[];
    readonly triangles: readonly number[];
  }[];
}

/** A point of the floor, and the polygon that it lies on. */
export interface FloorPoint {
  readonly position: Vec3;
  readonly polygon: number;
}

/** How a walk along a straight line ended. */
export interface Walked {
  readonly end: FloorPoint;
  /** It did not come to where the line ends. */
  readonly atWall: boolean;
}

interface Polygon {
  readonly area: number;
  /** Of each side, from corner k to the next; -1: the rim. */
  readonly beyond: readonly number[];
  /** x and y in turn, counter-clockwise. */
  readonly corners: readonly number[];
  /** x, y, z in turn. */
  readonly points: readonly number[];
  readonly triangles: readonly number[];
}

/** Rounding: a wall that was touched within this distance is none (metres, as the simulator has it). */
const touch = 1e-5;
const inside = 1e-9;

/** The place along a to b, 0 to 1, that is nearest to a point. */
function nearestOn(ax: number, ay: number, bx: number, by: number, x: number, y: number): number {
  const [dx, dy] = [bx - ax, by - ay];
  const squared = dx * dx + dy * dy;
  return squared > 0 ? Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / squared, 0), 1) : 0;
}

export class Floor {
  readonly data: FloorData;
  private readonly polygons: readonly Polygon[];

  constructor(data: FloorData) {
    this.data = data;
    const turned = data.polygons.reduce((sum, { points, beyond }) => sum + twiceArea(points, beyond.length), 0) < 0;
    this.polygons = data.polygons.map(({ area, beyond, points, triangles }) => {
      const n = beyond.length;
      const order = Array.from({ length: n }, (_, k) => (turned ? n - 1 - k : k));
      return {
        area, points, triangles,
        corners: order.flatMap((k) => [points[3 * k]!, points[3 * k + 1]!]),
        // A side belongs to its first corner: turned, to the one that was its second.
        beyond: order.map((k) => beyond[turned ? (k + n - 1) % n : k]!),
      };
    });
  }

  get size(): number {
    return this.polygons.length;
  }

  /** The connected part that a polygon belongs to, the largest first: no walk leads from one to another. */
  part(polygon: number): number {
    return this.polygons[polygon]!.area;
  }

  /** Corners of a polygon, x and y in turn, counter-clockwise, and about how high it lies. */
  outline(polygon: number): { readonly corners: readonly number[]; readonly height: number } {
    const { corners, points } = this.polygons[polygon]!;
    const n = corners.length / 2;
    let sum = 0;
    for (let k = 0; k < n; ++k) sum += points[3 * k + 2]!;
    return { corners, height: sum / n };
  }

  /** Sides with nothing beyond them: x and y of both ends in turn, and the height of the first. */
  *rim(): Generator<readonly [number, number, number, number, number]> {
    for (const { corners, beyond, points } of this.polygons) {
      const n = beyond.length;
      for (let k = 0; k < n; ++k) {
        const next = (k + 1) % n;
        if (beyond[k]! < 0) yield [corners[2 * k]!, corners[2 * k + 1]!, corners[2 * next]!, corners[2 * next + 1]!, points[2]!];
      }
    }
  }

  /** The floor's point that is nearest; nothing: the floor is empty. */
  nearest([x, y, z]: Vec3): FloorPoint | undefined {
    let best: FloorPoint | undefined;
    let least = Infinity;
    this.polygons.forEach((_, polygon) => {
      const [px, py] = this.nearestIn(polygon, x, y);
      const aside = Math.hypot(px - x, py - y);
      if (aside >= least) return;
      const pz = this.height(polygon, px, py);
      const away = Math.hypot(aside, pz - z);
      if (away < least) [best, least] = [{ position: [px, py, pz], polygon }, away];
    });
    return best;
  }

  /** The floor's height at a point over a polygon, or at its rim. */
  height(polygon: number, x: number, y: number): number {
    const { points, triangles } = this.polygons[polygon]!;
    let [best, height] = [-Infinity, points[2]!];
    for (let k = 0; k + 2 < triangles.length; k += 3) {
      const [a, b, c] = [3 * triangles[k]!, 3 * triangles[k + 1]!, 3 * triangles[k + 2]!];
      const [ax, ay] = [points[a]!, points[a + 1]!];
      const [ux, uy, vx, vy] = [points[b]! - ax, points[b + 1]! - ay, points[c]! - ax, points[c + 1]! - ay];
      const det = ux * vy - uy * vx;
      if (det === 0) continue;
      const v = ((x - ax) * vy - (y - ay) * vx) / det;
      const w = (ux * (y - ay) - uy * (x - ax)) / det;
      const least = Math.min(v, w, 1 - v - w);
      if (least <= best) continue;
      best = least;
      // Outside of all triangles, which rounding can make of a point of the rim, the nearest one's edge counts.
      const weights = [1 - v - w, v, w].map((weight) => Math.max(weight, 0)) as [number, number, number];
      const sum = weights[0] + weights[1] + weights[2];
      height = (weights[0] * points[a + 2]! + weights[1] * points[b + 2]! + weights[2] * points[c + 2]!) / sum;
    }
    return height;
  }

  /**
   * Walks straight by (dx, dy), and slides along walls: it ends at the point nearest to the line's end that is reached over polygons near
   * the line. That is the rule of the simulator's steps (Detour's), so that the same actions end in the same places.
   */
  walk(from: FloorPoint, dx: number, dy: number): Walked {
    const [x0, y0] = from.position;
    const [x, y] = [x0 + dx, y0 + dy];
    const [mx, my, reach] = [x0 + dx / 2, y0 + dy / 2, Math.hypot(dx, dy) / 2 + 0.001];
    const seen = new Set([from.polygon]);
    const queue = [from.polygon];
    let end = { polygon: from.polygon, x: x0, y: y0 };
    let least = Infinity;
    for (let at = 0; at < queue.length; ++at) {
      const polygon = queue[at]!;
      const { corners, beyond } = this.polygons[polygon]!;
      if (this.contains(polygon, x, y)) {
        end = { polygon, x, y };
        break;
      }
      const n = beyond.length;
      for (let k = 0; k < n; ++k) {
        const [ax, ay] = [corners[2 * k]!, corners[2 * k + 1]!];
        const [bx, by] = [corners[2 * ((k + 1) % n)]!, corners[2 * ((k + 1) % n) + 1]!];
        const other = beyond[k]!;
        if (other < 0) {
          const t = nearestOn(ax, ay, bx, by, x, y);
          const [px, py] = [ax + t * (bx - ax), ay + t * (by - ay)];
          const away = (px - x) ** 2 + (py - y) ** 2;
          if (away < least) [least, end] = [away, { polygon, x: px, y: py }];
        } else if (!seen.has(other)) {
          const t = nearestOn(ax, ay, bx, by, mx, my);
          if (Math.hypot(ax + t * (bx - ax) - mx, ay + t * (by - ay) - my) > reach) continue;
          seen.add(other);
          queue.push(other);
        }
      }
    }
    return {
      end: { position: [end.x, end.y, this.height(end.polygon, end.x, end.y)], polygon: end.polygon },
      atWall: Math.hypot(end.x - x, end.y - y) > touch,
    };
  }

  /**
   * How far one comes straight ahead before a wall, without sliding along it.
   * @param dx, dy the direction, of length 1 @param most metres
   */
  ahead(from: FloorPoint, dx: number, dy: number, most: number): { readonly end: FloorPoint; readonly metres: number } {
    const [x0, y0] = from.position;
    let [polygon, metres] = [from.polygon, 0];
    for (let left = this.size; left > 0; --left) { // a straight line comes to each polygon once
      const { corners, beyond } = this.polygons[polygon]!;
      const n = beyond.length;
      let [out, side] = [Infinity, 0];
      for (let k = 0; k < n; ++k) {
        const [ax, ay] = [corners[2 * k]!, corners[2 * k + 1]!];
        const [nx, ny] = [corners[2 * ((k + 1) % n) + 1]! - ay, ax - corners[2 * ((k + 1) % n)]!]; // outwards
        const towards = nx * dx + ny * dy;
        if (towards <= 0) continue;
        const at = (nx * (ax - x0) + ny * (ay - y0)) / towards;
        if (at < out) [out, side] = [at, k];
      }
      metres = Math.min(Math.max(out, metres), most);
      const next = beyond[side]!;
      if (metres >= most || next < 0) break;
      polygon = next;
    }
    const [x, y] = [x0 + dx * metres, y0 + dy * metres];
    return { end: { position: [x, y, this.height(polygon, x, y)], polygon }, metres };
  }

  /**
   * The heading in which there is most floor ahead, as far as 7 m.
   * @param preferred of headings that are about as good the one nearest to it
   */
  openHeading(from: FloorPoint, preferred?: number): number {
    const [rays, far, window] = [72, 7, 8]; // 5 degrees, metres, 40 degrees to either side
    const turn = (2 * Math.PI) / rays;
    const open = Array.from({ length: rays }, (_, k) => this.ahead(from, Math.sin(k * turn), Math.cos(k * turn), far).metres / far);
    const score = (k: number): number => {
      let sum = preferred === undefined ? 0 : 0.1 * Math.cos(k * turn - preferred);
      for (let d = -window; d <= window; ++d) sum += (open[(k + d + rays) % rays]! * (window + 1 - Math.abs(d))) / (window + 1) ** 2;
      return sum + open[k]!; // what is in the middle counts most
    };
    return turn * open.reduce((best, _, k) => (score(k) > score(best) ? k : best), 0);
  }

  /** Where a ray first meets the floor below a height; nothing if it does not. */
  hit([ox, oy, oz]: Vec3, [dx, dy, dz]: Vec3, below: number): FloorPoint | undefined {
    let best: FloorPoint | undefined;
    let least = Infinity;
    this.polygons.forEach(({ points, corners }, polygon) => {
      // Floors are nearly level: a plane at the corners' mean height is near enough to point at.
      const { height } = this.outline(polygon);
      const t = (height - oz) / dz;
      if (!(t > 0) || t >= least || points.length === 0 || corners.length === 0 || height > below) return;
      const [x, y] = [ox + t * dx, oy + t * dy];
      if (this.contains(polygon, x, y)) [best, least] = [{ position: [x, y, this.height(polygon, x, y)], polygon }, t];
    });
    return best;
  }

  /** Whether a point lies over a polygon, its sides included. */
  contains(polygon: number, x: number, y: number): boolean {
    const { corners } = this.polygons[polygon]!;
    const n = corners.length / 2;
    for (let k = 0; k < n; ++k) {
      const [ax, ay] = [corners[2 * k]!, corners[2 * k + 1]!];
      const [bx, by] = [corners[2 * ((k + 1) % n)]!, corners[2 * ((k + 1) % n) + 1]!];
      if ((bx - ax) * (y - ay) - (by - ay) * (x - ax) < -inside) return false;
    }
    return true;
  }

  private nearestIn(polygon: number, x: number, y: number): [number, number] {
    if (this.contains(polygon, x, y)) return [x, y];
    const { corners } = this.polygons[polygon]!;
    const n = corners.length / 2;
    let best: [number, number] = [corners[0]!, corners[1]!];
    let least = Infinity;
    for (let k = 0; k < n; ++k) {
      const [ax, ay] = [corners[2 * k]!, corners[2 * k + 1]!];
      const [bx, by] = [corners[2 * ((k + 1) % n)]!, corners[2 * ((k + 1) % n) + 1]!];
      const t = nearestOn(ax, ay, bx, by, x, y);
      const [px, py] = [ax + t * (bx - ax), ay + t * (by - ay)];
      const away = Math.hypot(px - x, py - y);
      if (away < least) [best, least] = [[px, py], away];
    }
    return best;
  }
}

/** Of the first corners of a polygon; positive: counter-clockwise. */
function twiceArea(points: readonly number[], corners: number): number {
  let sum = 0;
  for (let k = 0; k < corners; ++k) {
    const next = (k + 1) % corners;
    sum += points[3 * k]! * points[3 * next + 1]! - points[3 * next]! * points[3 * k + 1]!;
  }
  return sum;
}
