/** A position and direction on a floor, moved by the actions of R2R-CE or smoothly. Draws nothing. */
import { type Direction, type Vec3, wrapHeading } from '../geometry/geometry.ts';
import type { Floor, FloorPoint } from './floor.ts';

export type Action = 'forward' | 'left' | 'right' | 'up' | 'down';

/** A point of the own walk is kept when it is so far from the last one, metres. */
const apart = 0.2;

export class Walker {
  readonly floor: Floor;
  private at: FloorPoint;
  private looking: Direction;
  /** Whole turns by actions since the heading was set: 24 of 15 degrees are none. */
  private turns = 0;
  private base: number;
  private readonly line: Vec3[] = [];
  private walked = 0;
  private touched = 0;
  private acted = 0;
  private readonly listeners = new Set<() => void>();

  constructor(floor: Floor, at: FloorPoint, looking: Direction) {
    this.floor = floor;
    this.at = at;
    this.base = wrapHeading(looking.heading);
    this.looking = { heading: this.base, elevation: looking.elevation };
    this.line.push(at.position);
  }

  /** Of the feet. */
  get position(): Vec3 {
    return this.at.position;
  }
  /** The feet, and the part of the floor under them. */
  get standing(): FloorPoint {
    return this.at;
  }
  /** The connected part of the floor where one can get to. */
  get part(): number {
    return this.floor.part(this.at.polygon);
  }
  get heading(): number {
    return this.looking.heading;
  }
  get elevation(): number {
    return this.looking.elevation;
  }
  get eye(): Vec3 {
    const [x, y, z] = this.at.position;
    return [x, y, z + this.floor.data.walker.eye];
  }
  /** The walk since the start, as a line. */
  get trail(): readonly Vec3[] {
    return this.line;
  }
  /** Metres. */
  get length(): number {
    return this.walked;
  }
  /** Steps forward that a wall cut short. */
  get collisions(): number {
    return this.touched;
  }
  get actions(): number {
    return this.acted;
  }

  onChange(listener: () => void): void {
    this.listeners.add(listener);
  }

  /** One action, as the simulator does it. Returns whether a wall was touched. */
  act(action: Action): boolean {
    const { forward, turn, look } = this.floor.data.walker;
    ++this.acted;
    let touched = false;
    if (action === 'forward') {
      touched = this.move(forward * Math.sin(this.heading), forward * Math.cos(this.heading));
      if (touched) ++this.touched;
    } else if (action === 'up' || action === 'down') {
      this.setElevation(this.elevation + (action === 'up' ? look : -look));
    } else {
      this.turns += action === 'right' ? 1 : -1;
      const whole = Math.round((2 * Math.PI) / turn);
      if (Math.abs(whole * turn - 2 * Math.PI) < 1e-9) this.turns %= whole;
      this.looking = { ...this.looking, heading: wrapHeading(this.base + this.turns * turn) };
    }
    this.tell();
    return touched;
  }

  /** Moves smoothly: metres ahead and to the right. Returns whether a wall was touched. */
  glide(ahead: number, right: number): boolean {
    const [s, c] = [Math.sin(this.heading), Math.cos(this.heading)];
    const touched = this.move(ahead * s + right * c, ahead * c - right * s);
    this.tell();
    return touched;
  }

  look(heading: number, elevation: number): void {
    if (wrapHeading(heading) !== this.heading) {
      this.base = wrapHeading(heading);
      this.turns = 0;
    }
    this.looking = { heading: wrapHeading(this.base + this.turns * this.floor.data.walker.turn), elevation: this.elevation };
    this.setElevation(elevation);
    this.tell();
  }

  /** Starts anew somewhere else. */
  place(at: FloorPoint, looking?: Direction): void {
    this.at = at;
    [this.walked, this.touched, this.acted] = [0, 0, 0];
    this.line.splice(0, this.line.length, at.position);
    if (looking) this.look(looking.heading, looking.elevation);
    else this.tell();
  }

  private setElevation(elevation: number): void {
    const most = this.floor.data.walker.most_elevation;
    this.looking = { ...this.looking, elevation: Math.min(Math.max(elevation, -most), most) };
  }

  private move(dx: number, dy: number): boolean {
    const { end, atWall } = this.floor.walk(this.at, dx, dy);
    this.walked += Math.hypot(end.position[0] - this.position[0], end.position[1] - this.position[1]);
    this.at = end;
    const last = this.line.at(-1)!;
    if (Math.hypot(end.position[0] - last[0], end.position[1] - last[1]) >= apart) this.line.push(end.position);
    return atWall;
  }

  private tell(): void {
    for (const listener of this.listeners) listener();
  }
}
