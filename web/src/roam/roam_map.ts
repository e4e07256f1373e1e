/** The plan of the user's storey: walkable floor, rooms, an episode's path, the user's walk. */
import { toDegrees, type Vec3 } from '../geometry/geometry.ts';
import type { Plan, Scan } from '../scan/scan.ts';
import { shape } from '../elements/svg.ts';
import { letters, margin, roomsOf, scaleBar, storeyShapes } from '../viewer/plan_shapes.ts';
import { storeyAt } from './storeys.ts';
import type { Walker } from './walker.ts';

export class RoamMap {
  readonly element = shape('svg', { class: 'enfilade-map', role: 'img', 'aria-label': 'Floor plan; the arrow shows where you stand and look' });
  private readonly walker: Walker;
  private readonly floors: readonly number[];
  private readonly you = shape('g', { class: 'you' });
  private readonly route = shape('g', { class: 'route' });
  private readonly trail = shape('polyline', { class: 'walk' });
  private plan: Plan | undefined;
  private episode: { readonly start: Vec3; readonly path: readonly Vec3[]; readonly goals: readonly Vec3[] } | undefined;
  private shown = -1;
  private part = -1;

  constructor(walker: Walker, scan: Scan) {
    this.walker = walker;
    this.floors = scan.storeys.map(({ floor }) => floor);
    this.you.append(shape('path', { d: 'M0 0 L-0.7 -1.2 A1.4 1.4 0 0 1 0.7 -1.2 Z', class: 'sight' }), shape('circle', { r: 0.22 }));
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
    this.you.setAttribute('transform', `translate(${x} ${-y}) rotate(${toDegrees(heading)})`);
    this.trail.setAttribute('points', this.pointsOf(this.walker.trail));
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
    this.element.setAttribute('viewBox', [left, top, width, height + 2 * size].join(' '));
    const [rooms, ...lines] = storeyShapes(this.plan, this.shown, size);
    this.drawRoute();
    this.element.replaceChildren(...(rooms ? [rooms] : []), walkable, ...lines, this.route, this.you,
      scaleBar(left + margin / 2, top + height + size, width / 3, size));
  }

  private drawRoute(): void {
    const { start, path, goals } = this.episode ?? { path: [], goals: [] };
    const mark = ([x, y, z]: Vec3, name: string) =>
      (this.storey(z) === this.shown ? [shape('circle', { cx: x, cy: -y, r: 0.3, class: name })] : []);
    this.route.replaceChildren(shape('polyline', { points: this.pointsOf(path), class: 'path' }), this.trail,
      ...(start ? mark(start, 'start') : []), ...goals.flatMap((goal) => mark(goal, 'goal')));
    this.trail.setAttribute('points', this.pointsOf(this.walker.trail));
  }
}
