/** A floor plan of the storey one is on: viewpoints, edges, where one looks, a path. */
import { toDegrees } from '../geometry.ts';
import type { Viewer } from './viewer.ts';

const namespace = 'http://www.w3.org/2000/svg';
/** Around the viewpoints, metres. */
const margin = 1;

function shape(name: string, attributes: Record<string, string | number>): SVGElement {
  const element = document.createElementNS(namespace, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  return element;
}

/** North (+y) is up. Follows a viewer; a click on a viewpoint goes there. */
export class MiniMap {
  readonly element = document.createElementNS(namespace, 'svg');
  private readonly viewer: Viewer;
  private readonly you = shape('g', { class: 'you' });
  private readonly route = shape('g', { class: 'route' });
  private readonly end: () => void;
  private path: readonly number[] = [];
  private walk: readonly number[] = [];
  private storey = -1;

  constructor(viewer: Viewer) {
    this.viewer = viewer;
    this.element.classList.add('enfilade-map');
    this.element.setAttribute('role', 'img');
    this.element.setAttribute('aria-label', 'Floor plan; the arrow shows where you look');
    // A sector of 60 degrees that looks up, turned with the heading.
    this.you.append(
      shape('path', { d: 'M0 0 L-0.7 -1.2 A1.4 1.4 0 0 1 0.7 -1.2 Z', class: 'sight' }),
      shape('circle', { r: 0.22 }),
    );
    this.end = viewer.onChange(() => this.follow());
    this.follow();
  }

  /** A path, and a walk that somebody took for it; empty: none. */
  setPath(path: readonly number[], walk: readonly number[] = []): void {
    this.path = path;
    this.walk = walk;
    this.drawRoute();
  }

  /** After the viewer's graph was changed. */
  redraw(): void {
    this.drawStorey();
  }

  dispose(): void {
    this.end();
    this.element.remove();
  }

  private at(viewpoint: number): [number, number] {
    const [x, y] = this.viewer.scan.viewpoints[viewpoint]!.position;
    return [x, -y]; // SVG's y points down
  }

  private follow(): void {
    const { viewpoint, heading } = this.viewer.pose;
    const storey = this.viewer.scan.storeys.findIndex((s) => s.viewpoints.includes(viewpoint));
    if (storey !== this.storey) {
      this.storey = storey;
      this.drawStorey();
    }
    const [x, y] = this.at(viewpoint);
    this.you.setAttribute('transform', `translate(${x} ${y}) rotate(${toDegrees(heading)})`);
  }

  private drawStorey(): void {
    const { scan } = this.viewer;
    const here = new Set(scan.storeys[this.storey]?.viewpoints ?? []);
    const places = [...here].map((v) => this.at(v));
    const xs = places.map(([x]) => x);
    const ys = places.map(([, y]) => y);
    const [left, top] = [Math.min(...xs) - margin, Math.min(...ys) - margin];
    this.element.setAttribute(
      'viewBox',
      [left, top, Math.max(...xs) + margin - left, Math.max(...ys) + margin - top].join(' '),
    );
    const edges = shape('g', { class: 'edges' });
    const dots = shape('g', { class: 'dots' });
    for (const v of here) {
      const [x1, y1] = this.at(v);
      for (const other of scan.viewpoints[v]!.neighbours) {
        if (!here.has(other) || other < v) continue;
        const [x2, y2] = this.at(other);
        edges.append(shape('line', { x1, y1, x2, y2 }));
      }
      const dot = shape('circle', { cx: x1, cy: y1, r: 0.16 });
      dot.addEventListener('click', () => void this.viewer.go(v));
      dots.append(dot);
    }
    this.element.replaceChildren(edges, this.route, dots, this.you);
    this.drawRoute();
  }

  private drawRoute(): void {
    const here = new Set(this.viewer.scan.storeys[this.storey]?.viewpoints ?? []);
    const line = (path: readonly number[], name: string) => {
      const points = path.filter((v) => here.has(v)).map((v) => this.at(v).join(','));
      return shape('polyline', { points: points.join(' '), class: name });
    };
    const ends: [string, number | undefined][] = [
      ['start', this.path[0]],
      ['goal', this.path.at(-1)],
      ['stop', this.walk.at(-1)],
    ];
    this.route.replaceChildren(line(this.path, 'path'), line(this.walk, 'walk'));
    for (const [name, v] of ends) {
      if (v === undefined || !here.has(v)) continue;
      const [cx, cy] = this.at(v);
      this.route.append(shape('circle', { cx, cy, r: name === 'stop' ? 0.45 : 0.3, class: name }));
    }
  }
}
