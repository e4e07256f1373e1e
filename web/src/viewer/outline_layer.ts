/** Objects outlined in the view: lines over the picture, of what is seen from where one stands. */
import { apply, type Camera, type Direction, mix, transpose, unitVector, type Vec3, worldFromCamera } from '../geometry/geometry.ts';
import { shape } from '../elements/svg.ts';

/** A closed line around an object as one viewpoint sees it. */
export interface Outline {
  /** Index into Scan.viewpoints. */
  readonly viewpoint: number;
  /** May be empty. */
  readonly label: string;
  /** Headings and elevations in turn, radians. */
  readonly rim: readonly number[];
}

/** Pixels. */
type Point = readonly [number, number];

/** A unit vector's part along the view, 87 degrees from its middle. Farther to the side nothing can be drawn, and nothing is seen. */
const leastAhead = 0.05;

/** The corners of a rim in the picture, and where it is cut off beside the camera. Empty if it is behind. */
export function rimInView(rim: readonly number[], { width, height, vfov }: Camera, look: Direction): Point[] {
  const cameraFromWorld = transpose(worldFromCamera(look));
  const corners: Vec3[] = [];
  for (let k = 0; k + 1 < rim.length; k += 2) corners.push(apply(cameraFromWorld, unitVector({ heading: rim[k]!, elevation: rim[k + 1]! })));
  const kept = corners.flatMap((corner, k) => {
    const before = corners.at(k - 1)!;
    const cut = mix(before, corner, (leastAhead - before[2]) / (corner[2] - before[2]));
    return [...((before[2] > leastAhead) === (corner[2] > leastAhead) ? [] : [cut]), ...(corner[2] > leastAhead ? [corner] : [])];
  });
  const focal = height / 2 / Math.tan(vfov / 2);
  return kept.map(([x, y, z]) => [width / 2 + (focal * x) / z, height / 2 + (focal * y) / z]);
}

/** The path of a closed SVG line through the points. */
export const pathOf = (points: readonly Point[]): string =>
  (points.length === 0 ? '' : `M${points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join('L')}Z`);

/** Whether something of what the points surround may be in the picture. */
export function mayBeSeen(points: readonly Point[], { width, height }: Pick<Camera, 'width' | 'height'>): boolean {
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  return Math.max(...xs) > 0 && Math.min(...xs) < width && Math.max(...ys) > 0 && Math.min(...ys) < height;
}

/** A label in the picture: from left to right, and its line, pixels. */
interface LabelPlace {
  readonly left: number;
  readonly right: number;
  readonly y: number;
}

const [letterWidth, lineHeight] = [8.5, 18];

/** The line of a label: its own, or over the labels that are there; its own too where the picture ends before. */
export function freeLine({ left, right, y }: LabelPlace, taken: readonly LabelPlace[]): number {
  const near = taken.filter((one) => one.left < right && left < one.right);
  let free = y;
  for (let over: LabelPlace | undefined; (over = near.find((one) => Math.abs(one.y - free) < lineHeight));) free = over.y - lineHeight;
  return free < lineHeight ? y : free;
}

export class OutlineLayer {
  readonly element = shape('svg', {});
  private outlines: readonly Outline[] = [];

  constructor() {
    this.element.classList.add('enfilade-goal-lines');
    this.element.setAttribute('aria-hidden', 'true'); // the panel beside says what is where
  }

  set(outlines: readonly Outline[]): void {
    this.outlines = outlines;
  }

  /** @param viewpoint where one stands; absent: on the way, where no outline is right */
  draw(viewpoint: number | undefined, camera: Camera, look: Direction): void {
    this.element.setAttribute('viewBox', `0 0 ${camera.width} ${camera.height}`);
    const shown = this.outlines.filter((outline) => outline.viewpoint === viewpoint);
    if (shown.length === 0 && this.element.childElementCount === 0) return;
    const labels: LabelPlace[] = [];
    this.element.replaceChildren(...shown.flatMap((outline) => this.shapes(outline, camera, look, labels)));
  }

  /** @param labels those of the outlines before, to which this one's is added */
  private shapes({ rim, label }: Outline, camera: Camera, look: Direction, labels: LabelPlace[]): SVGElement[] {
    const points = rimInView(rim, camera, look);
    if (!mayBeSeen(points, camera)) return [];
    const d = pathOf(points);
    const lines = [shape('path', { d, class: 'edge' }), shape('path', { d, class: 'line' })];
    if (!label) return lines;
    const [x, y] = points.reduce((top, point) => (point[1] < top[1] ? point : top));
    // Within the picture as a whole: it begins, ends or stands over its point, by where that is.
    const at = Math.min(Math.max(x, 0), camera.width);
    const anchor = at < camera.width / 3 ? 'start' : at > (camera.width * 2) / 3 ? 'end' : 'middle';
    const width = letterWidth * label.length;
    const left = at - { start: 0, middle: width / 2, end: width }[anchor];
    const place = { left, right: left + width, y: Math.min(Math.max(y - 8, 16), camera.height - 8) };
    labels.push({ ...place, y: freeLine(place, labels) });
    return [...lines, shape('text', { x: at, y: labels.at(-1)!.y, 'text-anchor': anchor }, label)];
  }
}
