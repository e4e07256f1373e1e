/** Objects outlined in the view: lines over the picture, of what is seen from where one stands. */
import { type Camera, type Direction, project, unitVector, type Vec3 } from '../geometry/geometry.ts';
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

const origin: Vec3 = [0, 0, 0];

type Point = readonly [number, number] | undefined;

/** Where the rim's points are in the picture; nothing for those behind the camera. */
export function rimInView(rim: readonly number[], camera: Camera, look: Direction): Point[] {
  const points: Point[] = [];
  for (let k = 0; k + 1 < rim.length; k += 2) points.push(project(camera, look, origin, unitVector({ heading: rim[k]!, elevation: rim[k + 1]! })));
  return points;
}

/** The path of an SVG line through the points, closed; broken where points are missing. */
export function pathOf(points: readonly Point[]): string {
  let d = '';
  let on = false;
  for (const point of [...points, points[0]]) {
    if (point) d += `${on ? 'L' : 'M'}${point[0].toFixed(1)} ${point[1].toFixed(1)}`;
    on = point !== undefined;
  }
  return d;
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
    this.element.replaceChildren(...shown.flatMap((outline) => this.shapes(outline, camera, look)));
  }

  private shapes({ rim, label }: Outline, camera: Camera, look: Direction): SVGElement[] {
    const points = rimInView(rim, camera, look);
    const d = pathOf(points);
    const seen = points.filter((point) => point !== undefined)
      .filter(([x, y]) => x >= 0 && y >= 0 && x <= camera.width && y <= camera.height);
    if (seen.length === 0) return []; // beside the picture
    const lines = [shape('path', { d, class: 'edge' }), shape('path', { d, class: 'line' })];
    if (!label) return lines;
    const [x, y] = seen.reduce((top, point) => (point[1] < top[1] ? point : top));
    return [...lines, shape('text', { x, y: Math.max(y - 8, 16) }, label)];
  }
}
