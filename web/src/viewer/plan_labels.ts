/** Where a room's name stands on a plan, y pointing down: within the room, and beside the discs of viewpoints. */

/** Metres. */
export interface Disc {
  readonly x: number;
  readonly y: number;
  readonly radius: number;
}

interface Label {
  readonly lines: readonly string[];
  /** Its middle, metres. */
  readonly x: number;
  readonly y: number;
}

/** A letter's width as a share of its size; a mean over words. */
const letterWidth = 0.56;
/** Places that are tried from side to side of a room, and from top to bottom. */
const tries = 15;

/** Whether a point lies in a polygon; x and y in turn. */
function isInside(outline: readonly number[], x: number, y: number): boolean {
  let inside = false;
  for (let k = 0, n = outline.length / 2; k < n; ++k) {
    const [x1, y1, x2, y2] = [outline[2 * k]!, outline[2 * k + 1]!, outline[2 * ((k + 1) % n)]!, outline[2 * ((k + 1) % n) + 1]!];
    if ((y1 > y) !== (y2 > y) && x < x1 + ((x2 - x1) * (y - y1)) / (y2 - y1)) inside = !inside;
  }
  return inside;
}

/** How deep a disc reaches into a box around a point, as a share of the disc; 0: not at all. */
function overlap({ x, y, radius }: Disc, at: readonly [number, number], half: readonly [number, number]): number {
  const [dx, dy] = [Math.max(Math.abs(x - at[0]) - half[0], 0), Math.max(Math.abs(y - at[1]) - half[1], 0)];
  return Math.max(0, 1 - Math.hypot(dx, dy) / radius);
}

/**
 * The place that hides least, as near to the room's middle as may be. Nothing where the name does not fit: it says less
 * than the furniture that it would hide.
 * @param outline of the plan: corners in order, x and y in turn, y up  @param size of letters, metres
 */
export function placeLabel(name: string, outline: readonly number[], size: number, discs: readonly Disc[]): Label | undefined {
  const corners = outline.map((value, k) => (k % 2 === 0 ? value : -value));
  const [xs, ys] = [0, 1].map((which) => corners.filter((_, k) => k % 2 === which)) as [number[], number[]];
  const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const words = name.split(' ');
  let best: Label | undefined;
  let least = Infinity;
  for (const lines of words.length > 1 ? [words, [name]] : [words]) {
    const half = [(letterWidth * size * Math.max(...lines.map((line) => line.length))) / 2, (lines.length * size) / 2] as const;
    const [freeX, freeY] = [(right - left) / 2 - half[0], (bottom - top) / 2 - half[1]];
    if (freeX < 0 || freeY < 0) continue;
    for (let k = 0; k < tries * tries; ++k) {
      const [across, down] = [((k % tries) / (tries - 1)) * 2 - 1, (Math.floor(k / tries) / (tries - 1)) * 2 - 1];
      const at = [(left + right) / 2 + across * freeX, (top + bottom) / 2 + down * freeY] as const;
      const outside = [[-1, -1], [1, -1], [-1, 1], [1, 1]].filter(([x, y]) =>
        !isInside(corners, at[0] + x! * half[0] * 0.98, at[1] + y! * half[1] * 0.98)).length;
      const hidden = discs.reduce((sum, disc) => sum + overlap(disc, at, half), 0);
      const cost = 20 * hidden + outside + 0.1 * Math.hypot(across, down);
      if (cost < least - 1e-9) [best, least] = [{ lines, x: at[0], y: at[1] }, cost];
    }
  }
  return best;
}
