/** The plan of the user's storey: walkable floor, rooms, an episode's path, the user's walk. */
import { toDegrees, type Vec3 } from '../geometry/geometry.ts';
import type { Plan, Scan } from '../scan/scan.ts';
import { make } from '../elements/page.ts';
import { shape } from '../elements/svg.ts';
import { letters, margin, roomsOf, scaleBar, storeyShapes } from '../viewer/plan_shapes.ts';
import { storeyAt } from './storeys.ts';
import type { Walker } from './walker.ts';

/** Milliseconds between two drawings of the user's walk. */
const trailEvery = 500;
/** Width of the arrow, metres. */
const arrowSize = 3;

/** Without a GPU a plan takes longer to draw than a frame of the walk: while one walks only the arrow moves, which lies above it by itself. */
export class RoamMap {
  readonly element = make('div', { class: 'roam-map' });
  private readonly picture = shape('svg', {
    class: 'enfilade-map', role: 'img', 'aria-label': 'Floor plan; the arrow shows where you stand and look',
  });
  private readonly walker: Walker;
  private readonly floors: readonly number[];
  private readonly you = shape('svg', {
    class: 'roam-you', viewBox: [-arrowSize / 2, -arrowSize / 2, arrowSize, arrowSize].join(' '), 'aria-hidden': 'true',
  });
  private readonly route = shape('g', { class: 'route' });
  private readonly trail = shape('polyline', { class: 'walk' });
  private plan: Plan | undefined;
  private episode: { readonly start: Vec3; readonly path: readonly Vec3[]; readonly goals: readonly Vec3[] } | undefined;
  private shown = -1;
  private part = -1;
  /** The part that is drawn, metres: left, top, width, height. */
  private box: readonly [number, number, number, number] = [0, 0, 1, 1];
  /** Where its corner lies in the element, and pixels a metre. */
  private fit = { left: 0, top: 0, scale: 1 };
  private timer = 0;

  /** @param pick a click on the plan: a place on the floor of the storey that is shown */
  constructor(walker: Walker, scan: Scan, pick: (at: Vec3) => void) {
    this.walker = walker;
    this.floors = scan.storeys.map(({ floor }) => floor);
    this.you.append(shape('path', { d: 'M0 0 L-0.7 -1.2 A1.4 1.4 0 0 1 0.7 -1.2 Z', class: 'sight' }), shape('circle', { r: 0.22 }));
    this.element.append(this.picture, this.you);
    this.element.addEventListener('click', (event) => {
      const { left, top } = this.element.getBoundingClientRect();
      const [x, y] = [(event.clientX - left - this.fit.left) / this.fit.scale, (event.clientY - top - this.fit.top) / this.fit.scale];
      pick([this.box[0] + x, -(this.box[1] + y), this.floors[this.shown] ?? this.walker.position[2]]);
    });
    new ResizeObserver(() => this.resize()).observe(this.element);
    walker.onChange(() => this.follow());
    this.follow();
  }

  setPlan(plan: Plan): void {
    this.plan = plan;
    this.draw();
  }

  setEpisode(start: Vec3, path: readonly Vec3[], goals: readonly Vec3[]): void {
    this.episode = { start, path, goals };
    this.draw();
  }

  private storey(z: number): number {
    return storeyAt(this.floors, z);
  }

  private follow(): void {
    const { position: [x, y, z], heading } = this.walker;
    const storey = this.storey(z);
    if (storey !== this.shown || this.walker.part !== this.part) {
      [this.shown, this.part] = [storey, this.walker.part];
      this.draw();
    }
    const { left, top, scale } = this.fit;
    this.you.style.transform = `translate(${left + (x - this.box[0]) * scale}px, ${top + (-y - this.box[1]) * scale}px) `
      + `translate(-50%, -50%) rotate(${toDegrees(heading)}deg)`;
    if (this.timer === 0) this.timer = window.setTimeout(() => this.drawTrail(), trailEvery);
  }

  /** As browsers fit the picture into the element: whole, in the middle. */
  private resize(): void {
    const [, , width, height] = this.box;
    const { clientWidth, clientHeight } = this.element;
    const scale = Math.min(clientWidth / width, clientHeight / height);
    this.fit = { left: (clientWidth - width * scale) / 2, top: (clientHeight - height * scale) / 2, scale };
    this.you.style.width = this.you.style.height = `${arrowSize * scale}px`;
    this.follow();
  }

  private drawTrail(): void {
    clearTimeout(this.timer);
    this.timer = 0;
    const points = this.pointsOf(this.walker.trail);
    if (this.trail.getAttribute('points') !== points) this.trail.setAttribute('points', points);
  }

  private pointsOf(line: readonly Vec3[]): string {
    return line.filter(([, , z]) => this.storey(z) === this.shown).map(([x, y]) => `${x},${-y}`).join(' ');
  }

  private draw(): void {
    const walkable = shape('g', { class: 'walkable' });
    const xs: number[] = [];
    const ys: number[] = [];
    for (let p = 0; p < this.walker.floor.size; ++p) {
      const { corners, height } = this.walker.floor.outline(p);
      if (this.storey(height) !== this.shown || this.walker.floor.part(p) !== this.part) continue;
      const points = corners.map((value, k) => (k % 2 === 0 ? value : -value));
      points.forEach((value, k) => (k % 2 === 0 ? xs : ys).push(value));
      walkable.append(shape('polygon', { points: points.join(' ') }));
    }
    for (const { outline } of roomsOf(this.plan, this.shown)) {
      outline.forEach((value, k) => (k % 2 === 0 ? xs.push(value) : ys.push(-value)));
    }
    const least = (values: readonly number[]) => values.reduce((a, b) => Math.min(a, b), Infinity);
    const most = (values: readonly number[]) => values.reduce((a, b) => Math.max(a, b), -Infinity);
    const [left, top] = [least(xs) - margin, least(ys) - margin];
    const [width, height] = [most(xs) + margin - left, most(ys) + margin - top];
    if (!Number.isFinite(width + height)) return;
    const size = Math.max(width, height) * letters;
    this.box = [left, top, width, height + 2 * size];
    this.picture.setAttribute('viewBox', this.box.join(' '));
    const [rooms, ...lines] = storeyShapes(this.plan, this.shown, size);
    this.drawRoute();
    this.picture.replaceChildren(...(rooms ? [rooms] : []), walkable, ...lines, this.route,
      scaleBar(left + margin / 2, top + height + size, width / 3, size));
    this.resize();
  }

  private drawRoute(): void {
    const { start, path, goals } = this.episode ?? { path: [], goals: [] };
    const mark = ([x, y, z]: Vec3, name: string) =>
      (this.storey(z) === this.shown ? [shape('circle', { cx: x, cy: -y, r: 0.3, class: name })] : []);
    this.route.replaceChildren(shape('polyline', { points: this.pointsOf(path), class: 'path' }), this.trail,
      ...(start ? mark(start, 'start') : []), ...goals.flatMap((goal) => mark(goal, 'goal')));
    this.drawTrail();
  }
}
