/** The walls and things of a building as shapes to build: from its plan, without drawing anything. */
import type { Lines, PlanStorey, Room } from '../scan/scan.ts';

/** A part of a wall as seen from the room: from `a` to `b` in plan, between two heights above the floor. */
interface WallPart {
  readonly a: readonly [number, number];
  readonly b: readonly [number, number];
  readonly low: number;
  readonly high: number;
  readonly glass: boolean;
}

const sill = 0.9;
const head = 2.1;
/** Metres: a line so near to a room's edge is a part of that wall, and a window or door may stand deeper in it. */
const near = 0.06;
const deep = 0.35;
/** Narrower gaps are corners and frames. */
const leastOpening = 0.3;

type Interval = readonly [number, number];
type Point = readonly [number, number];

/** Corners counter-clockwise, as seen from above. */
export function pointsOf(outline: readonly number[]): Point[] {
  const points = Array.from({ length: outline.length >> 1 }, (_, k): Point => [outline[2 * k]!, outline[2 * k + 1]!]);
  const area = points.reduce((sum, [x, y], k) => {
    const [nx, ny] = points[(k + 1) % points.length]!;
    return sum + x * ny - nx * y;
  }, 0);
  return area < 0 ? points.reverse() : points;
}

/** Where along the edge from a to b lines lie, metres from a: those within `within` of it and along it. */
function along(lines: Lines, a: Point, b: Point, within: number): Interval[] {
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
  const [ux, uy] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
  const found: Interval[] = [];
  for (let k = 0; k + 3 < lines.length; k += 4) {
    const [p, q] = [[lines[k]!, lines[k + 1]!], [lines[k + 2]!, lines[k + 3]!]].map(([x, y]) =>
      [(x! - a[0]) * ux + (y! - a[1]) * uy, (y! - a[1]) * ux - (x! - a[0]) * uy]) as [number[], number[]];
    if (Math.abs(p[1]!) > within || Math.abs(q[1]!) > within) continue;
    const [from, to] = [Math.max(Math.min(p[0]!, q[0]!), 0), Math.min(Math.max(p[0]!, q[0]!), length)];
    if (to > from + 1e-3) found.push([from, to]);
  }
  return found;
}

/** Sorted, without overlaps, gaps of less than `least` closed. */
function union(intervals: readonly Interval[], least: number): Interval[] {
  const sorted = [...intervals].sort((p, q) => p[0] - q[0]);
  const out: [number, number][] = [];
  for (const [from, to] of sorted) {
    const last = out.at(-1);
    if (last && from <= last[1] + least) last[1] = Math.max(last[1], to);
    else out.push([from, to]);
  }
  return out;
}

/** What is left of 0 to `length`. */
function gaps(covered: readonly Interval[], length: number, least: number): Interval[] {
  const out: Interval[] = [];
  let at = 0;
  for (const [from, to] of [...covered, [length, length] as const]) {
    if (from - at >= least) out.push([at, from]);
    at = Math.max(at, to);
  }
  return out;
}

/**
 * The walls around a room, with the openings that the plan's lines leave: doors up to 2.1 m, windows from 0.9 m.
 * @param height of the walls, metres
 */
export function wallsOf(room: Room, storey: PlanStorey, height: number): WallPart[] {
  const corners = pointsOf(room.outline);
  const parts: WallPart[] = [];
  corners.forEach((a, k) => {
    const b = corners[(k + 1) % corners.length]!;
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (length < 1e-3) return;
    const at = (t: number): Point => [a[0] + ((b[0] - a[0]) * t) / length, a[1] + ((b[1] - a[1]) * t) / length];
    const add = ([from, to]: Interval, low: number, high: number, glass = false) => {
      if (high > low) parts.push({ a: at(from), b: at(to), low, high, glass });
    };
    const windows = union(along(storey.windows, a, b, deep), 0.05).filter(([from, to]) => to - from >= leastOpening);
    const doors = union(along(storey.doors, a, b, deep), 0.05).filter(([from, to]) => to - from >= 2 * leastOpening);
    const walls = union(along(storey.walls, a, b, near), leastOpening);
    const overlaps = ([from, to]: Interval, others: readonly Interval[]) => others.some(([p, q]) => p < to && q > from);
    const open = union([...gaps(walls, length, leastOpening).filter((gap) => !overlaps(gap, windows)), ...doors], 0.05);
    const glazed = windows.filter((window) => !overlaps(window, open));
    for (const gap of gaps(union([...open, ...glazed], 0.01), length, 0.01)) add(gap, 0, height);
    for (const gap of open) add(gap, Math.min(head, height), height);
    for (const window of glazed) {
      add(window, 0, sill);
      add(window, sill, Math.min(head, height), true);
      add(window, Math.min(head, height), height);
    }
  });
  return parts;
}

/** Outlines of things: hulls of the lines that hang together. */
export function things(lines: Lines): Point[][] {
  const parent = new Map<string, string>();
  const find = (key: string): string => {
    let root = key;
    while (parent.get(root)! !== root) root = parent.get(root)!;
    parent.set(key, root);
    return root;
  };
  const keyOf = (x: number, y: number) => `${Math.round(x * 100)},${Math.round(y * 100)}`; // 1 cm
  const ends: [string, Point][] = [];
  for (let k = 0; k + 3 < lines.length; k += 4) {
    const [p, q] = [[lines[k]!, lines[k + 1]!], [lines[k + 2]!, lines[k + 3]!]] as [Point, Point];
    const [kp, kq] = [keyOf(...p), keyOf(...q)];
    for (const key of [kp, kq]) if (!parent.has(key)) parent.set(key, key);
    parent.set(find(kp), find(kq));
    ends.push([kp, p], [kq, q]);
  }
  const groups = new Map<string, Point[]>();
  for (const [key, point] of ends) {
    const root = find(key);
    groups.set(root, [...(groups.get(root) ?? []), point]);
  }
  return [...groups.values()].map(hull).filter((ring) => ring.length >= 3);
}

/** Counter-clockwise (Andrew's monotone chain). */
function hull(points: readonly Point[]): Point[] {
  const sorted = [...points].sort((p, q) => p[0] - q[0] || p[1] - q[1]);
  const half = (order: readonly Point[]): Point[] => {
    const chain: Point[] = [];
    for (const p of order) {
      while (chain.length >= 2) {
        const [a, b] = [chain.at(-2)!, chain.at(-1)!];
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 1e-9) break;
        chain.pop();
      }
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}
