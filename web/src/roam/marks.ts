/** What is drawn on the floor: an episode's start, path and goal, and the user's walk. */
import * as three from 'three';
import type { Vec3 } from '../geometry/geometry.ts';

const colours = { start: 0x0aa36b, goal: 0xe8453c, path: 0x1f6ff0, walk: 0xb02a8f, you: 0xd97a00 } as const;
/** Above the floor, metres: bands do not flicker against it. */
const lift = 0.03;

/** A band on the floor along a line. */
function band(line: readonly Vec3[], width: number, above: number): three.BufferGeometry {
  const positions: number[] = [];
  const index: number[] = [];
  const put = (a: Vec3, b: Vec3) => {
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    const length = Math.hypot(dx, dy);
    if (length < 1e-6) return;
    const [nx, ny] = [(-dy / length) * (width / 2), (dx / length) * (width / 2)];
    const first = positions.length / 3;
    for (const [p, side] of [[a, 1], [a, -1], [b, -1], [b, 1]] as const) positions.push(p[0] + side * nx, p[1] + side * ny, p[2] + above);
    index.push(first, first + 1, first + 2, first, first + 2, first + 3);
  };
  line.slice(1).forEach((b, k) => put(line[k]!, b));
  // Round joints.
  const corners = 12;
  for (const [x, y, z] of line) {
    const first = positions.length / 3;
    positions.push(x, y, z + above);
    for (let k = 0; k < corners; ++k) {
      const angle = (2 * Math.PI * k) / corners;
      positions.push(x + (width / 2) * Math.cos(angle), y + (width / 2) * Math.sin(angle), z + above);
      index.push(first, first + 1 + k, first + 1 + ((k + 1) % corners));
    }
  }
  const geometry = new three.BufferGeometry();
  geometry.setAttribute('position', new three.Float32BufferAttribute(positions, 3));
  geometry.setIndex(index);
  return geometry;
}

const paint = (color: number): three.MeshBasicMaterial => new three.MeshBasicMaterial({ color, side: three.DoubleSide });

function pole(at: Vec3, color: number): three.Group {
  const group = new three.Group();
  const disc = new three.Mesh(new three.CircleGeometry(0.2, 24), paint(color));
  disc.position.z = 2 * lift;
  const staff = new three.Mesh(new three.CylinderGeometry(0.03, 0.03, 0.9, 10), paint(color));
  staff.rotation.x = Math.PI / 2;
  staff.position.z = 0.45;
  const ball = new three.Mesh(new three.SphereGeometry(0.11, 16, 12), paint(color));
  ball.position.z = 0.95;
  group.add(disc, staff, ball);
  group.position.set(...at);
  return group;
}

export class Marks {
  readonly group = new three.Group();
  private readonly episode = new three.Group();
  private readonly trail = new three.Mesh(new three.BufferGeometry(), paint(colours.walk));
  private readonly you = new three.Group();
  private drawn: { readonly last?: Vec3; readonly length: number } = { length: 0 };

  constructor() {
    const ball = new three.Mesh(new three.SphereGeometry(0.2, 16, 12), paint(colours.you));
    const arrow = new three.Mesh(new three.ConeGeometry(0.18, 0.6, 16), paint(colours.you)); // along +y, as a heading of 0
    arrow.position.y = 0.45;
    this.you.add(ball, arrow);
    this.trail.frustumCulled = false;
    this.group.add(this.episode, this.trail, this.you);
  }

  setEpisode(start: Vec3, path: readonly Vec3[], goals: readonly Vec3[]): void {
    this.episode.clear();
    if (path.length > 1) this.episode.add(new three.Mesh(band(path, 0.14, lift), paint(colours.path)));
    this.episode.add(pole(start, colours.start), ...goals.map((goal) => pole(goal, colours.goal)));
  }

  setTrail(line: readonly Vec3[]): void {
    if (line.at(-1) === this.drawn.last && line.length === this.drawn.length) return; // it is asked for with every frame
    this.drawn = { last: line.at(-1)!, length: line.length };
    this.trail.geometry.dispose();
    this.trail.geometry = band(line, 0.09, lift * 1.5);
  }

  /** The user's position: seen from outside only. */
  setYou([x, y, z]: Vec3, heading: number): void {
    this.you.position.set(x, y, z + 1);
    this.you.rotation.z = -heading;
  }

  /** @param ceiling nothing stands above that is seen */
  show(outside: boolean, ceiling = Infinity): void {
    this.you.visible = outside && this.you.position.z - 1 < ceiling;
    this.episode.children.forEach((child) => (child.visible = !(child instanceof three.Group) || child.position.z < ceiling));
  }
}
